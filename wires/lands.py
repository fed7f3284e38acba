"""Rigid lands: under a part the fabric does not stretch, so the yarns that pass it have less free length beside it.

A yarn of length l of which a share f lies under a land carries at the elongation u what a free one carries at the
strain u / (l (1 - f)). A lattice truss stands for many yarns, of which a share b passes the land: it is parted into
(1 - b) of its area as it was and b of it with the strain amplified by 1 / (1 - f). For warp and weft b and f are the
covered shares of the strip a truss stands for across and along it; for diagonals the greater and the lesser of the
covered shares of the cell. Both follow from lengths alone, so a strip with a land is right at every coarsening.

Wires feel the same: what stretches of the line of a wire through a cell lies beside the land. STIFF is the strain under
a land over that beside it, which keeps lengths and stiffness finite. Strains are amplified as if they were small, so
beside a land that covers part of a cell a strain e is short by up to e of itself. A part smaller than a cell turns and
bends with the cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.lattice.weave import LAND, WARP, WEFT
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.results.wire_layout import WireLayout
from etextile.types import Array, IntArray
from wires.cut import Lines
from wires.parts import PartSpec


STIFF = 0.01


@dataclass(frozen=True)
class Lands:
    """Rectangles of n lands: lowest and highest coordinates (n, 2) along warp and weft, mm."""

    low: Array
    high: Array

    @classmethod
    def of(cls, parts: Sequence[PartSpec]) -> Lands:
        """Return the lands of the parts that hold the fabric."""
        rigid = [part for part in parts if part.rigid]
        centre = np.array([part.at for part in rigid], dtype=float).reshape(-1, 2)
        half = np.array([part.size for part in rigid], dtype=float).reshape(-1, 2) / 2
        return cls(centre - half, centre + half)

    def borders(self, layout: WireLayout) -> Array:
        """Return wire and coordinate along it (k, 2) where wires pass onto and off lands."""
        pieces = layout.pieces
        found = [np.zeros((0, 2))]
        for low, high in zip(self.low, self.high, strict=True):
            first, last = chord(pieces.origin, pieces.direction, low, high)
            first, last = np.maximum(first, pieces.start), np.minimum(last, pieces.end)
            inside = last - first > 1e-9
            found += [np.stack([pieces.wire, end], axis=1)[inside] for end in (first, last)]
        return np.concatenate(found)

    def stretched(self, lines: Lines, layout: WireLayout, wire: IntArray, along: Array, cells: IntArray) -> Array:
        """Return the places (n, 2) of a fabric that stretches evenly which move as those at `along` (n,) do.

        Within each cell's stretch of the wire's line, what lies under a land is drawn together and the rest takes its
        room; without land the places are those of the layout to the last digit.
        """
        pieces = layout.pieces
        piece = pieces.at(wire, along)
        origin, way = pieces.origin[piece], pieces.direction[piece]
        low = np.stack([line[cells[:, k]] for k, line in enumerate((lines.x, lines.y))], axis=1)
        high = np.stack([line[cells[:, k] + 1] for k, line in enumerate((lines.x, lines.y))], axis=1)
        start, end = chord(origin, way, low, high)
        covered, before = np.zeros(len(along)), np.zeros(len(along))
        for corner, opposite in zip(self.low, self.high, strict=True):
            first, last = chord(origin, way, np.maximum(low, corner), np.minimum(high, opposite))
            length = np.maximum(last - first, 0.0)
            covered += length
            before += np.clip(along - np.minimum(first, along), 0.0, length)
        free = (end - start) - (1.0 - STIFF) * covered
        own = (along - start) - (1.0 - STIFF) * before
        touched = covered > 1e-9
        moved = np.where(touched, start + (end - start) * own / np.where(touched, free, 1.0), along)
        return pieces.places(piece, moved)


def chord(origin: Array, way: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return where lines origin + s way (n, 2) enter and leave rectangles; the first exceeds the last for a miss."""
    first, last = np.full(len(origin), -np.inf), np.full(len(origin), np.inf)
    bounds = [np.broadcast_to(bound, origin.shape) for bound in (low, high)]
    for axis in (0, 1):
        a, d = origin[:, axis], way[:, axis]
        moving = np.abs(d) > 1e-12
        ends = np.sort([(bound[:, axis] - a) / np.where(moving, d, 1.0) for bound in bounds], axis=0)
        beside = (a < bounds[0][:, axis] - 1e-9) | (a > bounds[1][:, axis] + 1e-9)
        first = np.maximum(first, np.where(moving, ends[0], np.where(beside, np.inf, -np.inf)))
        last = np.minimum(last, np.where(moving, ends[1], np.where(beside, -np.inf, np.inf)))
    empty = (bounds[0] >= bounds[1]).any(axis=1)
    return np.where(empty, np.inf, first), np.where(empty, -np.inf, last)


