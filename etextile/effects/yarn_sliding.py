r"""Warp and weft slip past each other at their crossings.

In the base model a crossing is a node: warp and weft move as one. Here the weft has nodes of its own, tied to those of
the warp by an elastic offset e that slips. Within an increment, with the unit normal n of the fabric at its start and
per area of fabric,

    U = k_n (e.n)^2 / 2 + min over s of |t - s|^2 / (2 compliance) + limit |s|,    t = e - (e.n) n,    e = e_0 + r - r_0

so across the fabric the yarns stay together, and along it they pass a shear traction that gives elastically and slips
at `limit`. What is left of e, the offset r and n are history, so a yarn slides along the fabric as it bends and no
energy comes in between increments. The diagonals and the contact stay with the warp. With `film` 1 they are a film or
coating in which both families are bonded: warp and weft have nodes of their own, each tied to those of the film. Then
yarns that are cut at both edges of a strip build up their force over some sqrt(E t compliance), t the thickness.

The way w = t / |t| of a slip turns within a Newton step; the exact tangent, limit (1 - w w^T) / |t|, lets a crossing
that just began to slip go anywhere along it. So the traction p is an unknown of its own, |p| <= limit: linearised,
|t| p = limit t gives the tangent limit (1 - p w^T / limit) / |t|, symmetrised, which is the exact one once p is at its
limit along w, and stiffer before (T. F. Chan, G. H. Golub and P. Mulet, SIAM J. Sci. Comput. 20 (1999) 1964).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from etextile.effects import kernels
from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import lattice_block, with_lattice_block
from etextile.errors import BadInput
from etextile.lattice.weave import WARP, WEFT
from etextile.mechanics.kernels import add_dense_blocks
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


TIED = 20.0
"""Stiffness across the fabric over the typical stiffness of a truss."""
STIFF = 1e-2
"""Elastic give that is taken for rigid, mm per N/mm2."""


@dataclass(frozen=True)
class SlideState:
    """Offsets (n, 3) of weft from warp and their elastic part (n, 3), path (n,) of slip, mm; fabric normals (n, 3)."""

    elastic: Array
    offset: Array
    path: Array
    normal: Array

    @property
    def slip(self) -> Array:
        """How far (n,) mm the weft has come from where it was woven in."""
        return np.asarray(np.linalg.norm(self.offset - self.elastic, axis=1))


@dataclass(frozen=True)
class Crossings(Contribution):
    """Ties between warp nodes and weft nodes, nodes (n, 2).

    grip (n,): elastic stiffness along the fabric, N/mm; limit (n,): force at which a crossing slips, N; tie: stiffness
    across, N/mm; quads (Q, 4) of the lattice give the normals.
    """

    nodes: IntArray
    grip: Array
    limit: Array
    tie: float
    quads: IntArray
    name: str = "crossings"

    def initial_state(self) -> SlideState:
        """Return no slip in a flat fabric."""
        nothing = np.zeros((len(self.nodes), 3))
        return SlideState(nothing, nothing, nothing[:, 0], nothing + np.array([0.0, 0.0, 1.0]))

    def respond(self, x: Array, travel: float, state: SlideState) -> CrossingResponse:
        """Evaluate the ties at positions x (P, 3)."""
        elastic = state.elastic + x[self.nodes[:, 1]] - x[self.nodes[:, 0]] - state.offset
        apart = np.einsum("nc,nc->n", elastic, state.normal)
        along = elastic - apart[:, None] * state.normal
        pull = self.grip * np.linalg.norm(along, axis=1)
        held = np.minimum(1.0, self.limit / np.where(pull > 0.0, pull, 1.0))
        return CrossingResponse(self, x, state, apart, along, held)

    def carried_along(self, x: Array, travel: float, x_last: Array, travel_last: float) -> Array:
        """Return positions at which the weft nodes keep their offsets, so that no prediction makes them slip."""
        warp, weft = self.nodes[:, 0], self.nodes[:, 1]
        x = x.copy()
        x[weft] = x[warp] + x_last[weft] - x_last[warp]
        return x

    def normals(self, x: Array) -> Array:
        """Return the unit normals (n, 3) at the warp nodes, from the cells around them."""
        total = np.zeros_like(x)
        kernels.add_cell_normals(self.quads, x, total)
        own = total[self.nodes[:, 0]]
        size = np.linalg.norm(own, axis=1, keepdims=True)
        return np.where(size > 0.0, own / np.where(size > 0.0, size, 1.0), [0.0, 0.0, 1.0])


@dataclass(frozen=True)
class CrossingResponse(Response):
    """Crossings at a trial: elastic offset across (n,) and along (n, 3) the fabric, and the share of it that holds.

    `foreseen`: the traction (n, 3) N that the step to this trial foresaw, that of the law where there was none.
    """

    block: Crossings
    x: Array
    start: SlideState
    apart: Array
    along: Array
    held: Array
    foreseen: Array | None = None

    @property
    def force(self) -> Array:
        """Derivative of the energy with respect to the offset (n, 3), N."""
        across = (self.block.tie * self.apart)[:, None] * self.start.normal
        return np.asarray(across + (self.held * self.block.grip)[:, None] * self.along)

    @property
    def traction(self) -> Array:
        """Traction (n, 3) N along the fabric, by which the tangent goes."""
        lawful = (self.held * self.block.grip)[:, None] * self.along
        return np.asarray(lawful if self.foreseen is None else self.foreseen)

    def reached_from(self, previous: Response) -> CrossingResponse:
        """Return the response with the traction that the tangent at `previous` foresaw for here, within its limit."""
        if not isinstance(previous, CrossingResponse):
            return self
        block, moved = self.block, self.along - previous.along
        turned = np.einsum("nc,nc->n", _unit(previous.along), moved) / block.limit
        slipping = self.along - turned[:, None] * previous.traction
        stays = previous.held == 1.0
        traction = (previous.held * block.grip)[:, None] * np.where(stays[:, None], self.along, slipping)
        size = np.linalg.norm(traction, axis=1)
        share = np.minimum(1.0, block.limit / np.where(size > 0.0, size, 1.0))
        return replace(self, foreseen=share[:, None] * traction)

    @property
    def path(self) -> Array:
        """Path (n,) mm of slip."""
        return np.asarray(self.start.path + (1.0 - self.held) * np.linalg.norm(self.along, axis=1))

    @property
    def state(self) -> SlideState:
        """What is left of the elastic offset; offset and normals of here."""
        left = self.apart[:, None] * self.start.normal + self.held[:, None] * self.along
        offset = self.x[self.block.nodes[:, 1]] - self.x[self.block.nodes[:, 0]]
        return SlideState(left, offset, self.path, self.block.normals(self.x))

    def energy(self) -> Energy:
        """Return the elastic energy and the friction work so far, N mm."""
        block = self.block
        lost = np.where(np.isfinite(block.limit), block.limit, 0.0) @ self.path
        along = self.held[:, None] * self.along
        elastic = block.tie * self.apart @ self.apart + block.grip @ (along**2).sum(axis=1)
        return Energy(stored=0.5 * float(elastic), friction=float(lost))

    def add_gradient(self, gradient: Array) -> None:
        """Add the forces on warp and weft nodes to gradient (P, 3)."""
        kernels.add_pair_forces(self.block.nodes, self.force, gradient)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the ties' tangent, which is positive also where they slip."""
        block, normal = self.block, self.start.normal
        across = normal[:, :, None] * normal[:, None, :]
        slips = (self.held < 1.0)[:, None]
        share = np.where(slips, self.traction / np.where(slips, block.limit[:, None], 1.0), 0.0)
        turning = share[:, :, None] * _unit(self.along)[:, None, :]
        plane = np.eye(3) - across - 0.5 * (turning + turning.transpose(0, 2, 1))
        own = block.tie * across + (self.held * block.grip)[:, None, None] * plane
        both = np.concatenate([np.concatenate([own, -own], axis=2), np.concatenate([-own, own], axis=2)], axis=1)
        add_dense_blocks(block.nodes, both, rows, pairs, values)


