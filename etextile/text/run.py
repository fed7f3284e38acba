"""The reliability report on a terminal, drawn from the report dictionary alone.

Readable at 80 columns and without colours (a pipe, a log file): a loop's state is a letter as well as a colour.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from rich.box import ROUNDED
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.text import Text

from etextile.text.coupon import coupon_table
from etextile.text.limit import limit_lines
from etextile.text.load import load_lines, load_table
from etextile.text.parts import part_table
from etextile.text.plain import as_text, framed
from etextile.text.wear import wear_parts
from viz.style import STATES
from wires.axis import axis_of
from wires.chances import OPEN_FROM, WHOLE_BELOW
from wires.construction import advice_sentences, laid_words
from wires.trust import as_provisional
from wires.wording import (
    FOLDED,
    LETTERS,
    compact,
    figures,
    number,
    percent,
    probability,
    spoken,
    unit_for,
)  # fmt: skip


Report = Mapping[str, Any]

STYLES = {state.name: state.colour for state in STATES} | {
    "intact": "default",
    "open": f"bold white on {STATES[3].colour}",
}
"""The colours of the maps; an intact loop, white there, is written plainly, an open one on its dark ground."""

STRAINS = {
    "wire": "the wire's own, in loops and weave, after slack and crimp",
    "fabric": "of the fabric under the loop (the paper's own reading)",
}
SAFE = ("intact", "plastic")
MANY_WIRES = 24
"""Beyond this number neighbouring wires of the same state share a row."""
MOST_LOOPS = 8
"""Rows in the table of the worst loops."""
COLUMNS = (6, 5, 4)
"""How many displacements are listed: the first of these numbers that divides the steps."""
WIDEST_STRIP = 14
"""Loops of a wire that are shown as letters; with more of them only their number is."""


def report_text(report: Report, *, width: int = 80, folder: Path | None = None) -> str:
    """Return the report as plain text of the given width."""
    return as_text(render(report, folder=folder), width=width)


def render(report: Report, *, folder: Path | None = None) -> RenderableType:
    """Return the whole report for a rich console."""
    loads = load_table(report, spread(len(report["punch"]["force_N"])))
    parts: list[RenderableType] = [_head(report), _verdict(report), _curves(report) if loads is None else loads]
    if report.get("donning"):
        parts.append(_put_on(report))
    if "coupon" in report:
        parts.append(coupon_table(report["coupon"], spread(len(report["coupon"]["strain"]))))
    parts += load_lines(report)
    if report["wires"]:
        parts += [_wires(report)]
        parts += [_worst_loops(report)] if any(wire["loops"] for wire in report["wires"]) else []
        parts += [*wear_parts(report)]
        parts += [part_table(report["parts"])] if report.get("parts") else []
    parts += [advice(report), *limit_lines(report), _laws(report), _trust(report)]
    parts += [Text(f"note: {note}", style="yellow") for note in report.get("notes", ())]
    if folder is not None:
        parts.append(Text(f"\nFiles in {folder}", overflow="fold"))
    return Group(*parts)


def _head(report: Report) -> RenderableType:
    """Title, fabric and body in two lines."""
    case = report["case"]
    size = " x ".join(f"{length:g}" for length in case.get("size_mm", ()))
    facts = [
        f"fabric {case['fabric']}" if case.get("fabric") else "",
        f"{size} mm" if size else "",
        f"coarsening {case['coarsening']:g}" if case.get("coarsening") else "",
        str(case.get("portion", "")),
        f"friction {compact(case['friction'])}" if "friction" in case else "",
        str(case.get("body", "")),
    ]
    facts = [facts[-1], *facts[:-1]]
    second = ", ".join(fact for fact in facts if fact)
    made = made_words(report)
    effects = f"\neffects: {', '.join(case['effects'])}" if case.get("effects") else ""
    return Group(Text(case["title"] or "Untitled case", style="bold"), Text(f"{second}{effects}{made}\n", style="dim"))


def advice(report: Report) -> RenderableType:
    """What to change, where somebody asked for it; else how to ask, where wires fail."""
    said = advice_sentences(report)
    if said:
        return Group(Text("\n What to change", style="bold"), *(Text(f" {sentence}") for sentence in said))
    if report["verdict"]["survive"] is False and "advice" not in report:
        return Text("\n What to change? run --advise tries slack, position and depth, each by a run.", style="dim")
    return Group()


def made_words(report: Report) -> str:
    """Return lines on how the wires are made and laid, and on what the criterion does not look at."""
    model, failure = report.get("wire_model"), report.get("failure")
    if model is None or failure is None:
        return ""
    lines = [
        f"wires: {model['filaments']} x {1000 * model['filament_diameter_mm']:.0f} um {model['material']}",
        laid_words(model),
    ]
    ignores = failure.get("ignores", "")
    judged = f"criterion: {failure['criterion']}" + (f", which ignores {ignores}" if ignores else "")
    return f"\n{'; '.join(line for line in lines if line)}\n{judged}"


def _verdict(report: Report) -> RenderableType:
    """The verdict in a box, coloured by what it says."""
    verdict = report["verdict"]
    style = "yellow" if verdict["withheld"] else {True: "green", False: "red", None: "white"}[verdict["survive"]]
    return Panel(Text(verdict["sentence"]), title="Verdict", title_align="left", border_style=style, box=ROUNDED)


def _curves(report: Report) -> RenderableType:
    """Force or moment and greatest strains at a few displacements or angles."""
    axis = axis_of(report)
    displacement = axis.values(report)
    chosen = spread(len(displacement))
    strain = report["strain"]
    table = framed(f"Over {axis.name}")
    table.add_column(f"{axis.name}, {axis.unit}", no_wrap=True)
    for step in chosen:
        table.add_column(f"{displacement[step]:.4g}", justify="right")
    by, unit = unit_for(axis.responses(report), axis.response_unit)
    table.add_row(f"{axis.response}, {unit}", *(figures(axis.responses(report)[step] / by, 4) for step in chosen))
    rows = {
        "warp strain, max": (strain["warp_max"], "{:.3f}"),
        "weft strain, max": (strain["weft_max"], "{:.3f}"),
        "diagonal strain, max": (strain["diagonal_max"], "{:.3f}"),
        **(_on_limb(report) if "joint" in report else {"edge draw-in, mm": (report["edge"]["draw_in_mm"], "{:.2f}")}),
    }
    for name, (values, form) in rows.items():
        table.add_row(name, *(number(values[step], form) for step in chosen))
    return Group(table, *_pressure(report))


def _pressure(report: Report) -> list[RenderableType]:
    """How hard a body presses at the end, in a line."""
    contact = report.get("contact")
    if contact is None or "joint" in report:
        return []
    return [
        Text(
            f" pressure of the body at the end: {spoken(contact['pressure_kPa_mean'], 'kPa')} on average over "
            f"{figures(0.01 * contact['area_mm2'])} cm2, {spoken(contact['pressure_kPa_max'], 'kPa')} at most",
            style="dim",
        )
    ]


def _on_limb(report: Report) -> dict[str, tuple[Sequence[float | None], str]]:
    """Return the further rows of a worn case: pressure on the skin, slip, folds."""
    skin = report["contact"]["over_angle"]
    by, unit = unit_for(skin["pressure_kPa_max"], "kPa")
    pressures = {
        name: [None if p is None else p / by for p in skin[f"pressure_kPa_{name}"]] for name in ("max", "mean")
    }
    rows: dict[str, tuple[Sequence[float | None], str]] = {
        f"pressure, {unit}, max": (pressures["max"], "{:.3g}"),
        f"pressure, {unit}, mean": (pressures["mean"], "{:.3g}"),
        "folded, % of area": ([100 * share for share in report["joint"]["folded_share"]], "{:.0f}"),
    }
    slip = report["joint"]["slip_mm"]
    return {**rows, "slip of the ends, mm": (slip, "{:.1f}")} if any(slip) else rows


def _put_on(report: Report) -> RenderableType:
    """What putting the piece on did, in a sentence."""
    done = report["donning"]
    strain = done["strain"]
    wire = done["wire_strain_max"]
    return Text(
        f"\n Put on, straight: weft strain to {strain['weft_max']:.3f}, warp to {strain['warp_max']:.3f}"
        + ("" if wire is None else f", wires in loops to {wire:.3f}")
        + f"; pressure {spoken(done['pressure_kPa_mean'], 'kPa')} on average, "
        f"{spoken(done['pressure_kPa_max'], 'kPa')} at most"
    )


def _wires(report: Report) -> RenderableType:
    """Table of wires, the worst loop of each; many wires are grouped where neighbours share a state."""
    wires = report["wires"]
    title = as_provisional("Wires", passed=report["verdict"]["withheld"])
    axis = axis_of(report)
    fails, failure = f"fails at\n{axis.unit}", axis.failure_key
    names = ("wire", "weft\nmm", "loops\n", "state\n", fails, "strain\nmax", "P\nbroken", "P\nopen")
    table = framed(title, *names, words=("loops", "state"))
    narrow = max(len(wire["loops"]) for wire in wires) <= WIDEST_STRIP
    for group in grouped(wires):
        worst = max(group, key=lambda wire: wire["max_strain"])
        digits = 1 if len(group) == 1 else 0
        first = min((w[failure] for w in group if w[failure] is not None), default=None)
        table.add_row(
            _span([wire_name(group[0]), wire_name(group[-1])]),
            _span([_place(group[0], digits), _place(group[-1], digits)]),
            _strip(worst["loops"]) if narrow else Text(str(len(worst["loops"]))),
            _state(worst["state"]),
            number(first, "{:.1f}"),
            number(worst["max_strain"], "{:.3f}"),
            probability(max(wire["failure_probability"] for wire in group)),
            probability(max(wire["open_probability"] for wire in group)),
        )
    return Group(table, _legend(report))


def wire_name(wire: Report) -> str:
    """Return the name of a wire, its number where nobody named it."""
    return str(wire.get("name") or wire["wire"])


def _place(wire: Report, digits: int) -> str:
    """Return where a wire lies: its weft coordinate, or what it follows when that is not the warp."""
    lies = wire.get("lies", "warp")
    return f"{wire['weft_mm']:.{digits}f}" if lies == "warp" else f"({lies})"


def _legend(report: Report) -> Text:
    """Explain the letters, and that a row may stand for several wires of the specimen."""
    text = Text(" loops from -x to +x:", style="dim")
    for state, letter in LETTERS.items():
        text.append(f"  {letter} {state}", style=STYLES[state])
    if "joint" in report:
        text.append(f"  {FOLDED} folded, undetermined")
    text.append(
        f"\n states: partial from P broken {100 * WHOLE_BELOW:g} % on, open from P open {100 * OPEN_FROM:g} % on;"
    )
    text.append("\n a wire can be partial though each of its loops by itself is not")
    text.append(f"\n strain: {STRAINS.get(report['failure'].get('strain_kind'), 'that of the criterion')}")
    if any(wire["copies"] > 1 or any(loop["copies"] > 1 for loop in wire["loops"]) for wire in report["wires"]):
        text.append("\n symmetric: mirror images of these wires and loops are not listed")
    if len(report["wires"]) > MANY_WIRES:
        text.append("\n neighbours of one state share a row, which shows the worst of them")
    return text


def _worst_loops(report: Report) -> RenderableType:
    """The loops with the greatest strain."""
    loops = [(wire, loop) for wire in report["wires"] for loop in wire["loops"]]
    worst = sorted(loops, key=lambda pair: -pair[1]["max_strain"])[:MOST_LOOPS]
    axis = axis_of(report)
    table = framed(
        as_provisional(f"Worst loops ({len(worst)} of {len(loops)})", passed=report["verdict"]["withheld"]),
        *("wire\n", "loop\n", "warp\nmm", "weft\nmm", "state\n", f"fails at\n{axis.unit}", "strain\nmax"),
        "filaments\nbroken",
        words=("state",),
    )
    for wire, loop in worst:
        table.add_row(
            wire_name(wire),
            str(loop["loop"]),
            f"{loop['warp_mm']:.1f}",
            f"{loop.get('weft_mm', wire['weft_mm']):.1f}",
            _state(loop["state"]),
            number(loop[axis.failure_key], "{:.1f}"),
            number(loop["max_strain"], "{:.3f}"),
            percent(loop["filaments_broken"]),
        )
    return table


def _laws(report: Report) -> RenderableType:
    """Say what hangs on laws beyond their range, and list the loops that are open to the law."""
    block = report.get("extrapolation")
    if block is None or not block["beyond"]:
        return Group()
    parts: list[RenderableType] = ["", Text("Laws beyond their range", style="bold"), Text(block["sentence"])]
    hanging = block["verdicts_that_hang_on_it"]
    if hanging:
        table = framed(
            f"Open to the law ({min(len(hanging), MOST_LOOPS)} of {len(hanging)})",
            *("wire\n", "loop\n", "warp\nmm", "weft\nmm", "verdict\n", "low\n", "high\n"),
            words=("verdict", "low", "high"),
        )
        for part in hanging[:MOST_LOOPS]:
            place = part["warp_mm"] if part["loop"] is not None else 0.5 * (part["from_mm"] + part["to_mm"])
            table.add_row(
                str(part["wire"]),
                "-" if part["loop"] is None else str(part["loop"]),
                f"{place:.1f}",
                f"{part['weft_mm']:.1f}",
                *(part.get(name, "?") for name in ("verdict", "low", "high")),
            )
        parts.append(table)
    return Group(*parts)


def _trust(report: Report) -> RenderableType:
    """The trust box: green with the numbers found, amber with the limits exceeded first."""
    trust, solver = report["trust"], report["solver"]
    checks = sorted(trust.get("checks", trust["limits"]), key=lambda check: check["ok"])
    lines = [Text(f"{'ok   ' if check['ok'] else 'LIMIT'}  {check['sentence']}") for check in checks]
    cut_backs = f"{solver['cut_backs']} cut-back{'' if solver['cut_backs'] == 1 else 's'}"
    cost = (
        f"{solver['nodes']} nodes, {solver['trusses']} trusses, {solver['steps']} steps, "
        f"{solver['linear_solves']} linear solves, {cut_backs}, {solver['wall_s']:.1f} s"
    )
    body = Group(*lines, Text(cost, style="dim"))
    title = "Trust: all limits kept" if trust["ok"] else "Trust: LIMIT EXCEEDED"
    style = "green" if trust["ok"] else "yellow"
    return Group("", Panel(body, title=title, title_align="left", border_style=style, box=ROUNDED))


def grouped(wires: Sequence[Report]) -> list[list[Report]]:
    """Return the wires one by one, or, when they are many, neighbours of one state together.

    Wires with broken filaments stay single as long as the table does not get too long.
    """
    if len(wires) <= MANY_WIRES:
        return [[wire] for wire in wires]
    runs = [list(run) for _, run in groupby(wires, key=lambda wire: wire["state"])]
    single = [[wire] for run in runs for wire in run]
    mixed = [part for run in runs for part in ([run] if run[0]["state"] in SAFE else [[wire] for wire in run])]
    return next((rows for rows in (single, mixed) if len(rows) <= MANY_WIRES), runs)


def spread(count: int) -> list[int]:
    """Return a few of the steps 1 ... count - 1, evenly, always with the last; step 0 (flat) only when alone."""
    last = count - 1
    if last < 1:
        return list(range(count))
    wanted = min(next((n for n in COLUMNS if last % n == 0), COLUMNS[0]), last)
    return [round(last * (k + 1) / wanted) for k in range(wanted)]


def _span(ends: Iterable[str]) -> str:
    """Return `a` or `a..b`."""
    first, last = ends
    return first if first == last else f"{first}..{last}"


def _state(state: str) -> Text:
    return Text(state, style=STYLES[state])


def _strip(loops: Sequence[Report]) -> Text:
    """Return one letter per loop."""
    text = Text()
    for loop in loops:
        folded = loop.get("folded") and loop["state"] in SAFE
        text.append(FOLDED if folded else LETTERS[loop["state"]], style=STYLES[loop["state"]])
    return text
