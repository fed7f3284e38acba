"""The verdict in words: how many wires of the whole specimen survive, and where the first one fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from wires.damage import STATES
from wires.wording import probability


Row = Mapping[str, Any]


def verdict(rows: Sequence[Row], *, exceeded: Sequence[str] = ()) -> dict[str, Any]:
    """Return the verdict over the wires of a report; sentences about exceeded trust limits withhold it.

    `survive` is true when no filament of any wire breaks, false when one does, null when the verdict is withheld or
    there are no wires; `wires` counts the wires of the whole specimen in each state.
    """
    counts = {state: sum(row["copies"] for row in rows if row["state"] == state) for state in STATES}
    broken = counts["partial"] + counts["open"]
    withheld = bool(exceeded)
    reason = "; ".join(exceeded)
    return {
        "withheld": withheld,
        "survive": None if withheld or not rows else broken == 0,
        "sentence": f"Verdict withheld: {reason}." if withheld else _sentence(rows, counts),
        "wires": counts,
        "first_failure": _first_failure(rows),
    }


def _sentence(rows: Sequence[Row], counts: Mapping[str, int]) -> str:
    """Say what happened to the wires."""
    total = sum(counts.values())
    if not total:
        return "The case has no wires."
    if not counts["partial"] and not counts["open"]:
        risk = (
            probability(max(row["failure_probability"] for row in rows)).replace("<", "below ").replace(">", "above ")
        )
        whole = "The wire keeps" if total == 1 else f"All {total} wires keep"
        return f"{whole} every filament (probability that a wire loses one: {risk})."
    parts = [
        _count(counts["open"], "interrupted"),
        _count(counts["partial"], "damaged but conducting"),
        _count(counts["intact"] + counts["plastic"], "whole"),
    ]
    return f"Of {total} wires {', '.join(part for part in parts if part)}. {_first_sentence(rows)}"


def _count(number: int, what: str) -> str:
    """Return `3 are damaged`, or nothing when there are none."""
    return f"{number} {'is' if number == 1 else 'are'} {what}" if number else ""


def _first_sentence(rows: Sequence[Row]) -> str:
    first = _first_failure(rows)
    if first is None:
        return ""
    return (
        f"The first filament breaks at {first['displacement_mm']:.1f} mm: wire {first['wire']}, loop {first['loop']} "
        f"({first['warp_mm']:.0f} mm along the warp, {first['weft_mm']:.1f} mm along the weft)."
    )


def _first_failure(rows: Sequence[Row]) -> dict[str, Any] | None:
    """Return where and when the first filament breaks; of equals the lower number."""
    failed = [(row, loop) for row in rows for loop in row["loops"] if loop["first_failure_mm"] is not None]
    if not failed:
        return None
    row, loop = min(failed, key=lambda pair: pair[1]["first_failure_mm"])
    return {
        "displacement_mm": loop["first_failure_mm"],
        "wire": row["wire"],
        "loop": loop["loop"],
        "warp_mm": loop["warp_mm"],
        "weft_mm": row["weft_mm"],
    }
