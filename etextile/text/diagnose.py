"""Gap and diagnosis on a terminal, drawn from their dictionaries alone; readable at 80 columns and without colours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.box import ROUNDED
from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.panel import Panel
from rich.text import Text

from etextile.diagnose.decide.where import NAMES
from etextile.text.plain import as_text, framed
from etextile.units import load_text
from wires.axis import of_block
from wires.wording import probability


Data = Mapping[str, Any]
MOST_CANDIDATES = 8
ABREAST = 2
"""Channels side by side in the table of gaps."""
COUPONS = "the fabric's law against the loading curves as recorded"
GAP = (
    "gap: root mean square difference in per cent of that of the measured values\n (free edge: of its motion), up to "
    "the load given"
)
ACTS = "probability: that the effect acts, whatever acts beside it"
CHI = "standard deviations of noise, scatter,\n fabric parameters and lattice"
ROW_WORDS = {"base": "base", "re-tuned": "base, fabric re-tuned", "floor": "floor (free curve)"}
STYLES = {"no_gap": "green", "named": "green", "ambiguous": "yellow", "unexplained": "red"}
TITLES = {
    "no_gap": "Verdict: no gap",
    "named": "Verdict: named",
    "ambiguous": "Verdict: ambiguous",
    "unexplained": "Verdict: unexplained",
}


def compare_text(data: Data, *, folder: Path | None = None) -> str:
    """Return what compare found as text of 80 columns."""
    parts: list[RenderableType] = [_head(data)]
    if data["gap"]:
        agree, unit = data["agree"], data["load_unit"]
        words = "Simulation and measurement agree within noise." if agree else data["sentence"] + "."
        style = "green" if agree else "yellow"
        parts.append(Panel(Text(words), title="Gap", title_align="left", border_style=style, box=ROUNDED))
        table = framed("Gap per channel", "channel", "gap, %", "chi", "points", f"up to, {unit}", fold=("channel",))
        for row in data["gap"]:
            table.add_row(
                NAMES.get(row["channel"], row["channel"]), f"{row['percent']:.1f}", f"{row['chi']:.1f}",
                str(row["points"]), load_text(row[f"up_to_{unit}"], unit),
            )  # fmt: skip
        parts += [table, Text(f" {GAP};\n chi: root mean square difference in {CHI}", style="dim")]
        parts += [_indented(item["sentence"]) for item in data["where"]] if not agree else []
    if data["tensile"]:
        table = framed("Coupons", "direction", "gap, %", "specimens", "up to strain", fold=("direction",))
        for row in data["tensile"]:
            cells = (f"{row['percent']:.1f}", str(row["specimens"]), f"{row['up_to_strain']:.2f}")
            table.add_row(row["direction"], *cells)
        parts += [table, Text(f" {COUPONS},\n per cent of the measured stress", style="dim")]
    if data["wires"] is not None:
        parts.append(_observed(data["wires"]))
    parts += _notes(data, folder)
    return as_text(Group(*parts))


def _observed(wires: Data) -> RenderableType:
    """Observed wire states beside the predicted ones."""
    table = framed("Observed wires", "place", "observed", "predicted", "P(broken)", "outcome", fold=("place",))
    for item in wires["places"]:
        sure = probability(item["failure_probability"])
        table.add_row(item["name"], item["observed"], item["predicted"], sure, item["outcome"])
    counts = (
        f" {wires['hits']} hits, {wires['false_alarms']} false alarms, {wires['missed_breaks']} missed breaks; "
        f"{wires['same_state']} agree in state"
    )
    score = wires["broken"]
    brier = (
        f"\n Brier score {score['brier']:.3f} (always the observed share: {score['base_rate']:.3f})" if score else ""
    )
    left = [Text(f" left out: {sentence}", style="dim") for sentence in wires["left_out"]]
    return Group(table, Text(counts + brier, style="dim"), *left)


def diagnosis_text(data: Data, *, folder: Path | None = None, every: bool = False) -> str:
    """Return a diagnosis as text of 80 columns; `every`: with all candidates, not only the likeliest."""
    parts: list[RenderableType] = [_head(data), _verdict(data)]
    if data["effects"] or data["partial"]:
        parts.append(_parameters(data))
    parts.append(_gaps(data))
    if data["tensile"]:
        parts.append(_indented(f"coupons: {coupon_words(data['tensile'])}; {COUPONS}", style="dim"))
    if data["stages"]["detect"]["detected"]:
        parts.append(_why_not(data, most=len(data["candidates"]) if every else MOST_CANDIDATES))
    parts += [_round(item) for item in data.get("rounds", ())]
    if data["next_measurement"]:
        parts.append(_paragraph("Next measurement", data["next_measurement"]))
    if data.get("next") is not None:
        parts.append(_options(data["next"]))
    parts.append(_audit(data))
    if data["wires"] is not None:
        parts.append(_wires(data["wires"], measured_to=data["measured"][f"up_to_{data['load_unit']}"]))
    if data["observed"] is not None:
        parts += [_indented(line) for line in observed_words(data["observed"])]
    if data["command"]:
        parts.append(_paragraph("Use it", data["command"]))
    parts += _notes(data, folder)
    return as_text(Group(*parts))


def _verdict(data: Data) -> RenderableType:
    """The verdict, how far it goes and where the gap is, in a box."""
    lines = [Text(text) for text in (data["sentence"], data.get("evidence")) if text]
    if data["where"]:
        lines.append(Text(data["where_sentence"] + ".", style="dim"))
    kind = data["verdict"]
    return Panel(Group(*lines), title=TITLES[kind], title_align="left", border_style=STYLES[kind], box=ROUNDED)


def _parameters(data: Data) -> RenderableType:
    """The effects with their parameters and intervals."""
    effects = data["effects"] or data["partial"]
    best = "Effect" if data["verdict"] == "named" else "The best of several, not a name"
    title = best if data["effects"] else "Closest effect, not sufficient"
    table = framed(title, "effect", "parameter", "value", "95 % interval", "unit", fold=("effect", "parameter", "unit"))
    for effect in effects:
        name = effect["id"]
        for parameter, item in effect["parameters"].items():
            interval = "not searched" if item["fixed"] else f"{item['low']:.4g} .. {item['high']:.4g}"
            table.add_row(name, parameter, f"{item['value']:.4g}", interval, item["unit"])
            name = ""
    return table


def _gaps(data: Data) -> RenderableType:
    """Gap per prediction: fitted and held-out part of each channel, per cent and (chi)."""
    channels = list(dict.fromkeys(row["channel"] for row in data["rows"]))
    blocks = [channels[i : i + ABREAST] for i in range(0, len(channels), ABREAST)]
    unit = data["load_unit"]
    remark = f" held out: beyond {load_text(data[f'split_{unit}'], unit)} {unit}; chi in {CHI}"
    return Group(*(_gap_block(data["rows"], block) for block in blocks), Text(remark, style="dim"))


def _gap_block(rows: Sequence[Data], channels: Sequence[str]) -> RenderableType:
    """Gap of a few channels, which is what fits side by side."""
    keys = list(dict.fromkeys((row["channel"], row["part"]) for row in rows if row["channel"] in channels))
    names = [f"{NAMES.get(channel, channel)}\n{part.replace('_', ' ')}" for channel, part in keys]
    table = framed("Gap, % (chi)", "", *names, fold=("",))
    for row in dict.fromkeys(item["row"] for item in rows):
        found = {(item["channel"], item["part"]): item for item in rows if item["row"] == row}
        cells = [f"{found[key]['percent']:.1f} ({found[key]['chi']:.1f})" if key in found else "-" for key in keys]
        table.add_row(ROW_WORDS.get(row, row), *cells)
    return table


def _why_not(data: Data, *, most: int) -> RenderableType:
    """The likeliest candidates with what speaks against them."""
    table = framed(
        "Why not the others", "effect", "probability", "held-out\ngap, %", "against it", fold=("effect", "against")
    )
    fitting = "named" if data["verdict"] == "named" else "possible"
    for row in data["candidates"][:most]:
        left = "-" if row["held_out_percent"] is None else f"{row['held_out_percent']:.1f}"
        table.add_row(row["id"], probability(row["probability"]), left, row["rejected_because"] or fitting)
    rest = len(data["candidates"]) - most
    more = f"\n {rest} more in diagnosis.json and report.html" if rest > 0 else ""
    return Group(table, Text(f" {ACTS}{more}", style="dim"))


def _round(item: Data) -> RenderableType:
    """What a further test said of every explanation."""
    channels = " and ".join(name.replace("_", " ") for name in item["channels"])
    title = f"Further test: {item['test'].replace('_', ' ')} ({channels})"
    table = framed(title, "explanation", "before", "after", "chance of its rest", fold=("explanation",))
    for label, after in sorted(item["after"].items(), key=lambda pair: -pair[1]):
        table.add_row(label, probability(item["before"][label]), probability(after), f"{item['rest_p'][label]:.2g}")
    return Group(table, Text(" probability of exactly these effects", style="dim"))


def _options(plan: Data) -> RenderableType:
    """The measurements that could follow, the one that is asked for first."""
    table = framed(
        "Measurements that could follow", "measurement", "cost", "told, bits", "expected\nprobability",
        fold=("measurement",),
    )  # fmt: skip
    for item in plan["options"]:
        table.add_row(
            item["words"], f"{item['cost']:g}", f"{item['bits']:.2f}", probability(item["expected_probability"])
        )
    told = f" of the explanation that then leads; the folder {plan['folder']} is ready to be filled for the first"
    return Group(table, Text(told, style="dim"))


def _audit(data: Data) -> RenderableType:
    """Internal variables beyond the range they were identified in."""
    load = data["load_unit"]
    key = f"leaves_{load}"
    table = framed(
        "Validity audit", "variable", "identified to", f"leaves at, {load}", "at the end", fold=("variable",)
    )
    for row in data["audit"]:
        unit = f" {row['unit']}" if row["unit"] else ""
        limit = "-" if row["limit"] is None else f"{row['limit']:.3g}{unit}"
        leaves = "-" if row["limit"] is None else "never" if row[key] is None else load_text(row[key], load)
        table.add_row(row["variable"].replace("_", " "), limit, leaves, f"{row['at_end']:.3g}{unit}")
    return table


def _wires(wires: Data, *, measured_to: float) -> RenderableType:
    """What the effect changes in the verdicts of the wires; `measured_to` (mm) is where the measurement ends."""
    count = wires["changed"]
    words = "no wire changes its state" if not count else f"{count} of {len(wires['rows'])} wires change their state"
    axis = of_block(wires)
    title = Text(f"\n Wires at {wires[axis.key]:g} {axis.unit}: {words}", style="bold")
    beyond = wires[axis.key] > measured_to + 1e-6
    words = f" measured up to {measured_to:g} {axis.unit}: both states are extrapolated from there" if beyond else ""
    told = [_indented(f"without: {wires['before']}"), _indented(f"with: {wires['after']}")]
    return Group(title, *told, *([Text(words, style="dim")] if words else []))


def coupon_words(rows: Sequence[Data]) -> str:
    """Return how far the fabric's law is from its coupons."""
    words = "{direction} {percent:.1f} % up to strain {up_to_strain:.2f}"
    return ", ".join(words.format(**row) for row in rows)


