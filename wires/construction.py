"""How the wires of a run lie: number, distances, loops and their slack for the report, and the words for them.

Also the words for what could be changed about it (`etextile.studies.advice`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from etextile.results.wire_layout import ALONG_WARP, WireLayout
from etextile.types import Array


REGULAR = 0.01
"""Distances that differ by less than this share of the largest are one distance."""


def laid(layout: WireLayout) -> dict[str, Any]:
    """Return number of wires and loops of the whole specimen, distances between them, lengths and slack of loops.

    pitch_mm, loop_spacing_mm: smallest and largest distance between neighbours, loop_length_mm and slack: smallest and
    largest; None where there are none. Wires off the warp have no pitch.
    """
    straight = np.sort(layout.weft_mm[layout.kind == ALONG_WARP])
    middle = 0.5 * (layout.loop_exit_mm + layout.loop_entry_mm)
    gaps = [np.diff(np.sort(middle[layout.loop_wire == wire])) for wire in range(layout.n_wires)]
    return {
        "wires": int(layout.wire_copies.sum()),
        "loops": int((layout.loop_copies * layout.wire_copies[layout.loop_wire]).sum()),
        "pitch_mm": _range(np.diff(straight) if len(straight) == layout.n_wires else np.zeros(0)),
        "loop_spacing_mm": _range(np.concatenate(gaps) if gaps else np.zeros(0)),
        "loop_length_mm": _range(layout.loop_span_mm),
        "slack": _range(layout.loop_slack),
    }


def _range(values: Array) -> list[float] | None:
    return [float(values.min()), float(values.max())] if len(values) else None


def laid_words(model: Mapping[str, Any]) -> str:
    """Return how the wires lie in one line, from the block `wire_model` of a report; '' for those of older files."""
    if "wires" not in model:
        return ""
    pitch, spacing = _between(model["pitch_mm"], "every {} mm"), _between(model["loop_spacing_mm"], "every {} mm")
    parts = [f"{model['wires']} wire{'' if model['wires'] == 1 else 's'}{pitch and ' ' + pitch}"]
    if model["loops"]:
        length, slack = _between(model["loop_length_mm"], "{} mm"), _between(model["slack"], "{}", percents=True)
        parts.append(f"{model['loops']} loops of {length}{spacing and ' ' + spacing} with {slack} slack")
    else:
        parts.append("no loops")
    if model["crimp"] is not None:
        parts.append(f"crimp {percent_of(model['crimp'])}")
    return ", ".join(parts)


def percent_of(share: float) -> str:
    """Return a share in per cent with the digits that it has."""
    return f"{100 * share:.3g} %"


def _between(ends: list[float] | None, form: str, *, percents: bool = False) -> str:
    """Return one number, or `low to high` where they differ, in a form; '' for none."""
    if ends is None:
        return ""
    low, high = ends
    scale, unit = (100.0, " %") if percents else (1.0, "")
    if high - low <= REGULAR * abs(high):
        return form.format(f"{scale * 0.5 * (low + high):.3g}{unit}")
    return form.format(f"{scale * low:.3g} to {scale * high:.3g}{unit}")


def advice_sentences(report: Mapping[str, Any]) -> list[str]:
    """Return what to change, one sentence each, from a report; none where nobody asked."""
    block = report.get("advice")
    if block is None:
        return []
    said = [block["sentence"]] if block["sentence"] else [row["sentence"] for row in block["changes"]]
    return [*said, *([f"{block['note'].capitalize()}."] if block.get("note") else [])]
