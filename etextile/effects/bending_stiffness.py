r"""Out-of-plane bending of the fabric, which the base model leaves out.

A plate strip along a yarn line has the energy D kappa^2 / 2 per area. On a line of nodes the curvature is the change of
the unit tangent from segment to segment over the mean segment length h, so with tributary width b

    U = D (b / h) (1 - t1 . t2)            (= D b h kappa^2 / 2 for small turns)

which does not depend on the coarsening and not on stretch. Both yarn directions bend with the same D. The few turns of
lines within the fabric plane cost the same. At a symmetry plane the next segment is the mirror image, and so it is in a
clamp, whose jaws hold the slope. Lined jaws yield: with `clamp` c they turn as easily as LINING (1 - c) / c of fabric
would bend, so that 1 is built in and 0 a hinge. Free edges turn freely.

Yarns slide in bending, so many fabrics soften: with a `moment` M0 per width and a `share` r of the stiffness that stays

    M = D kappa [r + (1 - r) / sqrt(1 + (kappa / kappa_0)^2)],    kappa_0 = M0 / D

It is elastic (what sliding loses on the way back is left out). For a turn q = 2 sin(theta / 2) and q_0 = kappa_0 h the
energy is (D b / h) [r q^2 / 2 + (1 - r) q_0^2 (sqrt(1 + (q / q_0)^2) - 1)], the one above for large M0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from etextile.effects.angles import AngleBlock, AngleResult, isotropic
from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import YARNS, clamped_edges, lattice_block
from etextile.lattice.piece import Lattice
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Energy
from etextile.mechanics.truss import TrussBlock
from etextile.types import Array, BoolArray, IntArray


LINING = 10.0
"""Length of fabric that bends as easily as the jaws turn at `clamp` = 1/2, mm."""


@dataclass(frozen=True)
class Softening:
    """Bending that softens: curvature (1/mm) at which it does, and the share of the stiffness that stays."""

    curvature: float = np.inf
    share: float = 1.0


LINEAR = Softening()


@dataclass(frozen=True)
class TurnPotential:
    """Energy of turns with the cosine s from one segment to the next; stiffness (n,) N mm; turns (n,) of softening."""

    stiffness: Array
    turn: Array
    share: float = 1.0

    def initial_state(self) -> None:
        """Return nothing: bending is elastic."""

    def evaluate(self, cosine: Array, state: None) -> AngleResult:
        """Return energy and derivatives with respect to the cosine (n,)."""
        # a cosine that rounding puts above one has no negative energy
        half = np.maximum(1.0 - cosine, 0.0)
        if self.share == 1.0:
            return AngleResult(
                -self.stiffness, np.zeros_like(cosine), None, Energy(stored=float(self.stiffness @ half))
            )
        soft, ratio = 1.0 - self.share, np.sqrt(1.0 + 2.0 * half / self.turn**2)
        stored = self.share * half + soft * self.turn**2 * (ratio - 1.0)
        slope = -self.stiffness * (self.share + soft / ratio)
        curvature = -self.stiffness * soft / (self.turn**2 * ratio**3)
        return AngleResult(slope, curvature, None, Energy(stored=float(self.stiffness @ stored)))


@dataclass(frozen=True)
class BendingStiffness(Effect):
    """Bending stiffness of the fabric per width, how far the clamps hold its slope, and how bending softens."""

    D: float = 0.0
    clamp: float = 1.0
    moment: float = 0.0
    share: float = 0.0

    stage: ClassVar[Stage] = Stage.ELEMENTS
    card: ClassVar[Card] = Card(
        id="bending_stiffness",
        mechanism="Out-of-plane bending stiffness of the fabric.",
        parameters=(
            Parameter("D", "N*mm", 0.0, 10.0, "the bending stiffness per width", limits=(0.0, 1000.0)),
            Parameter("clamp", "", 0.0, 1.0, "how far clamps hold the slope: 1 built in", default=1.0, neutral=None),
            Parameter(
                "moment",
                "N",
                0.0,
                10.0,
                "the moment per width at which it softens (0: never)",
                default=0.0,
                limits=(0.0, 100.0),
            ),
            Parameter("share", "", 0.0, 1.0, "the share of the stiffness that stays beyond", default=0.0),
        ),
        example=Example(
            {"D": 5.0, "clamp": 1.0, "moment": 0.0, "share": 0.0},
            (13.7, 1.2, 0.5, 0.3, 0.1),
            (0.19, 0.17, 0.21, 0.19, 0.17),
        ),
        signature=(
            Signature("punch_force", 1, 0.0, "more at small displacement, a per cent or less later"),
            Signature("free_edge", 0, 0.0, "the edge curls less"),
        ),
        confused_with=("pretension", "compression_carry", "datum_offset"),
        separate="A cantilever (Cantilever test, ISO 9073-7) or Kawabata bending test of the fabric.",
        literature="Kawabata, The Standardization and Analysis of Hand Evaluation (1980); Grinspun et al., Discrete "
        "shells, SCA (2003).",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with turn springs along all yarn lines."""
        soft = Softening(self.moment / self.D, self.share) if self.moment > 0.0 and self.D > 0.0 else LINEAR
        for block in turn_blocks(model, self.D, clamp=self.clamp, soft=soft):
            model = model.with_contribution(block)
        return model


