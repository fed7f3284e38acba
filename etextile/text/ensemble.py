"""What an ensemble says, on a terminal of 80 columns and without colours, from `ensemble.json` alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.box import ROUNDED
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.text import Text

from etextile.text.plain import as_text, framed
from wires.trust import as_provisional
from wires.wording import chance, number, probability


Data = Mapping[str, Any]
MOST_WIRES = 24
MOST_INPUTS = 8


def ensemble_text(data: Data, *, width: int = 80, folder: Path | None = None) -> str:
    """Return the summary of an ensemble as plain text."""
    return as_text(render(data, folder=folder), width=width)


def render(data: Data, *, folder: Path | None = None) -> RenderableType:
    """Return the whole summary for a rich console."""
    parts: list[RenderableType] = [_head(data), _verdict(data)]
    if data["wires"]:
        parts.append(_wires(data))
    if data.get("nets"):
        parts.append(_nets(data))
    if data["ranking"]:
        parts.append(_ranking(data))
    parts += [_inputs(data), Text("")]
    parts += [Text(f"note: {note}", style="yellow") for note in _notes(data)]
    if folder is not None:
        parts.append(
            Text(f"\nFiles in {folder}: ensemble.html, ensemble.json, samples.csv, samples/, plots", overflow="fold")
        )
    return Group(*parts)


def with_interval(values: Data, form: str = "{:.1f}") -> str:
    """Return `value (low .. high)` of numbers that may not exist."""
    return f"{number(values['value'], form)} ({number(values['low'], form)} .. {number(values['high'], form)})"


def _head(data: Data) -> RenderableType:
    broken = f", {data['failed_runs']} of them without equilibrium" if data["failed_runs"] else ""
    words = {"sobol": "Sobol points", "lhs": "a Latin hypercube"}[data["method"]]
    facts = f"{data['samples']} samples by {words}, seed {data['seed']}{broken}\n"
    return Group(Text(data["case"]["title"], style="bold"), Text(facts, style="dim"))


def _verdict(data: Data) -> RenderableType:
    """The specimen as a whole, in a box; what withholds its verdict first."""
    specimen, held = data["specimen"], data["verdict"]["withheld"]
    end = data["fragility"]["displacement_mm"][-1]
    unit = unit_of(data)
    lines = [f"{data['verdict']['sentence']}\n"] if held else []
    lines += [f"At {end:.4g} {unit}, with 95 % intervals:"]
    for name, words in (("any_failure", "some wire has lost a filament"), ("any_open", "some wire is interrupted")):
        lines.append(f"  {words:<32} P {_share(specimen[name])}")
        if specimen[name]["calibration_high"] > specimen[name]["calibration_low"]:
            lines.append(f"    {'what the coupons leave open':<30}   {_calibration(specimen[name])}")
    for name, words in (("share_failed", "wires that lost a filament"), ("share_open", "wires interrupted")):
        lines.append(f"  {words:<32} {_share(specimen[name])} of {specimen['wires']}")
    half = specimen["half_failed_mm"]
    if half["value"] is not None:
        lines.append(f"Half of the specimens have lost a filament at {with_interval(half)} {unit}.")
    title = as_provisional("Failure probability", passed=held)
    return Panel(Text("\n".join(lines)), title=title, title_align="left", box=ROUNDED)


def unit_of(data: Data) -> str:
    """Return the unit of the motion: mm, or deg of a joint (below 0 mm that are missing while a piece is put on)."""
    return str(data.get("unit", "mm")).replace("**", "")


def _share(values: Data) -> str:
    return f"{chance(values['value'])} ({chance(values['low'])} .. {chance(values['high'])})"


def _calibration(values: Data) -> str:
    """Return the interval that what is not known of the coupons gives a probability, as a run has it."""
    return f"{chance(values['calibration_low'])} .. {chance(values['calibration_high'])}"


def _nets(data: Data) -> RenderableType:
    """The nets, those most likely lost first."""
    nets = sorted(data["nets"], key=lambda net: -net["loss_probability"])
    title = as_provisional(f"Nets ({min(MOST_WIRES, len(nets))} of {len(nets)})", passed=data["verdict"]["withheld"])
    table = framed(title, "net\n", "P lost\n", "95 %\n", "by the\ncoupons", fold=("net",))
    for net in nets[:MOST_WIRES]:
        ends = [(net["low"], net["high"]), (net["calibration_low"], net["calibration_high"])]
        spans = [f"{probability(low)} .. {probability(high)}" for low, high in ends]
        table.add_row(str(net["name"]), probability(net["loss_probability"]), *spans)
    return table


def _wires(data: Data) -> RenderableType:
    """The wires, or the worst of many."""
    wires = data["wires"]
    shown = wires
    if len(wires) > MOST_WIRES:
        worst = sorted(wires, key=lambda wire: (-wire["failure_probability"], -wire["open_probability"]))
        shown = sorted(worst[:MOST_WIRES], key=lambda wire: int(wire["wire"]))
    half = f"half broken at\n{unit_of(data)}"
    named = "Wires" if len(shown) == len(wires) else f"Wires ({len(shown)} most endangered of {len(wires)})"
    table = framed(
        as_provisional(named, passed=data["verdict"]["withheld"]),
        *(
            "wire\n",
            "weft\nmm",
            "P filament\nbroken",
            "95 %\n",
            "P open\n",
            "95 %\n",
            half,
        ),
    )
    for wire in shown:
        table.add_row(
            str(wire.get("name", wire["wire"])),
            f"{wire['weft_mm']:.1f}",
            probability(wire["failure_probability"]),
            f"{wire['low']:.3f} .. {wire['high']:.3f}",
            probability(wire["open_probability"]),
            f"{wire['open_low']:.3f} .. {wire['open_high']:.3f}",
            number(wire["half_failed_mm"]["value"], "{:.1f}"),
        )
    parts: list[RenderableType] = [table]
    if any(wire["copies"] > 1 or any(loop["copies"] > 1 for loop in wire["loops"]) for wire in wires):
        parts.append(Text(" symmetric: mirror images of these wires and loops are not listed", style="dim"))
    return Group(*parts)


def _ranking(data: Data) -> RenderableType:
    """The inputs that matter, by output."""
    table = framed(
        "Which input matters (Spearman's rank correlation)",
        "output",
        "input",
        "correlation",
        "95 %",
        words=("output", "input"),
    )
    for output, words in (("share_failed", "wires broken at the end"), ("first_failure_mm", "first break")):
        rows = [row for row in data["ranking"] if row["output"] == output]
        sure = [row for row in rows if row["matters"]][:MOST_INPUTS]
        for row in sure:
            interval = f"{row['low']:+.2f} .. {row['high']:+.2f}"
            table.add_row(words, row["label"], f"{row['rank_correlation']:+.2f}", interval)
        if rows and not sure:
            table.add_row(words, "none beyond chance", "", "")
    return table


def _inputs(data: Data) -> RenderableType:
    """What scattered."""
    table = framed("Scattered inputs", "input", "distribution", words=("input",), fold=("distribution",))
    for item in data["inputs"]:
        table.add_row(item["label"], item["distribution"])
    return table


def _notes(data: Data) -> list[str]:
    """Everything a reader should know."""
    notes = list(data["notes"])
    over = data["trust"]["samples_over_limits"]
    if over:
        limits = ", ".join(f"{name} in {count}" for name, count in data["trust"]["limits"].items())
        notes.append(f"{over} of {data['samples']} samples passed a trust limit ({limits})")
    if data["failed_runs"]:
        reasons = data["failed"][0]["reason"]
        notes.append(
            f"{data['failed_runs']} runs broke off; their wires count between what was seen and certain failure, the "
            f"value is the middle (sample {data['failed'][0]['sample']}: {reasons})"
        )
    return notes
