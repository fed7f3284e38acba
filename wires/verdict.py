"""The verdict in words: how many wires of the whole specimen survive, and where the first one fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from etextile.vocabulary import STATES
from wires.axis import JOINT, PUNCH
from wires.chances import WHOLE_BELOW
from wires.trust import withheld
from wires.wording import probability


Row = Mapping[str, Any]
FEW_NETS = 3
"""So many nets are told one by one."""


def verdict(
    rows: Sequence[Row],
    *,
    reliability: Mapping[str, Any] | None = None,
    life: Mapping[str, Any] | None = None,
    exceeded: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the verdict over the wires of a report; sentences about exceeded trust limits withhold it.

    `survive` is true when the chance that a filament of any wire breaks is below `WHOLE_BELOW`, null when the verdict
    is withheld or there are no wires; `wires` counts the wires of the whole specimen in each state, which follow from
    probabilities. What is expected stands in `reliability` (`wires.reliability`), with the nets of the case; `life` is
    the block of that name (`wires.life`).
    """
    counts = {state: sum(row["copies"] for row in rows if row["state"] == state) for state in STATES}
    instead = withheld(exceeded)
    whole = keeps_all(rows, reliability)
    sentence = _sentence(rows, counts) if reliability is None else _expected(rows, reliability, whole=whole)
    further = (_nets([] if reliability is None else reliability["nets"]), "" if life is None else life["sentence"])
    sentence = " ".join(part for part in (sentence, *further) if part)
    found = {
        "withheld": bool(instead),
        "survive": None if instead or not rows else whole,
        "sentence": instead or sentence,
        "wires": counts,
        "first_failure": _first_failure(rows),
    }
    return _with_folds(found, rows) if rows and JOINT.failure_key in rows[0] else found


def _with_folds(found: dict[str, Any], rows: Sequence[Row]) -> dict[str, Any]:
    """Return the verdict of a worn case, which says how many loops of the whole piece lie in folds."""
    copies = [(loop["folded"], loop["copies"] * row["copies"]) for row in rows for loop in row["loops"]]
    folded, total = sum(count for lies, count in copies if lies), sum(count for _, count in copies)
    found["undetermined_loops"] = folded
    if folded and not found["withheld"]:
        found["sentence"] += (
            f" {folded} of {total} loops lie in folds of the crook, where the model has no answer: they count as "
            "neither whole nor broken by folding."
        )
    return found


def keeps_all(rows: Sequence[Row], reliability: Mapping[str, Any] | None) -> bool:
    """Tell whether every wire keeps every filament: by the garment's probability, or by the states without one."""
    if reliability is None:
        return all(row["state"] in ("intact", "plastic") for row in rows)
    return bool(reliability["p_any_wire_broken"] < WHOLE_BELOW)


def _expected(rows: Sequence[Row], found: Mapping[str, Any], *, whole: bool) -> str:
    """Say how many wires are expected to be lost, and how sure it is that none is."""
    total = found["wires"]
    if not total:
        return "The case has no wires."
    if whole:
        keep = "The wire keeps" if total == 1 else f"All {total} wires keep"
        chance = _chance(found, "p_any_wire_broken")
        return f"{keep} every filament (probability that one is lost anywhere: {chance})."
    parts = [
        f"{_number(found[f'expected_wires_{name}'])} {words} ({low} to {high} in 95 % of garments)"
        for name, words in (("open", "are interrupted"), ("broken", "have lost filaments"))
        for low, high in (found[f"wires_{name}_range"],)
    ]
    return (
        f"Of {total} wire{'' if total == 1 else 's'} on average {' and '.join(parts)}. At least one is interrupted "
        f"with probability {_chance(found, 'p_any_wire_open')}, at least one loses a filament with "
        f"{_chance(found, 'p_any_wire_broken')}. {_first_sentence(rows)}".rstrip()
    )


def _nets(nets: Sequence[Mapping[str, Any]]) -> str:
    """Say how likely the nets are lost: each of a few, the worst of many."""
    if not nets:
        return ""
    if len(nets) <= FEW_NETS:
        each = ", ".join(f"{net['name']} with {probability(net['p_lost'])}" for net in nets)
        return f"Nets are lost with probability: {each}."
    worst = max(nets, key=lambda net: net["p_lost"])
    return f"Of {len(nets)} nets {worst['name']} is lost most likely, with probability {probability(worst['p_lost'])}."


def _number(value: float) -> str:
    return f"{value:.1f}" if value >= 0.05 else "fewer than 0.1"


def _chance(found: Mapping[str, Any], key: str) -> str:
    """Return a probability with what the doubt about the calibration makes of it."""
    low, high = found["intervals"][key]
    value, least, most = (probability(number) for number in (found[key], low, high))
    return value if least == most else f"{value} ({least} to {most})"


def _sentence(rows: Sequence[Row], counts: Mapping[str, int]) -> str:
    """Say how many wires are in which state, where nothing is known of the garment as a whole."""
    total = sum(counts.values())
    if not total:
        return "The case has no wires."
    parts = [
        _count(counts["open"], "interrupted"),
        _count(counts["partial"], "damaged"),
        _count(counts["intact"] + counts["plastic"], "whole"),
    ]
    return f"Of {total} wires {', '.join(part for part in parts if part)}. {_first_sentence(rows)}".rstrip()


def _count(number: int, what: str) -> str:
    """Return `3 are damaged`, or nothing when there are none."""
    return f"{number} {'is' if number == 1 else 'are'} {what}" if number else ""


def _first_sentence(rows: Sequence[Row]) -> str:
    first = _first_failure(rows)
    if first is None:
        return ""
    where = (
        f"in the weave of wire {first['name']}"
        if first["loop"] is None
        else f"wire {first['name']}, loop {first['loop']}"
    )
    return (
        f"The first filament breaks {_when(first)}: {where} "
        f"({first['warp_mm']:.1f} mm along the warp, {first['weft_mm']:.1f} mm along the weft)."
    )


def _when(first: Mapping[str, Any]) -> str:
    """Say where on the motion the first filament breaks."""
    if "angle_deg" not in first:
        return f"at {first['displacement_mm']:.1f} mm"
    return f"at {first['angle_deg']:.1f} deg" if first["angle_deg"] > 0.0 else "while it is put on"


def _first_failure(rows: Sequence[Row]) -> dict[str, Any] | None:
    """Return where and when the first filament of typical wires breaks; of equals the lower number, loops first."""
    axis = JOINT if rows and JOINT.failure_key in rows[0] else PUNCH
    failed = [
        (part[axis.failure_key], row, part)
        for row in rows
        for part in (*row["loops"], *row.get("woven", ()))
        if part[axis.failure_key] is not None
    ]
    if not failed:
        return None
    displacement, row, part = min(failed, key=lambda found: (found[0], "loop" not in found[2]))
    return {
        axis.key: displacement,
        "wire": row["wire"],
        "name": row.get("name", str(row["wire"])),
        "loop": part.get("loop"),
        "warp_mm": part["warp_mm"] if "warp_mm" in part else 0.5 * (part["from_mm"] + part["to_mm"]),
        "weft_mm": part.get("weft_mm", row["weft_mm"]),
    }
