"""From a case to a model: lattice, wires, supports, body, motion, contact and effects put together.

`plan` answers how large a model would be without building it; `build` builds it. Both are pure.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.lattice.piece import Grid, Lattice, divide, weave_piece
from etextile.lattice.weave import Weave
from etextile.types import Array
from loadcases.bounds import require_bounded
from loadcases.build_body import mesh_notes, placed_body
from loadcases.build_wires import lands_of, share_of_wires, wire_layout, with_wires
from loadcases.build_worn import Worn, limb_notes, put_on, with_skin, worn_model, wrapped
from loadcases.compression import ratios
from loadcases.fabric import Fabric, load_fabric
from loadcases.schema import Case
from loadcases.schema_outline import PolygonOutline


if TYPE_CHECKING:
    from etextile.contact.body import Body
    from etextile.laws.powerlaw import PowerLaw
    from etextile.mechanics.model import Model
    from etextile.mechanics.truss import TrussBlock
    from etextile.solve.newton import Settings
    from wires.embed import EmbeddedWires
    from wires.share import WireShare

PENALTY = 30.0
"""First contact stiffness over the trusses' E A / l; the load path raises it until penetration keeps its limit."""

UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
WORN_FLOOR = 1e-3
"""Residual (N) that counts as none on a worn piece, large parts of which lie slack on the skin: 0.01 kPa on a node."""

OUTWARD = {"x_min": (-1.0, 0.0, 0.0), "x_max": (1.0, 0.0, 0.0), "y_min": (0.0, -1.0, 0.0), "y_max": (0.0, 1.0, 0.0)}
DIRECTION = {"body": UP, "pressure": UP, "weight": DOWN, **OUTWARD}
"""The sense in which the force of a motion counts."""


@dataclass(frozen=True)
class Built:
    """A model with what reports need to know about it: fabric, wires, body at displacement 0, wire share, notes.

    worn: the piece on its limb, of a worn case.
    """

    case: Case
    model: Model
    fabric: Fabric
    body: Body | None
    wires: EmbeddedWires | None
    share: WireShare | None
    notes: tuple[str, ...]
    worn: Worn | None = None


def plan(case: Case) -> dict[str, Any]:
    """Return cells, nodes, trusses, wires, loops and steps a case would have; loads neither kernels nor graphics."""
    fabric = load_fabric(case.fabric.set)
    require_bounded(case, fabric)
    lattice = _lattice(case, _weave(fabric))
    layout = wire_layout(case, fabric)
    return {
        "cells": lattice.cells,
        "nodes": len(lattice.points),
        "trusses": len(lattice.trusses),
        "wires": 0 if layout is None else layout.n_wires,
        "loops": 0 if layout is None else layout.n_loops,
        "steps": len(travel_points(case)),
        "notes": (*_notes(case, lattice), *mesh_notes(case), *limb_notes(case)),
    }


def build(case: Case, *, fabric: Fabric | None = None) -> Built:
    """Return the model of a case, on another fabric if one is given.

    Raises BadInput for what cannot be built (mesh files, wires that are too stiff).
    """
    from etextile.mechanics.truss import TrussBlock

    fabric = fabric or load_fabric(case.fabric.set)
    require_bounded(case, fabric)
    weave = _weave(fabric)
    worn = put_on(case, weave) if case.worn else None
    lattice = _lattice(case, weave) if worn is None else worn.piece.lattice
    layout = wire_layout(case, fabric)
    laws = _laws(case, fabric)
    share = share_of_wires(case, fabric, weave, laws[0])
    laws = laws if share is None else (share.law, *laws[1:])
    trusses = TrussBlock.between_nodes(
        "lattice",
        lattice.trusses,
        length=lattice.rest_length,
        area=lattice.area,
        family=lattice.family,
        laws=laws,
    )
    if worn is None:
        model = _flat_model(case, lattice, trusses)
    else:
        model = worn_model(case, worn, trusses, travel_points(case))
    model = replace(model, unit=case.motion.unit)
    embedded = None
    if layout is not None:
        model, embedded = with_wires(model, case, layout, laws=laws, weave=weave)
    if worn is None:
        body = placed_body(case)
        model = _with_load(case, _with_contact(case, model, body))
    else:
        body = worn.motion.limb
        model = with_skin(case, model, worn, PENALTY)
    if case.effects:
        from etextile.effects.registry import with_effects

        model = with_effects(model, [(item.id, item.parameters) for item in case.effects])
    lands = lands_of(case)
    if lands is not None:
        from wires.lands import with_lands

        model = with_lands(model, lands)
    return Built(case, model, fabric, body, embedded, share, (*_notes(case, lattice), *model.notes), worn)


