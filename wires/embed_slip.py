"""Wires put into a lattice so that they can slide along their channel, or so that loops carry rigid components.

The same points and elements as `wires.embed`, cut finer so that the wire's tension may change along a lattice cell, as
one contribution (`wires.slip.SlidingWires`) with one unknown per wire point behind the lattice nodes. A wire is held
where its end is: at a clamped edge and on the symmetry plane; at a free edge it can be drawn in against friction alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Followers, Model
from etextile.mechanics.protocol import Contribution
from etextile.mechanics.truss import TrussBlock
from etextile.types import Array, BoolArray, IntArray
from wires.embed import EmbeddedWires, Lines, cut_wire, truss_block, wire_points
from wires.layout import WireLayout
from wires.slip import SlidingWires, WeftPressure


ELEMENT_MM = 1.0
"""Longest woven-in element: slip zones are some millimetres long."""
_NODES = 8


@dataclass(frozen=True)
class Channel:
    """How a wire is held in the weave: line friction N/mm, and tension_factor times the weft's tension (N/mm) more.

    strain, tension (T,): the weft's loading curve, N per mm of warp. `held` True bonds the wire perfectly.
    """

    line_friction: float = 0.0
    tension_factor: float = 0.0
    strain: Array | None = None
    tension: Array | None = None
    held: bool = False
    element_mm: float = ELEMENT_MM


def embed_sliding(
    model: Model,
    layout: WireLayout,
    law: PowerLaw,
    *,
    area_mm2: float,
    crimp: float,
    channel: Channel,
) -> tuple[Model, EmbeddedWires]:
    """Return the model with sliding wires of cross-section `area_mm2` and the record of where they are.

    Raises BadInput when the warp is not along x.
    """
    lines = Lines.of(model.lattice)
    longest = np.inf if channel.held else channel.element_mm
    parts = [cut_wire(layout, lines, wire, longest=longest) for wire in range(layout.n_wires)]
    wire = np.concatenate([np.full(len(a), w) for w, (a, _) in enumerate(parts)] or [np.zeros(0)]).astype(np.int64)
    start, end = (np.concatenate([part[k] for part in parts] or [np.zeros(0)]) for k in (0, 1))
    exits = np.where(layout.loop_halved, 0.0, layout.loop_exit_mm)
    woven = truss_block("wires", lines, start, end, layout, wire, law, area_mm2, 1.0 + crimp)
    loops = truss_block(
        "loops", lines, exits, layout.loop_entry_mm, layout, layout.loop_wire, law, area_mm2, 1.0 + layout.loop_slack
    )
    rigid = layout.modelled_rigid_mm
    record = EmbeddedWires(layout, wire, 0.5 * (start + end), end - start, crimp, rigid)
    if not len(woven.nodes) + len(loops.nodes):
        return model, record
    followers = wire_points(model, lines, layout, [(start, end, wire), (exits, layout.loop_entry_mm, layout.loop_wire)])
    sliding = _sliding(model, followers, woven, loops, rigid, layout, lines, channel)
    first, *others = model.contributions
    return _with_slip_points(model, followers, sliding, (first, sliding, *others)), record


def _sliding(
    model: Model,
    followers: Followers,
    woven: TrussBlock,
    loops: TrussBlock,
    rigid: Array,
    layout: WireLayout,
    lines: Lines,
    channel: Channel,
) -> SlidingWires:
    """Return woven-in elements and loops as one contribution with the slip points behind all nodes."""
    ends = followers.cells - len(model.lattice.points)
    points = len(model.points) + np.arange(len(followers.nodes))
    blocks = [_widened(block) for block in (woven, loops)]
    together = {
        name: np.concatenate([getattr(woven, name), getattr(loops, name)])
        for name in ("rest_length", "span", "area", "law", "family")
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
        anchored=np.ones(len(points), dtype=bool) if channel.held else _held_ends(model, followers, ends),
        channel=reach,
        line_friction=channel.line_friction,
        pressure=_pressure(followers, lines, channel),
        **together,
    )


def _widened(block: TrussBlock) -> tuple[IntArray, Array]:
    """Return nodes and weights (M, 8); what is added repeats the first node with weight zero."""
    missing = _NODES - block.nodes.shape[1]
    nodes = np.hstack([block.nodes, np.repeat(block.nodes[:, :1], missing, axis=1)])
    return nodes, np.hstack([block.weights, np.zeros((len(block.nodes), missing))])


def _held_ends(model: Model, followers: Followers, ends: IntArray) -> BoolArray:
    """Return which wire points (F,) are ends of a wire whose nodes cannot move along the warp."""
    uses = np.bincount(ends.ravel(), minlength=len(followers.nodes))
    loose = (followers.weights > 1e-12) & ~model.fixed[followers.nodes, 0]
    held: BoolArray = (uses == 1) & ~loose.any(axis=1)
    return held


def _pressure(followers: Followers, lines: Lines, channel: Channel) -> WeftPressure | None:
    if channel.tension_factor == 0.0 or channel.strain is None or channel.tension is None:
        return None
    nodes, weights = followers.nodes, followers.weights
    rows = len(lines.y)
    rest = lines.y[nodes[:, 1] % rows] - lines.y[nodes[:, 0] % rows]
    share = np.stack([weights[:, 0] + weights[:, 1], weights[:, 2] + weights[:, 3]], axis=1)
    return WeftPressure(channel.tension_factor, nodes, share, rest, channel.strain, channel.tension)


def _with_slip_points(
    model: Model, followers: Followers, sliding: SlidingWires, contributions: tuple[Contribution, ...]
) -> Model:
    """Return the model with one extra point per slip point, of which only the first component may be free."""
    more = np.zeros((len(sliding.points), 3))
    fixed = np.ones(more.shape, dtype=bool)
    fixed[:, 0] = sliding.anchored
    return replace(
        model,
        points=np.concatenate([model.points, more]),
        fixed=np.concatenate([model.fixed, fixed]),
        carried=np.concatenate([model.carried, more]),
        contributions=contributions,
        followers=followers,
    )