def turn_blocks(model: Model, D: float, *, clamp: float = 1.0, soft: Softening = LINEAR) -> list[AngleBlock]:
    """Return springs on the turns within the lattice, at symmetry planes and, unless `clamp` is 0, in the clamps."""
    block, lattice = lattice_block(model), model.lattice
    nodes, home = [], []
    for family in YARNS:
        first, second = _followers(lattice, family)
        nodes.append(np.stack([_ends(block, first, 0), _ends(block, first, 1), _ends(block, second, 1)], axis=1))
        home.append(lattice.trusses[first, 1])
    inner = np.concatenate(nodes)
    turn = _stiffness(model, D, inner, np.concatenate(home), soft)
    blocks = [AngleBlock("bending", inner, isotropic([-1, 1, 0]), isotropic([0, -1, 1]), turn)]
    for axis in (0, 1):
        if lattice.symmetry[axis]:
            image = np.where(np.arange(3) == axis, 1.0, -1.0)
            blocks.append(
                _imaged(model, D, f"bending at {'xy'[axis]} = 0", lattice.points[:, axis] == 0.0, image, soft)
            )
    for edge, held in clamped_edges(model).items() if clamp > 0.0 else ():
        blocks.append(_imaged(model, D, f"bending at {edge}", held, np.array([1.0, 1.0, -1.0]), soft, clamp=clamp))
    return [item for item in blocks if len(item.nodes)]


def _imaged(
    model: Model, D: float, name: str, held: BoolArray, image: Array, soft: Softening, *, clamp: float = 1.0
) -> AngleBlock:  # fmt: skip
    """Return springs between segments that leave nodes `held` (N,) and the segments before, their images (3,).

    At a symmetry plane the segment before is the mirror image, in a clamp its slope out of the plane is the opposite.
    Jaws that yield are in series with half a cell of length h, which takes h / (h + 2 l) off, l = LINING (1 - c) / c.
    """
    block, lattice = lattice_block(model), model.lattice
    at = held[lattice.trusses]
    starts, stops = (np.flatnonzero(np.isin(block.family, YARNS) & at[:, k] & ~at[:, 1 - k]) for k in (0, 1))
    nodes = np.concatenate([block.nodes[starts, :2], block.nodes[stops, 1::-1]])
    home = np.concatenate([lattice.trusses[starts, 0], lattice.trusses[stops, 1]])
    leaving = isotropic([-1, 1])
    length = np.linalg.norm(np.diff(model.points[nodes], axis=1), axis=2).mean(axis=1)
    held_by = length / (length + 2.0 * LINING * (1.0 - clamp) / clamp)
    return AngleBlock(name, nodes, image * leaving, leaving, _stiffness(model, held_by * D, nodes, home, soft))


def _followers(lattice: Lattice, family: int) -> tuple[IntArray, IntArray]:
    """Return pairs of truss numbers (n,) of which the second goes on where the first ends, along one yarn."""
    own = np.flatnonzero(lattice.family == family)
    leaving = np.full(len(lattice.points), -1)
    leaving[lattice.trusses[own, 0]] = own
    following = leaving[lattice.trusses[own, 1]]
    return own[following >= 0], following[following >= 0]


def _ends(block: TrussBlock, trusses: IntArray, end: int) -> IntArray:
    return np.asarray(block.nodes[trusses, end])


def _stiffness(
    model: Model, D: float | Array, nodes: IntArray, home: IntArray, soft: Softening
) -> TurnPotential:  # fmt: skip
    """Return D b / h = D (tributary area) / h^2 of turns at the lattice nodes `home` (n,)."""
    lattice = model.lattice
    corners = lattice.points[lattice.quads[0]]
    cell = float(np.linalg.norm(np.cross(corners[1] - corners[0], corners[3] - corners[0])))
    ends = model.points[nodes]
    length = np.linalg.norm(np.diff(ends, axis=1), axis=2).mean(axis=1)
    return TurnPotential(D * lattice.share[home] * cell / length**2, soft.curvature * length, soft.share)
