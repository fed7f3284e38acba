"""Where the conductive wires and their clearance loops lie: pure geometry, before any lattice exists.

Everything is in material coordinates with the origin in the specimen centre: x along the warp (the wires), y along the
weft. The lattice is not known here, so the same wires come out at every coarsening.

Rules:

* Wires stand at `first_offset + k * spacing` along the weft, for all whole k. A wire nearer to an edge than
  `edge_margin_mm` (one warp yarn by default) is left out, since the weave does not hold it.
* Loops are centred at `loop_offset + k * loop_spacing` along the warp, for all whole k. A loop is left out unless the
  wire is woven in for at least `clamp_margin_mm` (half a loop length by default) between it and either wire end.
* Wires are numbered from -y to +y, the loops of a wire from -x to +x, both from 0. Loops are stored wire by wire.
* A half keeps x >= 0, a quarter x >= 0 and y >= 0, a side (of a worn piece) y >= 0.
* A wire on the plane y = 0 carries half its area; a loop centred on
  x = 0 is modelled by its half, but its stored exit and entry are those of the full loop.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.results.wire_layout import WireLayout as WireLayout
from etextile.results.wire_layout import straight_warp
from etextile.types import Array, BoolArray


Portion = Literal["quarter", "half", "whole", "side"]

WARP_YARN_MM = 1.0 / 11.0
"""Spacing of the warp yarns of the paper's fabric (11000 per m): the least distance of a wire from a free edge."""

_TINY_MM = 1e-9

MOST = 100_000
"""Most wires or loops in a row, and most loops of a specimen."""


def lay_out(
    *,
    length_mm: float,
    width_mm: float,
    portion: Portion = "whole",
    wire_spacing_mm: float,
    first_offset_mm: float = 0.0,
    loop_spacing_mm: float | None,
    loop_length_mm: float,
    loop_slack: float,
    loop_offset_mm: float = 0.0,
    loop_rigid_mm: float = 0.0,
    edge_margin_mm: float = WARP_YARN_MM,
    clamp_margin_mm: float | None = None,
) -> WireLayout:
    """Lay the wires and loops of a specimen out (rules in the module docstring).

    `length_mm` (along the warp) and `width_mm` are those of the whole free specimen. No `loop_spacing_mm` means no
    loops. Raises BadInput for impossible dimensions and for a loop that the plane x = 0 cuts beside its centre.
    """
    _check_sizes(length_mm, width_mm, wire_spacing_mm, loop_spacing_mm, loop_length_mm, loop_slack)
    half = loop_length_mm / 2
    halved, sided = portion in ("half", "quarter"), portion in ("quarter", "side")
    all_wires = comb(first_offset_mm, wire_spacing_mm, width_mm / 2, key="wires.every_warp_yarns")
    all_wires = all_wires[np.abs(all_wires) <= width_mm / 2 - edge_margin_mm + _TINY_MM]
    all_loops = np.zeros(0)
    if loop_spacing_mm is not None:
        all_loops = comb(loop_offset_mm, loop_spacing_mm, length_mm / 2, key="wires.loops.spacing")
    loops = _kept_half(all_loops, half) if halved else all_loops
    if len(all_wires) * len(all_loops) > MOST:
        message = f"{len(all_wires)} wires with {len(all_loops)} loops each are too many, at most {MOST} loops"
        raise BadInput.of(message, key="wires.loops.spacing")
    weft = all_wires[all_wires >= 0.0] if sided else all_wires
    start = np.full(weft.size, 0.0 if halved else -length_mm / 2)
    end = np.full(weft.size, length_mm / 2)
    inside = _inside(loops, start, end, half + (half if clamp_margin_mm is None else clamp_margin_mm), halved=halved)
    wire, column = np.nonzero(inside)
    centre = loops[column]
    return WireLayout(
        **straight_warp(weft, start, end),
        kind=np.zeros(weft.size, dtype=np.int64),
        names=tuple(str(number) for number in range(weft.size)),
        weft_mm=weft,
        start_mm=start,
        end_mm=end,
        share=np.where((weft == 0.0) & sided, 0.5, 1.0),
        loop_wire=wire.astype(np.int64),
        loop_index=(np.cumsum(inside, axis=1) - 1)[wire, column].astype(np.int64),
        loop_warp_mm=centre,
        loop_exit_mm=centre - half,
        loop_entry_mm=centre + half,
        loop_slack=np.full(centre.size, float(loop_slack)),
        loop_rigid_mm=np.full(centre.size, float(loop_rigid_mm)),
        loop_halved=(centre == 0.0) & halved,
        loop_copies=np.where((centre == 0.0) | (not halved), 1, 2),
        wire_copies=np.where((weft == 0.0) | (not sided), 1, 2),
        symmetric=(not sided or _is_mirrored(all_wires)) and (not halved or _is_mirrored(all_loops)),
    )


