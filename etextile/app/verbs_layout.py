"""The verb layout: what is drawn of wires and parts, listed or written as a drawing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

import etextile as et
from etextile.app.options import AllowCode, CaseName, Overrides, Quiet


if TYPE_CHECKING:
    from wires.drawing import Drawing
    from wires.drawn import PathSpec


def layout(
    case: CaseName,
    /,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"], show_default=False)] = None,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    quiet: Quiet = False,
) -> int:
    """List the wires, loops and parts of a case, or write them as a drawing.

    Parameters
    ----------
    output
        Drawing to write, .dxf or .csv; without it the wires and parts are listed.
    force
        Overwrite the drawing.
    """
    loaded = et.load(case, overrides, allow_code=allow_code)
    if output is None:
        from etextile.studies.layout import read_layout

        print_layout(read_layout(loaded))
        return 0
    drawn = et.layout(loaded, output, force=force)
    if not quiet:
        print(f"{output}: {_counts(drawn)}\na case reads it with wires: {{layout: {output}}}")
    return 0


def _counts(drawn: Drawing) -> str:
    loops = sum(len(spec.loops) for spec in drawn.wires)
    counts = ((len(drawn.wires), "wire"), (loops, "loop"), (len(drawn.parts), "part"))
    return ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for count, name in counts)


def print_layout(drawn: Drawing) -> None:
    """Print wires and parts as tables."""
    from etextile.app.tables import print_table
    from etextile.results.wire_layout import KINDS
    from wires.drawing import shown

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
    print_table("wires", ("name", "lies", "from", "to", "length, mm", "vertices", "loops"), rows)
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
        print_table("parts", ("name", "at", "size, mm", "land", "connects"), parts)


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