def _unit(vectors: Array) -> Array:
    """Return vectors (n, 3) with the length one, zeros where there is no direction."""
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0.0, size, 1.0))


@dataclass(frozen=True)
class YarnSliding(Effect):
    """Shear traction at which yarns slip at their crossings (0: never), elastic slip per traction, 1 for a film."""

    limit: float = 0.0
    compliance: float = 0.0
    film: float = 0.0

    stage: ClassVar[Stage] = Stage.NODES
    card: ClassVar[Card] = Card(
        id="yarn_sliding",
        mechanism="Warp and weft slip past each other at their crossings.",
        parameters=(
            Parameter(
                "limit",
                "MPa",
                0.02,
                10.0,
                "the force per fabric area at which crossings slip",
                default=0.0,
                scale="log",
            ),
            Parameter("compliance", "mm/MPa", 0.0, 1.0, "the elastic slip per force and fabric area", default=0.0),
            Parameter(
                "film",
                "",
                0.0,
                1.0,
                "whether both families slip in a film that carries the shear (1)",
                neutral=None,
                default=0.0,
                choice=True,
            ),
        ),
        example=Example(
            {"limit": 0.5, "compliance": 0.0, "film": 0.0}, (0.0, 0.0, 0.0, -1.3, -17.3), (0.0, 0.0, 0.0, 0.04, 0.5)
        ),
        signature=(
            Signature("punch_force", -1, 25.0, "softening at high load"),
            Signature("strain_field", 0, 20.0, "strain peaks spread out along the yarns; yarns leave their lines"),
        ),
        confused_with=("yarn_tail", "clamp_slip", "yarn_damage"),
        separate="A grid drawn on the fabric: its lines break up where yarns slide.",
        literature="King et al., Int. J. Solids Struct. 42 (2005) 3867; Parsons et al., J. Mech. Phys. Solids 58 "
        "(2010) 1995 (slip in a continuum of woven yarns).",
        off_axis=("compliance", "film"),
        limits="Doubles the number of nodes; a yarn keeps its partner at the crossing, so slips should be small.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with nodes for the weft (in a film for the warp, too); BadInput when it has them already."""
        if any(isinstance(part, Crossings) for part in model.contributions):
            raise BadInput.of("yarn_sliding stands twice in the case, remove one", key="id")
        if self.film not in (0.0, 1.0):
            raise BadInput.of(f"there is a film or there is none (got {self.film:g}), must be 0 or 1", key="film")
        block, lattice = lattice_block(model), model.lattice
        count, first = len(lattice.points), len(model.points)
        families = (WEFT, WARP) if self.film else (WEFT,)
        nodes, own = block.nodes.copy(), np.arange(count)
        for number, family in enumerate(families):
            nodes[block.family == family] += first + number * count
        corners = lattice.points[lattice.quads[0]]
        cell = float(np.linalg.norm(np.cross(corners[1] - corners[0], corners[3] - corners[0])))
        area = np.tile(np.maximum(lattice.share, 1e-6) * cell, len(families))
        crossings = Crossings(
            nodes=np.stack([np.tile(own, len(families)), first + np.arange(len(area))], axis=1),
            grip=area / (self.compliance if self.compliance > 0.0 else STIFF),
            limit=area * (self.limit if self.limit > 0.0 else np.inf),
            tie=TIED * model.typical_stiffness,
            quads=lattice.quads,
        )
        model = with_lattice_block(model, replace(block, nodes=nodes))
        return replace(
            model,
            points=np.concatenate([model.points, *(model.points[:count] for _ in families)]),
            fixed=np.concatenate([model.fixed, *(model.fixed[:count] for _ in families)]),
            carried=np.concatenate([model.carried, *(model.carried[:count] for _ in families)]),
        ).with_contribution(crossings)