def _flat_model(case: Case, lattice: Lattice, trusses: TrussBlock) -> Model:
    """Return the model of a flat piece without wires, contact and load."""
    from etextile.mechanics.model import Model

    direction = np.array(DIRECTION[case.motion.target])
    fixed, carried = _supports(case, lattice, direction)
    return Model(
        lattice=lattice,
        points=lattice.points,
        fixed=fixed,
        carried=carried,
        contributions=(trusses,),
        travel=travel_points(case),
        direction=direction,
        speed=case.motion.speed,
        force_factor=_force_factor(case, lattice),
    )


def settings(case: Case) -> Settings:
    """Return the solver settings of a case."""
    from etextile.solve.newton import Settings

    chosen = case.solver
    return Settings(
        force_floor=_force_floor(case),
        tolerance=chosen.tolerance,
        max_iterations=chosen.max_iterations,
        max_cut_backs=chosen.max_cut_backs,
        linear=chosen.linear,
        nonlinear=chosen.nonlinear,
    )


def _force_floor(case: Case) -> float:
    """Return the residual (N) that counts as none: far below the weight of a strip that hangs by nothing else."""
    from etextile.motion.weight import GRAVITY
    from etextile.solve.newton import FORCE_FLOOR

    if case.worn:
        return WORN_FLOOR
    if case.motion.target != "weight":
        return FORCE_FLOOR
    length, width = case.pattern
    return min(FORCE_FLOOR, 1e-5 * GRAVITY * case.motion.reach * length * width)


def travel_points(case: Case) -> Array:
    """Return the output displacements (S,) mm or deg: the path's stations, and points between.

    Points are at most total / steps apart.
    """
    motion = case.motion
    stations = (0.0, *(motion.path or (motion.reach,)))
    spacing = motion.reach / motion.steps
    pieces = [
        np.linspace(before, after, max(1, round(abs(after - before) / spacing)) + 1)[1:]
        for before, after in pairwise(stations)
    ]
    return np.concatenate(pieces)


def _weave(fabric: Fabric) -> Weave:
    return Weave(
        *fabric.cell, fabric.thickness, fabric.truss_area, warp_density=fabric.warp_density,
        weft_density=fabric.weft_density,
    )  # fmt: skip


def _grid(case: Case, weave: Weave) -> Grid:
    return divide(weave, case.pattern, case.fabric.coarsening, case.fabric.portion)


def _lattice(case: Case, weave: Weave) -> Lattice:
    if case.worn:
        return wrapped(case, weave).lattice
    if case.fabric.outline is not None:
        return _outlined(case, weave)
    if case.fabric.warp_angle == 0.0:
        return weave_piece(weave, _grid(case, weave))
    from etextile.lattice.cut import cut_piece

    return cut_piece(
        weave,
        case.pattern,
        coarsening=case.fabric.coarsening,
        warp_angle=case.fabric.warp_angle,
        held=[edge for edge in case.supports.edges if edge in OUTWARD],
    )


def _outlined(case: Case, weave: Weave) -> Lattice:
    """Return the lattice of a circle or a polygon."""
    from etextile.lattice.cut import cut_outline
    from etextile.lattice.shape import Circle, Outlined, Polygon

    piece, outline = case.fabric, case.fabric.outline
    shape: Outlined
    if isinstance(outline, PolygonOutline):
        shape = Polygon(outline.polygon)
    else:
        shape = Circle(outline.circle if outline is not None else 0.0)
    return cut_outline(weave, shape, coarsening=piece.coarsening, warp_angle=piece.warp_angle, portion=piece.portion)