def _check_sizes(
    length: float, width: float, wire_spacing: float, loop_spacing: float | None, loop_length: float, slack: float
) -> None:
    """Raise BadInput listing every dimension that cannot be laid out."""
    positive = {"fabric.size": min(length, width), "wires.every_warp_yarns": wire_spacing}
    if loop_spacing is not None:
        positive |= {"wires.loops.spacing": loop_spacing, "wires.loops.length": loop_length}
    found = [Problem(f"must be greater than 0 (got {v:g})", key=key) for key, v in positive.items() if not v > 0.0]
    if not (np.isfinite(slack) and slack >= 0.0):
        found.append(Problem(f"must be finite and not negative (got {slack:g})", key="wires.loops.slack"))
    if loop_spacing is not None and 0.0 < loop_spacing <= loop_length:
        message = f"must be less than the loop spacing {loop_spacing:g} mm (got {loop_length:g} mm)"
        found.append(Problem(message, key="wires.loops.length"))
    if found:
        raise BadInput(found)


def comb(offset: float, spacing: float, reach: float, *, key: str) -> Array:
    """Return all `offset + k * spacing` within [-reach, reach], increasing; rounding dust at 0 is removed.

    Raises BadInput at `key` for more places than MOST.
    """
    if not 2.0 * reach / spacing <= MOST:
        message = f"{spacing:g} mm makes {2.0 * reach / spacing:.3g} of them in {2.0 * reach:g} mm, at most {MOST}"
        raise BadInput.of(message, key=key)
    first = np.ceil((-reach - offset) / spacing - 1e-12)
    last = np.floor((reach - offset) / spacing + 1e-12)
    points = offset + spacing * np.arange(first, last + 1.0)
    return np.where(np.abs(points) <= _TINY_MM, 0.0, points)


def _is_mirrored(points: Array) -> bool:
    """Tell whether increasing points are their own mirror image."""
    return bool(np.allclose(points, -points[::-1], atol=1e-6))


def _kept_half(loops: Array, half: float) -> Array:
    """Return the loop centres with x >= 0; raises BadInput when x = 0 cuts a loop beside its centre."""
    cut = loops[(np.abs(loops) < half - _TINY_MM) & (np.abs(loops) > _TINY_MM)]
    if cut.size:
        message = (
            f"the loop at {cut[0]:g} mm is cut by the symmetry plane beside its centre; "
            f"centre it (offset 0), move it by half a loop length, or take fabric.portion whole"
        )
        raise BadInput.of(message, key="wires.loops.offset")
    return loops[loops >= 0.0]


def _inside(loops: Array, start: Array, end: Array, reach: float, *, halved: bool) -> BoolArray:
    """Return (W, C): whether each loop centre keeps `reach` from both wire ends (a symmetry plane is no wire end)."""
    from_start = loops[None, :] - start[:, None] >= reach - _TINY_MM
    if halved:
        from_start = np.ones_like(from_start)
    to_end = end[:, None] - loops[None, :] >= reach - _TINY_MM
    result: BoolArray = from_start & to_end
    return result
