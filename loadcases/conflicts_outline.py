"""What does not fit together in cases with an outline or a load instead of a body."""

from __future__ import annotations

from collections.abc import Iterator

from loadcases.conflicts import Conflict
from loadcases.schema_outline import PolygonOutline
from loadcases.schema_parts import FabricPiece, Motion, Supports


def outline_conflicts(fabric: FabricPiece, supports: Supports, motion: Motion, *, wires: bool) -> Iterator[Conflict]:
    """Yield an outline that is not clamped, moves, holds wires or cannot be halved."""
    outline, clamped = fabric.outline, supports.clamped
    if outline is None:
        return
    if clamped != ("outline",):
        message = f"a piece with an outline is clamped all round (got {list(clamped)}), write [outline]"
        yield Conflict(message, (("supports", "clamped"), ("fabric", "outline")))
    if wires:
        yield Conflict("wires need a rectangular piece, use wires: null", (("wires",), ("fabric", "outline")))
    if motion.target not in ("body", "pressure"):
        message = f"an outline stands still (got {motion.target!r}), use body or pressure"
        yield Conflict(message, (("motion", "target"), ("fabric", "outline")))
    portion = fabric.portion
    if portion != "whole" and isinstance(outline, PolygonOutline) and not _mirrored(outline.polygon, portion):
        message = f"a {portion} needs a polygon symmetric about its planes, set fabric.portion to whole"
        yield Conflict(message, (("fabric", "portion"), ("fabric", "outline")))


def _mirrored(corners: tuple[tuple[float, float], ...], portion: str) -> bool:
    """Tell whether a polygon is its own mirror image about the planes of a portion."""
    known = {(round(x, 6), round(y, 6)) for x, y in corners}
    signs = ((-1, 1), (1, -1)) if portion == "quarter" else ((-1, 1),)
    return all({(round(a * x, 6) + 0.0, round(b * y, 6) + 0.0) for x, y in known} == known for a, b in signs)


OPPOSITE = ({"x_min", "x_max"}, {"y_min", "y_max"})


def load_conflicts(supports: Supports, motion: Motion, *, wires: bool, body: bool, bends: bool) -> Iterator[Conflict]:
    """Yield what stands in the way of a load: a body, wires, a rim that is not closed, a flap that nothing holds up.

    `bends`: whether an effect may resist bending.
    """
    target = motion.target
    if target not in ("pressure", "weight"):
        return
    if body:
        message = f"the body would stand in the way of a {target}, use body: null"
        yield Conflict(message, (("body",), ("motion", "target")))
    if wires:
        message = f"wires are judged over a displacement (target is {target!r}), use wires: null"
        yield Conflict(message, (("wires",), ("motion", "target")))
    held = set(supports.edges)
    if target == "pressure" and not {"x_min", "x_max", "y_min", "y_max"} <= held:
        message = f"pressure needs a piece that is clamped all round (got {list(supports.clamped)}), use [outline]"
        yield Conflict(message, (("supports", "clamped"), ("motion", "target")))
    if target == "weight" and not bends and not any(pair <= held for pair in OPPOSITE):
        message = (
            "a piece held on one side carries its weight by bending stiffness alone, and this one has none: it would "
            "hang straight down at any weight; add effects: [{id: bending_stiffness, D: ...}], or clamp opposite edges"
        )
        yield Conflict(message, (("motion", "target"), ("effects",)))