def observed_words(observed: Data) -> list[str]:
    """Return how observed wire states agree with those without and with the effect, and which are left out."""
    told = [
        f"observed wires, {name} the effect: {found['hits']} of {len(found['places'])} places agree, "
        f"{found['false_alarms']} false alarms, {found['missed_breaks']} missed breaks"
        for name, found in observed.items()
    ]
    left = dict.fromkeys(sentence for found in observed.values() for sentence in found["left_out"])
    return [*told, *(f"left out: {sentence}" for sentence in left)]


def _paragraph(title: str, text: str) -> RenderableType:
    return Group(Text(f"\n {title}", style="bold"), _indented(text))


def _indented(text: str, *, style: str = "") -> RenderableType:
    return Padding(Text(text, style=style, overflow="fold"), (0, 0, 0, 1))


def _head(data: Data) -> RenderableType:
    """The case, the measurement, where the fabric's parameters come from, and what was kept out of the choice."""
    limits = [Text(f"restricted: {sentence}", style="yellow") for sentence in data.get("restrictions", ())]
    return Group(
        Text(data["case"]["title"], style="bold"),
        Text(f"measured: {data['measured']['title']}\nfabric: {data['fabric']}", style="dim"),
        *limits,
        Text(),
    )


def _notes(data: Data, folder: Path | None) -> list[RenderableType]:
    parts: list[RenderableType] = [Text(f"note: {note}", style="yellow") for note in data.get("notes", ())]
    if folder is not None:
        parts.append(Text(f"\nFiles in {folder}", overflow="fold"))
    return parts
