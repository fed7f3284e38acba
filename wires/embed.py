"""Wires put into a lattice: Model -> Model with explicit copper trusses in the weave and across the loops.

A wire point at material place (x, y) rides on the four nodes of the cell it lies in, by bilinear interpolation, so
wires need no lattice lines of their own and may lie in any direction. Between loops, elements end where the wire
crosses lattice lines, at its corners and at the loops, so each lies in one cell; a loop is one element from exit to
entry, free of the fabric between. Woven-in elements have a rest length of (1 + crimp), loops of (1 + slack) times their
span. On a symmetry plane a wire has half its area, and a loop cut by one half its length.

Wires of one construction (metal, section, crimp, bond) are a `Strand`; each is embedded by itself, its woven-in
elements before its loops.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.lattice.weave import WIRE
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Followers, Model
from etextile.mechanics.protocol import Contribution
from etextile.mechanics.truss import TrussBlock
from etextile.results.layout import ELEMENTS, names
from etextile.results.wire_history import WireHistory
from etextile.types import Array, IntArray
from wires.cut import LatticeLines, cut_wire
from wires.lands import Lands
from wires.layout import WireLayout


LOOPS = "loops"
"""Name of the block of perfectly bonded loops."""


@dataclass(frozen=True)
class Elements:
    """Elements (n,) from start to end, coordinates along their wires."""

    start: Array
    end: Array
    wire: IntArray

    @classmethod
    def woven(
        cls,
        layout: WireLayout,
        lines: LatticeLines,
        wires: IntArray,
        *,
        longest: float = np.inf,
        held: Array | None = None,
    ) -> Elements:
        """Return the woven-in elements of some wires; `held` (n, 2) lists wire and place where wires are held."""
        places = np.zeros((0, 2)) if held is None else held
        parts = [
            cut_wire(layout, lines, int(wire), longest=longest, held=places[places[:, 0] == wire, 1]) for wire in wires
        ]
        owner = [np.full(len(part[0]), wire) for wire, part in zip(wires, parts, strict=True)]
        start, end = (np.concatenate([part[k] for part in parts] or [np.zeros(0)]) for k in (0, 1))
        return cls(start, end, np.concatenate(owner or [np.zeros(0)]).astype(np.int64))

    @classmethod
    def loops(cls, layout: WireLayout, loops: IntArray) -> Elements:
        """Return the modelled parts of some loops."""
        return cls(layout.modelled_exit_mm[loops], layout.modelled_entry_mm[loops], layout.loop_wire[loops])


@dataclass(frozen=True)
class Strand:
    """Wires of one construction in a model: their numbers and loops, woven-in elements, trusses and their points."""

    wires: IntArray
    loops: IntArray
    woven: Elements
    crimp: float
    blocks: tuple[TrussBlock, ...]
    followers: Followers


@dataclass(frozen=True)
class EmbeddedWires:
    """Where wires and loops are among the trusses: layout; wire, place, length and crimp (K,) of woven-in elements.

    `woven` (K,) and `loops` (L,) are their numbers among the wire trusses.
    """

    layout: WireLayout
    element_wire: IntArray
    element_along_mm: Array
    element_length_mm: Array
    element_crimp: Array
    woven: IntArray
    loops: IntArray
    lands: Lands | None = None

    @classmethod
    def of(cls, layout: WireLayout, strands: Sequence[Strand], *, lands: Lands | None = None) -> EmbeddedWires:
        """Return the record of some strands, in their order."""
        first = 0
        woven, loops = [np.zeros(0, dtype=np.int64)], np.zeros(layout.n_loops, dtype=np.int64)
        for strand in strands:
            count = len(strand.woven.wire)
            woven.append(first + np.arange(count))
            loops[strand.loops] = first + count + np.arange(len(strand.loops))
            first += count + len(strand.loops)
        parts = [strand.woven for strand in strands]
        none = [np.zeros(0)]
        return cls(
            layout,
            np.concatenate([part.wire for part in parts] or none).astype(np.int64),
            np.concatenate([0.5 * (part.start + part.end) for part in parts] or none),
            np.concatenate([part.end - part.start for part in parts] or none),
            np.concatenate(
                [np.full(len(part.wire), strand.crimp) for part, strand in zip(parts, strands, strict=True)] or none
            ),
            np.concatenate(woven),
            loops,
            lands,
        )

    @property
    def count(self) -> int:
        """Number of woven-in elements K."""
        return len(self.element_wire)

    @property
    def element_warp_mm(self) -> Array:
        """Warp coordinate (K,) of the middles of the woven-in elements."""
        return self.layout.places(self.element_wire, self.element_along_mm)[:, 0]

    @property
    def elements(self) -> dict[str, Array]:
        """The arrays (K,) of the woven-in elements by the names that results give them."""
        return {name: getattr(self, name) for name in names(ELEMENTS)}

    def history(self, displacement_mm: Array, strains: Mapping[str, Array], begins: float | None = None) -> WireHistory:
        """Return what the wires went through over output steps (S,), strains as `wire_strains` names them (S, n)."""
        return WireHistory.from_flat(
            displacement_mm, strains, layout=self.layout, elements=self.elements, begins=begins
        )


def bonded(
    model: Model,
    layout: WireLayout,
    wires: IntArray,
    law: PowerLaw,
    *,
    area_mm2: float,
    crimp: float,
    lands: Lands | None = None,
) -> Strand:
    """Return some wires of a layout as trusses that move with the fabric, stiff where they lie on lands."""
    lines = LatticeLines.of(model.lattice)
    loops = np.flatnonzero(np.isin(layout.loop_wire, wires))
    woven = Elements.woven(layout, lines, wires, held=None if lands is None else lands.borders(layout))
    free = Elements.loops(layout, loops)
    both = (
        truss_block("wires", lines, woven, layout, law, area_mm2, 1.0 + crimp, lands=lands),
        truss_block(LOOPS, lines, free, layout, law, area_mm2, 1.0 + layout.loop_slack[loops], lands=lands),
    )
    blocks = tuple(block for block in both if len(block.nodes))
    points = wire_points(model, lines, layout, (woven, free))
    return Strand(wires, loops, woven, crimp, blocks, points)


def with_strands(
    model: Model, layout: WireLayout, strands: Sequence[Strand], *, lands: Lands | None = None
) -> tuple[Model, EmbeddedWires]:
    """Return the model with embedded strands behind the lattice, and the record of where they are."""
    lattice, *others = model.contributions
    blocks: list[Contribution] = [block for strand in strands for block in strand.blocks]
    followers = _together([strand.followers for strand in strands], len(model.lattice.points))
    model = replace(model, contributions=(lattice, *blocks, *others), followers=followers)
    return model, EmbeddedWires.of(layout, strands, lands=lands)


def _together(parts: Sequence[Followers], nodes: int) -> Followers:
    """Return followers of several strands as one, numbered one after the other behind the nodes."""
    cells, first = [], 0
    for part in parts:
        cells.append(part.cells + first)
        first += len(part.nodes)
    none = Followers(
        np.zeros((0, 4), dtype=np.int64),
        np.zeros((0, 4)),
        np.zeros((0, 2), dtype=np.int64),
        np.zeros(0, dtype=np.int64),
    )
    parts = parts or [none]
    return Followers(
        np.concatenate([part.nodes for part in parts]),
        np.concatenate([part.weights for part in parts]),
        np.concatenate(cells or [none.cells]),
        np.concatenate([part.wire for part in parts]),
    )


def truss_block(
    name: str,
    lines: LatticeLines,
    elements: Elements,
    layout: WireLayout,
    law: PowerLaw,
    area_mm2: float,
    excess: float | Array,
    *,
    lands: Lands | None = None,
) -> TrussBlock:
    """Return trusses along the elements (n,); those within one cell couple its four nodes."""
    start, end, wire = elements.start, elements.end, elements.wire
    middle, *ends = (layout.places(wire, along) for along in (0.5 * (start + end), start, end))
    one_cell = lines.cells(middle)
    inside = lines.within(ends[0], one_cell) & lines.within(ends[1], one_cell)
    from_cell, to_cell = (np.where(inside[:, None], one_cell, lines.cells(place)) for place in ends)
    if lands is not None:
        ends = [
            lands.stretched(lines, layout, wire, along, cell) for along, cell in ((start, from_cell), (end, to_cell))
        ]
    nodes_a, weights_a = lines.interpolate(ends[0], from_cell)
    nodes_b, weights_b = lines.interpolate(ends[1], to_cell)
    if inside.all():
        nodes, weights = nodes_a, weights_b - weights_a
    else:
        nodes, weights = _merge(np.hstack([nodes_a, nodes_b]), np.hstack([-weights_a, weights_b]))
    span = end - start
    drawn = span if lands is None else np.linalg.norm(ends[1] - ends[0], axis=1)
    return TrussBlock(
        name=name,
        nodes=nodes,
        weights=weights,
        rest_length=span * excess,
        span=span,
        offset=drawn - span,
        area=area_mm2 * layout.share[wire],
        law=np.zeros(len(span), dtype=np.int64),
        laws=(law,),
        family=np.full(len(span), WIRE),
    )


def _merge(nodes: IntArray, weights: Array) -> tuple[IntArray, Array]:
    """Add the weights of nodes that appear twice in a row to the first place; the second keeps weight zero."""
    weights = weights.copy()
    for later in range(1, nodes.shape[1]):
        for earlier in range(later):
            same = nodes[:, earlier] == nodes[:, later]
            weights[same, earlier] += weights[same, later]
            weights[same, later] = 0.0
    return nodes, weights


def wire_points(model: Model, lines: LatticeLines, layout: WireLayout, parts: Sequence[Elements]) -> Followers:
    """Return the wire points with their cells and wires, elements in the order of the truss blocks."""
    wire = np.concatenate([part.wire for part in parts])
    ends = np.stack([np.concatenate([getattr(part, name) for part in parts]) for name in ("start", "end")], axis=1)
    key = np.stack([np.repeat(wire, 2).astype(float), np.round(ends.ravel(), 9)], axis=1)
    points, number = np.unique(key, axis=0, return_inverse=True)
    places = layout.places(points[:, 0].astype(np.int64), points[:, 1])
    nodes, weights = lines.interpolate(places, lines.cells(places))
    cells = number.reshape(-1, 2) + len(model.lattice.points)
    return Followers(nodes, weights, cells.astype(np.int64), wire)
