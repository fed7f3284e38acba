"""Wires put into a lattice so that they can slide along their channel, or so that loops carry rigid components.

The same points and elements as `wires.embed`, cut finer so that the wire's tension may change along a lattice cell, as
one contribution (`wires.slip.SlidingWires`) per strand with one unknown per wire point behind the lattice nodes. A wire
is held where its end is: at a clamped edge and on a symmetry plane; also where it is joined to another wire or to a
part. At a free edge it can be drawn in against friction alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Followers, Model
from etextile.mechanics.truss import TrussBlock
from etextile.results.wire_layout import ALONG_WARP, ALONG_WEFT, WireLayout
from etextile.types import Array, BoolArray, IntArray
from wires.cut import LatticeLines
from wires.embed import LOOPS, Elements, Strand, truss_block, wire_points
from wires.lands import Lands
from wires.slip import SlidingWires
from wires.slip_trial import WeftPressure


ELEMENT_MM = 1.0
"""Longest woven-in element: slip zones are some millimetres long."""
_NODES = 8


@dataclass(frozen=True)
class WeaveHold:
    """How a wire is held in the weave: line friction N/mm, and tension_factor times the crossing yarns' tension more.

    strain, tension (T,): loading curve of the crossing yarns (the weft for wires along the warp), N per mm; laid wires
    have none. `held` True bonds the wire perfectly.
    """

    line_friction: float = 0.0
    tension_factor: float = 0.0
    strain: Array | None = None
    tension: Array | None = None
    held: bool = False
    element_mm: float = ELEMENT_MM


def sliding(
    model: Model,
    layout: WireLayout,
    wires: IntArray,
    law: PowerLaw,
    *,
    area_mm2: float,
    crimp: float,
    channel: WeaveHold,
    held: Array | None = None,
    lands: Lands | None = None,
) -> tuple[Model, Strand]:
    """Return the model with slip points for some wires of one kind, and these as one contribution.

    `held` (n, 2) lists wire and coordinate along it where wires cannot slide.
    """
    lines = LatticeLines.of(model.lattice)
    longest = np.inf if channel.held else channel.element_mm
    loops = np.flatnonzero(np.isin(layout.loop_wire, wires))
    cuts = [part for part in (held, None if lands is None else lands.borders(layout)) if part is not None]
    woven = Elements.woven(layout, lines, wires, longest=longest, held=np.concatenate(cuts) if cuts else None)
    free = Elements.loops(layout, loops)
    followers = wire_points(model, lines, layout, (woven, free))
    blocks = (
        truss_block("wires", lines, woven, layout, law, area_mm2, 1.0 + crimp, lands=lands),
        truss_block(LOOPS, lines, free, layout, law, area_mm2, 1.0 + layout.loop_slack[loops], lands=lands),
    )
    if not len(followers.cells):
        return model, Strand(wires, loops, woven, crimp, (), followers)
    rigid = layout.modelled_rigid_mm[loops]
    anchored = _held_ends(model, followers, layout) | _held_places(followers, (woven, free), model, held)
    block = _sliding(model, followers, blocks, rigid, layout, lines, channel, anchored)
    return _with_slip_points(model, block), Strand(wires, loops, woven, crimp, (block,), followers)


def _sliding(
    model: Model,
    followers: Followers,
    parts: tuple[TrussBlock, TrussBlock],
    rigid: Array,
    layout: WireLayout,
    lines: LatticeLines,
    channel: WeaveHold,
    anchored: BoolArray,
) -> SlidingWires:
    """Return woven-in elements and loops as one contribution with the slip points behind all points there are."""
    woven, loops = parts
    ends = followers.cells - len(model.lattice.points)
    points = len(model.points) + np.arange(len(followers.nodes))
    blocks = [_widened(block) for block in parts]
    together = {
        name: np.concatenate([getattr(woven, name), getattr(loops, name)])
        for name in ("rest_length", "span", "offset", "area", "law", "family")
    }
    share = layout.share[followers.wire]
    reach = np.zeros(len(points))
    np.add.at(reach, ends[: len(woven.span)], 0.5 * (woven.span * share[: len(woven.span)])[:, None])
    return SlidingWires(
        name="wires",
        nodes=np.hstack([np.concatenate([nodes for nodes, _ in blocks]), points[ends]]),
        weights=np.hstack([np.concatenate([weights for _, weights in blocks]), np.zeros((len(ends), 2))]),
        laws=woven.laws,
        rigid=np.concatenate([np.zeros(len(woven.span)), rigid]),
        points=points,
        anchored=np.ones(len(points), dtype=bool) if channel.held else anchored,
        channel=reach,
        line_friction=channel.line_friction,
        pressure=_pressure(followers, lines, channel, int(layout.kind[followers.wire[0]])),
        **together,
    )


def _widened(block: TrussBlock) -> tuple[IntArray, Array]:
    """Return nodes and weights (M, 8); what is added repeats the first node with weight zero."""
    missing = _NODES - block.nodes.shape[1]
    nodes = np.hstack([block.nodes, np.repeat(block.nodes[:, :1], missing, axis=1)])
    return nodes, np.hstack([block.weights, np.zeros((len(block.nodes), missing))])


def _held_ends(model: Model, followers: Followers, layout: WireLayout) -> BoolArray:
    """Return which wire points (F,) are ends of a wire whose nodes cannot move along it.

    A laid wire counts as held where its nodes cannot move along either axis: at a clamp and on a symmetry plane.
    """
    ends = followers.cells - len(model.lattice.points)
    uses = np.bincount(ends.ravel(), minlength=len(followers.nodes))
    kind = np.zeros(len(followers.nodes), dtype=np.int64)
    kind[ends] = layout.kind[followers.wire][:, None]
    loose = [((followers.weights > 1e-12) & ~model.fixed[followers.nodes, axis]).any(axis=1) for axis in (0, 1)]
    held: BoolArray = (uses == 1) & ~np.where(
        kind == ALONG_WARP, loose[0], np.where(kind == ALONG_WEFT, loose[1], loose[0] & loose[1])
    )
    return held


def _held_places(followers: Followers, parts: tuple[Elements, Elements], model: Model, held: Array | None) -> BoolArray:
    """Return which wire points (F,) are places where wires are held by a joint or a part."""
    found = np.zeros(len(followers.nodes), dtype=bool)
    ends = followers.cells - len(model.lattice.points)
    wire = np.concatenate([part.wire for part in parts])
    for column, name in enumerate(("start", "end")):
        along = np.concatenate([getattr(part, name) for part in parts])
        for number, place in np.zeros((0, 2)) if held is None else held:
            found[ends[(wire == number) & (np.abs(along - place) < 1e-6), column]] = True
    return found


def _pressure(followers: Followers, lines: LatticeLines, channel: WeaveHold, kind: int) -> WeftPressure | None:
    """Return the grip of the yarns that cross wires of a kind, by the two segments beside each slip point."""
    if channel.tension_factor == 0.0 or channel.strain is None or channel.tension is None:
        return None
    order = [0, 1, 2, 3] if kind == ALONG_WARP else [0, 2, 1, 3]
    nodes, weights = followers.nodes[:, order], followers.weights[:, order]
    rows = len(lines.y)
    place = lines.y[nodes % rows] if kind == ALONG_WARP else lines.x[nodes // rows]
    rest = place[:, 1] - place[:, 0]
    share = np.stack([weights[:, 0] + weights[:, 1], weights[:, 2] + weights[:, 3]], axis=1)
    return WeftPressure(channel.tension_factor, nodes, share, rest, channel.strain, channel.tension)


def _with_slip_points(model: Model, sliding: SlidingWires) -> Model:
    """Return the model with one extra point per slip point, of which only the first component may be free."""
    more = np.zeros((len(sliding.points), 3))
    fixed = np.ones(more.shape, dtype=bool)
    fixed[:, 0] = sliding.anchored
    return replace(
        model,
        points=np.concatenate([model.points, more]),
        fixed=np.concatenate([model.fixed, fixed]),
        carried=np.concatenate([model.carried, more]),
    )
