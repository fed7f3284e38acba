"""Rigid lands: under a part the fabric does not stretch, so the yarns that pass it have less free length beside it.

A yarn of length l of which the length r lies under a land is strained by u / (l - r) at the elongation u: it is a truss
of the free length whose ends are r further apart (`TrussBlock.offset`), with law, stiffness and energy of what is free.
A lattice truss stands for many yarns, so it is parted across into bands that pass the same lands. For warp and weft
bands and lengths are those of the strip that a truss stands for; for diagonals, which run all ways through their cell,
one band of the greater of the covered shares of the cell, of which the lesser is held. Both follow from lengths alone,
so a strip with a land is right at every coarsening, at any strain. Results show of each truss the band that stretches
most.

Wires feel the same: what stretches of the line of a wire through a cell lies beside the land. STIFF is the strain under
a land over that beside it, which keeps lengths and stiffness finite. A part smaller than a cell turns and bends with
the cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.lattice.weave import LAND, WARP, WEFT
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution
from etextile.mechanics.truss import TrussBlock
from etextile.results.wire_layout import WireLayout
from etextile.types import Array, IntArray
from wires.cut import LatticeLines
from wires.parts import PartSpec


STIFF = 0.01
_WHOLE = 1.0 - 1e-9
_ALONG = {WARP: 0, WEFT: 1}


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

    def stretched(
        self, lines: LatticeLines, layout: WireLayout, wire: IntArray, along: Array, cells: IntArray
    ) -> Array:
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


def stiffened(law: PowerLaw) -> PowerLaw:
    """Return the law of what lies under a land whole: sigma(strain / STIFF), in compression as in tension."""
    return replace(
        law,
        E=law.E / STIFF,
        H=law.H / STIFF**law.n,
        e0=law.e0 * STIFF,
        compression_ratio=1.0,
        tail_onset=law.tail_onset * STIFF,
        damage_onset=law.damage_onset * STIFF,
        damage_rate=law.damage_rate / STIFF,
    )


def with_lands(model: Model, lands: Lands) -> Model:
    """Return the model whose lattice trusses are parted where lands cover them; raises BadInput off the warp."""
    if not len(lands.low):
        return model
    block = model.lattice_block
    number, across, along = _covered(model, lands)
    left = np.maximum(1.0 - np.bincount(number, across, minlength=len(block.area)), 0.0)
    shown = _most_stretched(number, along)
    held = np.zeros(len(left))
    held[number[shown]] = along[shown]
    apart = np.ones(len(number), dtype=bool)
    apart[shown] = False
    free = number[shown][left[number[shown]] > 1e-9]
    others = _parted(
        block,
        np.concatenate([number[apart], free]),
        np.concatenate([across[apart], left[free]]),
        np.concatenate([along[apart], np.zeros(len(free))]),
    )
    left[number[shown]] = across[shown]
    parts: list[Contribution] = []
    for part in model.contributions:
        parts += [_shortened(replace(block, area=block.area * left), held), others] if part is block else [part]
    return replace(model, contributions=tuple(parts))


def _most_stretched(number: IntArray, along: Array) -> IntArray:
    """Return which bands (n,) are strained most of their trusses; none of those that a land covers whole."""
    part = np.flatnonzero(along < _WHOLE)
    part = part[np.lexsort((along[part], number[part]))]
    last = np.append(np.diff(number[part]) > 0, True)[: len(part)]
    return np.asarray(part[last])


def _parted(block: TrussBlock, number: IntArray, across: Array, along: Array) -> TrussBlock:
    """Return bands of trusses: their trusses, shares of these across, and shares of them along that are held."""
    whole = along >= _WHOLE
    bands = TrussBlock(
        name="lands",
        nodes=block.nodes[number],
        weights=block.weights[number],
        rest_length=block.rest_length[number],
        span=block.span[number],
        offset=block.offset[number],
        area=block.area[number] * across,
        law=block.law[number] + np.where(whole, len(block.laws), 0),
        laws=(*block.laws, *map(stiffened, block.laws)),
        family=np.full(len(number), LAND),
    )
    return _shortened(bands, np.where(whole, 0.0, along))


def _shortened(block: TrussBlock, held: Array) -> TrussBlock:
    """Return trusses of which the shares `held` (M,) of the rest length do not stretch."""
    offset = (1.0 - STIFF) * held * block.rest_length
    return replace(
        block, rest_length=block.rest_length - offset, span=block.span - offset, offset=block.offset + offset
    )


def _covered(model: Model, lands: Lands) -> tuple[IntArray, Array, Array]:
    """Return the bands that pass lands: trusses (k,), and the shares of them across and along that are covered."""
    low, high = _rooms(model)
    found = []
    for corner, opposite in zip(lands.low, lands.high, strict=True):
        ends = [np.clip((end - low) / (high - low), 0.0, 1.0) for end in (corner, opposite)]
        number = np.flatnonzero((ends[1] - ends[0] > 1e-9).all(axis=1))
        found.append((number, np.stack([end[number] for end in ends], axis=2)))  # truss, axis, end
    number, room = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.argsort(number, kind="stable")
    trusses, first = np.unique(number[order], return_index=True)
    bands = []
    for truss, own in zip(trusses, np.split(order, first[1:]), strict=True):
        family = int(model.lattice_block.family[truss])
        across, along = _diagonal(room[own]) if family not in _ALONG else _bands(room[own], _ALONG[family])
        bands.append((np.full(len(across), truss), across, along))
    none = (np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))
    number, across, along = (np.concatenate(part) for part in zip(none, *bands, strict=True))
    return number.astype(np.int64), across, along


def _bands(rooms: Array, axis: int) -> tuple[Array, Array]:
    """Return shares across and along (n,) of the bands of a strip along `axis` over rectangles (k, axis, end) of it."""
    side = rooms[:, 1 - axis]
    cuts = np.unique(side)
    middle = 0.5 * (cuts[:-1] + cuts[1:])
    inside = (middle[:, None] > side[:, 0]) & (middle[:, None] < side[:, 1])
    along = np.minimum(inside @ (rooms[:, axis, 1] - rooms[:, axis, 0]), 1.0)
    covered = along > 0.0
    return np.diff(cuts)[covered], along[covered]


def _diagonal(rooms: Array) -> tuple[Array, Array]:
    """Return the shares (1,) across and along of a diagonal that rectangles (k, axis, end) of its cell cover."""
    wide = max(_union(rooms[:, 0]), _union(rooms[:, 1]))
    area = float(np.prod(rooms[..., 1] - rooms[..., 0], axis=1).sum())
    return np.array([wide]), np.array([min(area / wide, 1.0)])


def _union(intervals: Array) -> float:
    """Return the length of the union of intervals (k, 2)."""
    total, reach = 0.0, -np.inf
    for start, end in intervals[np.argsort(intervals[:, 0])]:
        total += max(end - max(start, reach), 0.0)
        reach = max(reach, end)
    return float(total)


def _rooms(model: Model) -> tuple[Array, Array]:
    """Return lowest and highest coordinates (M, 2) of the part of the piece that each lattice truss stands for."""
    lines = LatticeLines.of(model.lattice)
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
