"""What the report says of nets and of life under repeated loading, on a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import RenderableType
from rich.text import Text

from etextile.text.plain import framed
from wires.axis import axis_of
from wires.life import by_life
from wires.trust import as_provisional
from wires.wording import cycles, number, probability


Report = Mapping[str, Any]

MOST = 6
"""Rows in the tables of nets and of loops by life."""


def wear_parts(report: Report) -> Iterator[RenderableType]:
    """Yield tables and lines about nets and life; none where there is nothing of them."""
    if report.get("nets"):
        yield _nets(report)
    life = report.get("life")
    if life is not None and life["critical_loop"] is not None:
        yield _loops(report)
        for line in life_lines(life):
            yield Text(f" {line}", style="dim")


def life_lines(life: Mapping[str, Any]) -> Iterator[str]:
    """Yield where the numbers of the block come from, and what has to be agreed on."""
    law = life["law"]
    many = "" if life["cycles_in_path"] == 1.0 else f" ({life['cycles_in_path']:g} cycles)"
    yield f"counted on {life['counted_on']}{many}, by rainflow (ASTM E1049)"
    if law is not None:
        words = (
            f"Coffin-Manson, coefficient {law['coefficient']:g}, exponent {law['exponent']:g}"
            if law["law"] == "coffin_manson"
            else f"table of {len(law['cycles'])} points"
        )
        scatter = life["scatter"]
        yield f"law: {words} ({law['source']}); Miner's sum"
        yield f"scatter of ln(life): {scatter['log_std']:g} ({scatter['origin']})"
    yield f"assumed: {life['assumed']}"
    given = [f"{name} {value}" for name, value in life["terms"].items() if value != "not given"]
    missing = [name for name, value in life["terms"].items() if value == "not given"]
    if given:
        yield f"agreed: {'; '.join(given)}"
    if missing:
        yield f"to be agreed between user and supplier: {', '.join(missing)}"


def _loops(report: Report) -> RenderableType:
    columns = ("wire\n", "loop\n", "warp\nmm", "weft\nmm", "strain\nrange", "strain\nmean", "first\nplastic")
    table = framed("Loops by life", *columns, "cycles\nto failure")
    for loop in by_life(report["wires"], MOST):
        life = loop["cycles_to_failure"]
        table.add_row(
            str(loop["name"]),
            str(loop["loop"]),
            f"{loop['warp_mm']:.1f}",
            f"{loop['weft_mm']:.1f}",
            *(f"{loop[name]:.4f}" for name in ("strain_range", "strain_mean", "first_plastic_strain")),
            "-" if life is None else cycles(life),
        )
    return table


def _nets(report: Report) -> RenderableType:
    nets = sorted(report["nets"], key=lambda net: -net["loss_probability"])
    table = framed(
        as_provisional(f"Nets ({min(MOST, len(nets))} of {len(nets)})", passed=report["verdict"]["withheld"]),
        "net\n",
        "state\n",
        f"lost at\n{axis_of(report).unit}",
        "P\nlost",
        "R/R0\n",
        fold=("net", "state"),
    )
    for net in nets[:MOST]:
        table.add_row(
            str(net["name"]),
            str(net["state"]),
            number(net["lost_at_mm"], "{:.1f}"),
            probability(net["loss_probability"]),
            number(net["resistance_ratio"], "{:.3f}"),
        )
    return table
