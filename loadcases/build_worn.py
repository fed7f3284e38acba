"""From a worn case to its model: tube or panel on a limb, ends and sides, growth of the limb, contact with moving skin.

Everything starts from zero force: a tight piece lies around a limb that is still too thin, which then grows (donning,
travel below 0 in mm) before the joint bends (travel in degrees).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from etextile.lattice.tube import Wrapped, Wrapping, wrap
from etextile.lattice.weave import WEFT
from etextile.types import Array, BoolArray, IntArray
from loadcases.schema_body import LIMBS, LimbMesh


if TYPE_CHECKING:
    from etextile.contact.bending import Bending
    from etextile.lattice.weave import Weave
    from etextile.mechanics.model import Model
    from etextile.mechanics.truss import TrussBlock
    from etextile.motion.band import Band
    from etextile.motion.flexion import Cuffs, Flexion
    from etextile.motion.hold import WeakHold
    from loadcases.schema import Case

STATIONS = 201
"""Places along the limb at which the radius of a piece is laid down."""
LET_GO = 2.0
"""Growth (mm) of the limb over which bands are let go where the fabric itself needs none."""
GROWTH = 8
"""Output points of the growth."""
SKIN_SHEAR = 0.05
"""Shear stiffness of skin and flesh under friction, N/mm per mm2 (estimated: a modulus of 0.1 to 0.5 N/mm2 over the
first few mm); it gives 0.03 mm under 5 kPa at a friction of 0.3, little beside what fabric slides."""
SKIN_OFFSET = 1e-6
"""Distance from the skin at which a panel begins, mm."""


@dataclass(frozen=True)
class Worn:
    """A piece on its limb: lattice and places, the motion of the joint, growth, how nodes are held."""

    piece: Wrapped
    motion: Flexion
    donning: float
    fixed: BoolArray
    cuffs: Cuffs


def limb_of(case: Case) -> Bending:
    """Return the straight limb of a worn case; raises BadInput for dimensions, or files, that make none."""
    from etextile.contact.bodies import LIMBS as BUILDERS

    section = case.body
    if not isinstance(section, LIMBS):
        raise ValueError("the case is not worn")
    return BUILDERS[section.type](**section.model_dump(exclude={"type"}))


def limb_notes(case: Case) -> tuple[str, ...]:
    """Return what is to be known of a limb that comes from files; makes no distance grid."""
    return case.body.measured().notes if isinstance(case.body, LimbMesh) else ()


def wrapped(case: Case, weave: Weave) -> Wrapped:
    """Return the lattice of a worn case around its limb."""
    limb, piece = limb_of(case), case.fabric
    length, width = case.pattern
    reach = 0.5 * length + 1.0
    stations = np.linspace(-reach, reach, STATIONS)
    tube = piece.shape == "tube"
    grown = width / float(limb.girth(np.zeros(1))[0]) if tube else 1.0
    radii = grown * limb.radius(stations) + (0.0 if tube else SKIN_OFFSET)
    wrapping = Wrapping(length, width, stations, radii, closed=tube)
    found = wrap(weave, wrapping, piece.coarsening, half=piece.portion == "half")
    return replace(found, places=found.places + np.array([0.0, *limb.middle]))


def put_on(case: Case, weave: Weave) -> Worn:
    """Return the piece as it begins, and the growth of the limb that brings it to where the joint bends."""
    from etextile.motion.flexion import Flexion

    limb, piece = limb_of(case), wrapped(case, weave)
    too_thick = max(-float(limb.distance(piece.places).gap.min()), 0.0)
    least = LET_GO if "band" in case.supports.ends else 0.0
    donning = max(too_thick if too_thick > 1e-3 else 0.0, least)
    motion = Flexion(limb, donning=donning)
    held = _held(case, piece)
    fixed = np.zeros((len(piece.places), 3), dtype=bool)
    fixed[piece.on_plane, 1] = True
    fixed[held] = True
    return Worn(piece, motion, donning, fixed, _led(motion, np.flatnonzero(held), piece.places))


def _held(case: Case, piece: Wrapped) -> BoolArray:
    """Return the nodes (N,) that move with the limb."""
    edges = piece.lattice.edges
    held: BoolArray = np.zeros(len(piece.places), dtype=np.bool_)
    for name, end in zip(("x_min", "x_max"), case.supports.ends, strict=True):
        if end == "held":
            held |= edges[name]
    if case.supports.sides == "held":
        held |= edges["y_min"] | edges["y_max"]
    return held


def _led(motion: Flexion, nodes: IntArray, places: Array) -> Cuffs:
    """Return nodes that go with the skin from their places, which are on the skin when the limb has grown."""
    from etextile.motion.flexion import Cuffs

    start = places[nodes]
    grown = motion.limb.fitted(start) if motion.donning > 0.0 else start
    return Cuffs(motion, nodes, start, grown, motion.share(start, 0.0))


def worn_model(case: Case, worn: Worn, trusses: TrussBlock, travel: Array) -> Model:
    """Return the model of a worn case without wires and contact."""
    from etextile.mechanics.model import Model

    lattice = worn.piece.lattice
    model = Model(
        lattice=lattice,
        points=worn.piece.places,
        fixed=worn.fixed,
        carried=np.zeros_like(worn.piece.places),
        contributions=(trusses,),
        travel=np.concatenate([_growth(worn.donning), travel]),
        direction=np.zeros(3),
        speed=case.motion.speed,
        force_factor=float(lattice.multiplicity),
        guide=worn.cuffs,
        begins=-worn.donning,
    )
    for end in np.flatnonzero(np.array(case.supports.ends) == "band"):
        model = model.with_contribution(_band(case, worn, ("x_min", "x_max")[end]))
    return model if case.supports.ends == ("held", "held") else model.with_contribution(_weak_hold(worn))


def _growth(donning: float) -> Array:
    """Return the output points of the growth, closer together where yarns take up their first load."""
    return -donning * (1.0 - (np.arange(1, GROWTH + 1) / GROWTH) ** 2) if donning > 0.0 else np.zeros(0)


def _band(case: Case, worn: Worn, edge: str) -> Band:
    """Return the band in an end: its springs lie along the last weft line."""
    from etextile.motion.band import Band

    lattice, places = worn.piece.lattice, worn.piece.places
    along = lattice.edges[edge][lattice.trusses].all(axis=1) & (lattice.family == WEFT)
    nodes = lattice.trusses[along]
    section = case.supports.band
    put_on = np.linalg.norm(places[nodes[:, 1]] - places[nodes[:, 0]], axis=1)
    radius = np.hypot(*(places[nodes[:, 0], 1:] - worn.motion.limb.middle).T)
    on_limb = put_on * worn.motion.limb.radius(places[nodes[:, 0], 0]) / radius
    own = on_limb / (1.0 + section.tension / section.stiffness)
    return Band(nodes, section.stiffness, np.maximum(put_on, own), own, worn.donning)


def _weak_hold(worn: Worn) -> WeakHold:
    """Return the weak hold of the whole piece."""
    from etextile.motion.flexion import Cuffs
    from etextile.motion.hold import WEAK, WeakHold

    lattice, places = worn.piece.lattice, worn.piece.places
    nodes = np.flatnonzero(~worn.fixed.all(axis=1))
    led = Cuffs(worn.motion, nodes, places[nodes], places[nodes], worn.motion.share(places[nodes], 0.0))
    return WeakHold(nodes[:, None], led, WEAK * lattice.cell_area * lattice.share[nodes])


def with_skin(case: Case, model: Model, worn: Worn, penalty: float) -> Model:
    """Return the model in contact with the limb, whose skin is rougher under bands."""
    from etextile.contact.contact import Contact

    lattice, limb = worn.piece.lattice, worn.motion.limb
    friction = np.inf if case.contact.friction == "stick" else float(case.contact.friction)
    free = np.asarray(~worn.fixed.all(axis=1))
    banded: BoolArray = np.zeros(len(worn.fixed), dtype=np.bool_)
    for name, end in zip(("x_min", "x_max"), case.supports.ends, strict=True):
        if end == "band":
            banded |= lattice.edges[name] & free
    for chosen, rough in ((free & ~banded, friction), (banded, max(friction, case.supports.band.skin_friction))):
        nodes = np.flatnonzero(chosen)
        if len(nodes):
            contact = Contact(
                nodes=nodes[:, None],
                share=lattice.share[nodes],
                body=limb,
                motion=worn.motion,
                friction=rough,
                max_penetration=case.contact.max_penetration,
                stiffness=penalty * model.typical_stiffness,
                grip=min(case.contact.stick_stiffness, SKIN_SHEAR) * lattice.cell_area,
                give=SKIN_SHEAR * lattice.cell_area,
            )
            model = model.with_contribution(contact)
    return model
