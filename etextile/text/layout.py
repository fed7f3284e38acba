"""What is drawn of wires and parts, as text."""

from __future__ import annotations

from collections.abc import Iterator

from etextile.results.wire_layout import KINDS
from etextile.text.columns import Columns
from wires.drawing import Drawing, shown
from wires.drawn import PathSpec


def counts(drawn: Drawing) -> str:
    """Return how many wires, loops and parts there are."""
    loops = sum(len(spec.loops) for spec in drawn.wires)
    counts = ((len(drawn.wires), "wire"), (loops, "loop"), (len(drawn.parts), "part"))
    return ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for count, name in counts)


def layout(drawn: Drawing) -> Iterator[Columns]:
    """Yield wires and parts as tables."""
    rows = [
        (
            spec.name,
            KINDS[spec.kind],
            shown(spec.points[0]),
            shown(spec.points[-1]),
            f"{_length(spec):.4g}",
            str(len(spec.points)),
            _loops(spec),
        )
        for spec in drawn.wires
    ]
    yield Columns("wires", ("name", "lies", "from", "to", "length, mm", "vertices", "loops"), rows)
    parts = [
        (
            part.name,
            shown(part.at),
            f"{part.size[0]:g} x {part.size[1]:g}",
            "rigid" if part.rigid else "loose",
            ", ".join(part.connects or ("the wires it lies on",)),
        )
        for part in drawn.parts
    ]
    if parts:
        yield Columns("parts", ("name", "at", "size, mm", "land", "connects"), parts)


def _length(spec: PathSpec) -> float:
    along = spec.along
    return float(along.max() - along.min())


def _loops(spec: PathSpec) -> str:
    """Say how many loops of which kind a wire has."""
    kinds: dict[tuple[float, float, float], int] = {}
    for loop in spec.loops:
        key = (round(loop.length_mm, 6), loop.slack, loop.rigid_mm)
        kinds[key] = kinds.get(key, 0) + 1
    texts = [
        f"{count} of {length:g} mm, slack {100 * slack:g} %" + (f", part of {rigid:g} mm" if rigid else "")
        for (length, slack, rigid), count in kinds.items()
    ]
    return "; ".join(texts) or "none"
