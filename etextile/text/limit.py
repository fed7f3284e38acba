"""Where a run goes on ever finer lattices, on a terminal: force, loops by state, what may be one state or another."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from rich.text import Text

from etextile.vocabulary import STATES


MOST_LOOPS = 6
"""Loops in doubt that are named."""


def limit_lines(report: Mapping[str, Any]) -> list[Text]:
    """Return the lines about the limit of the lattices, none where it was not asked for."""
    if "limit" not in report:
        return []
    found = report["limit"]
    cells = ", ".join(f"{along} x {across}" for along, across in found["cells"])
    title = Text(f"\n Limit of ever finer lattices ({cells} cells)", style="bold")
    if not found["reached"]:
        return [title, Text(f" none is given: {found['reason']}", style="yellow")]
    end, doubt, own = found["punch_force_N"][-1], found["punch_force_doubt_N"][-1], found["force_N"][0]
    force = f" force at the end {end:.5g} N, give or take {doubt:.2g} N; this run {own:.5g} N, {_off(own, end)}"
    lines = [title, Text(force)]
    loops = found["loops"]
    if loops:
        strains = [(loop["max_span_strain"], loop["span_strain_doubt"]) for loop in loops]
        largest, its_doubt = max(strains)
        lines.append(Text(f" largest strain under a loop {100 * largest:.2f} %, give or take {100 * its_doubt:.2g} %"))
        lines += [Text(line) for line in _states(report, loops)]
    return lines


def _off(own: float, end: float) -> str:
    return f"{100 * (own / end - 1.0):+.1f} %" if end else "no share of it"


def _states(report: Mapping[str, Any], loops: list[Mapping[str, Any]]) -> list[str]:
    """Return loops by state at the limit, how many the run has otherwise, and those that may be in either of two."""
    number = Counter(loop["state"] for loop in loops)
    lines = [" loops: " + ", ".join(f"{number[state]} {state}" for state in STATES if number[state])]
    here = {(wire["wire"], loop["loop"]): loop["state"] for wire in report["wires"] for loop in wire["loops"]}
    other = sum(1 for loop in loops if here.get((loop["wire"], loop["loop"]), loop["state"]) != loop["state"])
    lines[0] += f"; {other} of {len(loops)} are in another state on the lattice of this run"
    open_ones = [loop for loop in loops if loop["state_at_least"] != loop["state_at_most"]]
    if open_ones:
        named = "; ".join(
            f"wire {loop['wire']} loop {loop['loop']} {loop['state_at_least']} or {loop['state_at_most']}"
            for loop in open_ones[:MOST_LOOPS]
        )
        more = f" and {len(open_ones) - MOST_LOOPS} more" if len(open_ones) > MOST_LOOPS else ""
        lines.append(f" within the doubt: {named}{more}")
    return lines