def _laws(case: Case, fabric: Fabric) -> tuple[PowerLaw, ...]:
    from etextile.laws.powerlaw import PowerLaw

    families = (fabric.warp, fabric.weft, fabric.diagonal)
    return tuple(
        PowerLaw(
            family.E.value,
            family.sigma_y0.value,
            family.H.value,
            family.n.value,
            e0=family.e0,
            compression_ratio=max(family.compression_ratio, ratio),
        )
        for family, ratio in zip(families, ratios(case.fabric.compression_ratio), strict=True)
    )


def _supports(case: Case, lattice: Lattice, direction: Array) -> tuple[Any, Array]:
    """Return fixed components (N, 3) and the displacement per mm of travel of those that a moving clamp carries."""
    points = lattice.points
    fixed = np.zeros(points.shape, dtype=bool)
    carried = np.zeros(points.shape)
    for axis, cut in enumerate(lattice.symmetry):
        if cut:
            fixed[points[:, axis] == 0.0, axis] = True
    for edge in case.supports.edges:
        fixed[lattice.edges.get(edge, [])] = True
    if case.motion.target in OUTWARD:
        carried[lattice.edges[case.motion.target]] = direction
    return fixed, carried


def _force_factor(case: Case, lattice: Lattice) -> float:
    """Return force on the specimen over force on the modelled part: a pulled clamp is halved by its own plane only."""
    if case.motion.target not in OUTWARD:
        return float(lattice.multiplicity)
    across = 1 if case.motion.target.startswith("x") else 0
    return 2.0 if lattice.symmetry[across] else 1.0


def _with_contact(case: Case, model: Model, body: Body | None) -> Model:
    if body is None:
        return model
    from etextile.contact.contact import Contact
    from etextile.motion.protocol import STILL
    from etextile.motion.straight import Straight

    nodes = np.flatnonzero(~model.fixed[: len(model.lattice.points)].all(axis=1))
    friction = np.inf if case.contact.friction == "stick" else float(case.contact.friction)
    contact = Contact(
        nodes=nodes[:, None],
        share=model.lattice.share[nodes],
        body=body,
        motion=Straight(model.direction if case.motion.target == "body" else STILL),
        friction=friction,
        max_penetration=case.contact.max_penetration,
        stiffness=PENALTY * model.typical_stiffness,
        grip=case.contact.stick_stiffness * model.lattice.cell_area,
    )
    return model.with_contribution(contact)


def _with_load(case: Case, model: Model) -> Model:
    """Return the model with the load that its motion raises, if it is one."""
    lattice = model.lattice
    if case.motion.target == "pressure":
        from etextile.motion.pressure import Pressure

        return model.with_contribution(Pressure.on(lattice))
    if case.motion.target == "weight":
        from etextile.motion.weight import Weight

        nodes = np.arange(len(lattice.points))
        return model.with_contribution(Weight(nodes[:, None], lattice.share * lattice.cell_area))
    return model


def _notes(case: Case, lattice: Lattice) -> tuple[str, ...]:
    """Say where the lattice differs from what was asked for, and where the laws are asked for more than they know."""
    notes = [*lattice.notes]
    built, asked = lattice.coarsening, case.fabric.coarsening
    if max(abs(value / asked - 1.0) for value in built) >= 1e-3:
        cells = f"{lattice.cells[0]} x {lattice.cells[1]} cells are taken"
        notes.insert(
            0,
            f"coarsening {asked:g} does not divide the piece; {cells}, {built[0]:.4g} along the warp and "
            f"{built[1]:.4g} along the weft",
        )
    if np.any(np.diff(travel_points(case), prepend=0.0) < 0.0):
        notes.append(
            "the motion goes back, but the fabric's laws were identified for monotonic loading: what follows the first "
            "turn is a guess (yarns unload elastically and go slack)"
        )
    return tuple(notes)
