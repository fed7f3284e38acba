"""Life statistics on a terminal of 80 columns, from the data of life.json alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rich.box import ROUNDED
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.text import Text

from etextile.text.plain import as_text, framed
from wires.wording import cycles, probability


NAMES = {"weibull": "Weibull", "lognormal": "lognormal"}


def life_text(data: Mapping[str, Any], *, folder: Path | None = None) -> str:
    """Return the statistics as plain text."""
    parts: list[RenderableType] = [
        Panel(Text("\n".join(sentences(data))), title="Life", title_align="left", box=ROUNDED),
        _lives(data),
        _fits(data),
        _terms(data),
        Text(""),
    ]
    parts += [Text(f"note: {note}", style="yellow") for note in data["notes"]]
    if folder is not None:
        parts.append(Text(f"\nFiles in {folder}: life.json, life.png", overflow="fold"))
    return as_text(Group(*parts))


def sentences(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield what was found in words."""
    percent = f"{100 * data['confidence']:g} %"
    for row in data["areas"]:
        if row["b10"] is not None:
            apart = "" if row["told_apart"] else "; the lognormal fits about equally well"
            yield (
                f"{row['area']}: 10 % have failed by {cycles(row['b10']['value'])} cycles ({percent}: "
                f"{_range(row['b10'])}), {NAMES[row['best']]}{apart}."
            )
        elif row["without_failures"] is not None:
            found = row["without_failures"]
            most = probability(found["p_below_high"])
            yield (
                f"{row['area']}: none of {row['specimens']} failed. P(life below {cycles(found['cycles'])} "
                f"cycles) is at most {most} ({percent})."
            )
        else:
            yield f"{row['area']}: no distribution could be fitted."
        below = row["p_below_required"]
        if below is not None:
            value, low, high = (probability(below[name]) for name in ("value", "low", "high"))
            yield (
                f"{row['area']}: P(life below the required {cycles(data['required_cycles'])} cycles) = "
                f"{value} ({percent}: {low} to {high})."
            )
    if len(data["areas"]) > 1 and data["critical_area"] is not None:
        differ = data["areas_differ"]
        told = "" if differ is None else f" (that all areas are alike has p = {probability(differ['p_value'])})"
        yield f"Critical area: {data['critical_area']}{told}."


def _lives(data: Mapping[str, Any]) -> RenderableType:
    table = framed(
        "Lives",
        "area",
        "specimens\n",
        "failures\n",
        "known\nexactly",
        "between\ninspections",
        "going\non",
        "modes\n",
        words=("area", "modes"),
    )
    for row in data["areas"]:
        modes = ", ".join(f"{count} {mode}" for mode, count in row["modes"].items())
        counts = (row[name] for name in ("specimens", "failures", "known", "between_inspections", "going_on"))
        table.add_row(row["area"], *map(str, counts), modes or "-")
    return table


def _fits(data: Mapping[str, Any]) -> RenderableType:
    table = framed(
        f"Fits, with bounds of {100 * data['confidence']:g} % by the likelihood ratio",
        *("area", "distribution\n", "shape or sigma\n", "63 % or median\n", "B10, cycles\n", "AIC\n"),
        words=("area", "distribution"),
    )
    for row in data["areas"]:
        for name, own in row["fits"].items():
            if own["failed"] is not None:
                table.add_row(row["area"], NAMES[name], own["failed"], "", "", "")
                continue
            spread, place = ("shape", "scale") if name == "weibull" else ("sigma", "median")
            table.add_row(
                row["area"],
                NAMES[name],
                f"{own[spread]['value']:.3g}\n{_bounds(own[spread], '{:.3g}')}",
                f"{cycles(own[place]['value'])}\n{_range(own[place])}",
                f"{cycles(own['b10']['value'])}\n{_range(own['b10'])}",
                f"{own['aic']:.1f}",
            )
    return table


def _terms(data: Mapping[str, Any]) -> RenderableType:
    table = framed("To be agreed between user and supplier", "term", "", words=("term",), fold=("",))
    for words, value in data["agreed"].items():
        table.add_row(words, Text(str(value), style="dim" if value == "not given" else ""))
    return table


def _range(bounds: Mapping[str, Any]) -> str:
    """Write two bounds; a missing upper one is unbounded."""
    return f"{cycles(bounds['low'] or 0.0)} to {'no bound' if bounds['high'] is None else cycles(bounds['high'])}"


def _bounds(bounds: Mapping[str, Any], form: str) -> str:
    return f"{form.format(bounds['low'])} to {'no bound' if bounds['high'] is None else form.format(bounds['high'])}"