def amplified(law: PowerLaw, factor: float, *, rigid: bool = False) -> PowerLaw:
    """Return the law of a truss of which only 1 / factor of the length stretches: sigma(factor * strain).

    `rigid` lets it bear compression as it bears tension.
    """
    return replace(
        law,
        E=law.E * factor,
        H=law.H * factor**law.n,
        e0=law.e0 / factor,
        compression_ratio=1.0 if rigid else law.compression_ratio,
        tail_onset=law.tail_onset / factor,
        damage_onset=law.damage_onset / factor,
        damage_rate=law.damage_rate * factor,
    )


def respaced(block: TrussBlock, distance: Array) -> TrussBlock:
    """Return trusses whose ends are `distance` (n,) apart in the flat fabric, in place of their spans.

    What they stretch by is the same: a truss at length l of rest R and span s is at (l - distance + s) / R - 1, which
    is the strain of rest R - s + distance, amplified by that over R. Trusses without change stay to the last digit.
    """
    moved = np.abs(distance - block.span) > 1e-9
    rest = np.where(moved, np.maximum(block.rest_length - block.span + distance, 1e-6), block.rest_length)
    factor = np.where(moved, np.round(rest / block.rest_length, 9), 1.0)
    kinds, law = np.unique(factor, return_inverse=True)
    return replace(
        block,
        rest_length=rest,
        span=np.where(moved, distance, block.span),
        law=law.astype(np.int64),
        laws=tuple(block.laws[0] if value == 1.0 else amplified(block.laws[0], value) for value in kinds),
    )


def with_lands(model: Model, lands: Lands) -> Model:
    """Return the model whose lattice trusses are parted where lands cover them; raises BadInput off the warp."""
    if not len(lands.low):
        return model
    whole, *others = model.contributions
    block = model.lattice_block
    number, across, along = _covered(model, lands)
    taken = np.bincount(number, across, minlength=len(block.area))
    across = across / np.maximum(taken, 1.0)[number]
    factor = np.round(1.0 / (1.0 - (1.0 - STIFF) * along), 9)
    kinds, law = np.unique(np.stack([block.law[number], factor], axis=1), axis=0, return_inverse=True)
    covered = TrussBlock(
        name="lands",
        nodes=block.nodes[number],
        weights=block.weights[number],
        rest_length=block.rest_length[number],
        span=block.span[number],
        area=block.area[number] * across,
        law=law.ravel().astype(np.int64),
        laws=tuple(amplified(block.laws[int(own)], value, rigid=value > 0.99 / STIFF) for own, value in kinds),
        family=np.full(len(number), LAND),
    )
    rest = replace(block, area=block.area * np.maximum(1.0 - taken, 0.0))
    first = rest if whole is block else whole
    return replace(model, contributions=(first, covered, *(rest if part is block else part for part in others)))


def _covered(model: Model, lands: Lands) -> tuple[IntArray, Array, Array]:
    """Return trusses (k,) of the lattice, and the shares of them across and along which a land covers."""
    low, high = _rooms(model)
    family = model.lattice_block.family
    found = []
    for corner, opposite in zip(lands.low, lands.high, strict=True):
        share = (np.minimum(high, opposite) - np.maximum(low, corner)) / (high - low)
        number = np.flatnonzero((share > 1e-9).all(axis=1))
        x, y = np.clip(share[number], 0.0, 1.0).T
        kind = family[number]
        across = np.where(kind == WARP, y, np.where(kind == WEFT, x, np.maximum(x, y)))
        along = np.where(kind == WARP, x, np.where(kind == WEFT, y, np.minimum(x, y)))
        found.append((number, across, along))
    number, across, along = (np.concatenate(part) for part in zip(*found, strict=True))
    return number, across, along


def _rooms(model: Model) -> tuple[Array, Array]:
    """Return lowest and highest coordinates (M, 2) of the part of the piece that each lattice truss stands for."""
    lines = Lines.of(model.lattice)
    rows = len(lines.y)
    trusses, family = model.lattice.trusses, model.lattice_block.family
    at = np.stack([trusses // rows, trusses % rows], axis=2)  # truss, end, axis
    low, high = np.empty((len(trusses), 2)), np.empty((len(trusses), 2))
    for axis, line in enumerate((lines.x, lines.y)):
        middle = np.concatenate([line[:1], 0.5 * (line[:-1] + line[1:]), line[-1:]])
        first, last = at[..., axis].min(axis=1), at[..., axis].max(axis=1)
        beside = family == (WEFT if axis == 0 else WARP)
        low[:, axis] = np.where(beside, middle[first], line[first])
        high[:, axis] = np.where(beside, middle[first + 1], line[last])
    return low, high
