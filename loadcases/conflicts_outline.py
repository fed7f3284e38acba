"""What does not fit together in cases with an outline or a load instead of a body."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from loadcases.conflicts import Conflict


if TYPE_CHECKING:
    from loadcases.schema import Case


def outline_conflicts(case: Case) -> Iterator[Conflict]:
    """Yield an outline that is not clamped or cannot be halved, and loads that find no closed rim."""
    yield from _outline_conflicts(case)
    yield from _load_conflicts(case)


def _outline_conflicts(case: Case) -> Iterator[Conflict]:
    outline, clamped = case.fabric.outline, case.supports.clamped
    if outline is None:
        return
    if clamped != ("outline",):
        message = f"a piece with an outline is clamped all round (got {list(clamped)}), write [outline]"
        yield Conflict(message, (("supports", "clamped"), ("fabric", "outline")))
    if case.wires is not None:
        yield Conflict("wires need a rectangular piece, use wires: null", (("wires",), ("fabric", "outline")))
    if case.motion.target not in ("body", "pressure"):
        message = f"an outline stands still (got {case.motion.target!r}), use body or pressure"
        yield Conflict(message, (("motion", "target"), ("fabric", "outline")))
    portion = case.fabric.portion
    if portion != "whole" and not hasattr(outline, "circle") and not _mirrored(outline.polygon, portion):
        message = f"a {portion} needs a polygon symmetric about its planes, set fabric.portion to whole"
        yield Conflict(message, (("fabric", "portion"), ("fabric", "outline")))


def _mirrored(corners: tuple[tuple[float, float], ...], portion: str) -> bool:
    """Tell whether a polygon is its own mirror image about the planes of a portion."""
    known = {(round(x, 6), round(y, 6)) for x, y in corners}
    signs = ((-1, 1), (1, -1)) if portion == "quarter" else ((-1, 1),)
    return all({(round(a * x, 6) + 0.0, round(b * y, 6) + 0.0) for x, y in known} == known for a, b in signs)


def _load_conflicts(case: Case) -> Iterator[Conflict]:
    target = case.motion.target
    if target not in ("pressure", "weight"):
        return
    if case.body is not None:
        message = f"the body would stand in the way of a {target}, use body: null"
        yield Conflict(message, (("body",), ("motion", "target")))
    held = set(case.supports.edges)
    if target == "pressure" and not {"x_min", "x_max", "y_min", "y_max"} <= held:
        message = f"pressure needs a piece that is clamped all round (got {list(case.supports.clamped)}), use [outline]"
        yield Conflict(message, (("supports", "clamped"), ("motion", "target")))
