"""The report of a diagnosis as one page that needs nothing else, drawn from its dictionary and the panels of curves."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from etextile.units import load_text
from etextile.vocabulary import CHANNEL_LABELS
from viz.charts import data_address, track
from viz.diagnosis_plots import LOADS, Panel, panel_figure
from viz.fields_page import looks
from viz.html import environment, state_styles
from viz.live import as_data, library, script
from viz.style import STATES, drawing
from wires.axis import of_block
from wires.wording import probability


Data = Mapping[str, Any]
HEADLINES = {
    "no_gap": "No gap",
    "named": "Named",
    "ambiguous": "Ambiguous",
    "unexplained": "Unexplained",
}
TONES = {"no_gap": "good", "named": "good", "ambiguous": "withheld", "unexplained": "bad"}
ROWS = {
    "base": "Base",
    "re-tuned": "Base, fabric re-tuned within its coupons",
    "with effect": "With the effect",
    "floor": "Floor: free smooth curve",
}


def render_diagnosis_html(data: Data, *, panels: Sequence[Panel], runs: Sequence[Mapping[str, Any]] = ()) -> str:
    """Return the page; `data` as in diagnosis.json, `runs`: fields without and with the effect (`viz.fields_page`)."""
    names = [str(item["id"]) for item in data["effects"]]
    label = f"with {' and '.join(names)}" if names else ""
    charts = [{"caption": item.title, **_chart(item, label)} for item in panels]
    return (
        environment()
        .get_template("diagnosis.html.j2")
        .render(
            data=data,
            loads=LOADS,
            tone=TONES[data["verdict"]],
            headline=HEADLINES[data["verdict"]],
            states=state_styles(),
            tiles=_tiles(data),
            charts=charts,
            end=max((line["x"][-1] for chart in charts for line in chart["track"]["lines"]), default=0.0),
            live={"imports": json.dumps({"imports": library(three=False)}), "script": script("diagnosis")},
            fields=_fields(runs),
            axis=of_block(data["wires"]) if data["wires"] else None,
            facts_of=partial(_candidate, data),
            columns=_columns(data),
            gap_rows=_gap_rows(data),
            evidence=data["stages"]["detect"]["detected"],
            facts=_facts(data),
        )
    )


def _fields(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any] | None:
    """Return what the moving fields of the runs are made of, None without runs."""
    if not runs:
        return None
    states = [{"name": look.name, "colour": look.colour, "marker": look.marker} for look in STATES]
    return {"names": [run["name"] for run in runs], "data": as_data({"runs": runs, "states": states, **looks()})}


def _candidate(data: Data, row: Data) -> list[tuple[str, str]]:
    """Return what is told of a candidate when it is pointed at, as label and text."""
    exact = next((item for item in data["stages"]["rank"] if item["label"] == row["id"]), None)
    left = row["held_out_percent"]
    facts = [
        ("Effect", str(row["id"])),
        ("What speaks against it", row["rejected_because"] or ("nothing: it is named" if data["verdict"] == "named"
                                                               else "nothing decisive: it is possible")),
        ("Probability that it acts", probability(row["probability"])),
        ("That it acts and nothing else", "" if exact is None else probability(exact["probability_exactly"])),
        ("Held-out gap it leaves", "" if left is None else f"{left:.1f} %"),
    ]  # fmt: skip
    return [(label, text) for label, text in facts if text]


def _tiles(data: Data) -> list[dict[str, str]]:
    """Return the key figures: label, value, unit."""
    gap = next((item for item in data["gap"] if item["part"] == "held_out"), None) or next(iter(data["gap"]), None)
    place = data["where"][0] if data["where"] else None
    unit = data["load_unit"]
    tiles = []
    if gap is not None:
        arrow = f"{gap['before_percent']:.1f}"
        if data["effects"]:
            arrow += f" → {gap['after_percent']:.1f}"
        part = "held out" if gap["part"] == "held_out" else "all"
        tiles.append((f"Gap of the {CHANNEL_LABELS.get(gap['channel'], gap['channel'])}, {part}", arrow, "%"))
    onset = ("none", "") if place is None else (load_text(place[f"onset_{unit}"], unit), unit)
    tiles.append(("Onset of the gap", *onset))
    if data["effects"]:
        tiles.append(_sureness(data))
    else:
        tiles.append(("Chance that noise alone does this", f"{data['stages']['detect']['p_value']:.2g}", ""))
    tiles.append((f"Time, {data['simulations']} new simulator runs", f"{data['wall_s']:.0f}", "s"))
    return [{"label": label, "value": value, "unit": unit} for label, value, unit in tiles]


def _sureness(data: Data) -> tuple[str, str, str]:
    """Return the probability of what is named, or of the best of several, as a tile: the number of the sentence."""
    label = " + ".join(str(item["id"]) for item in data["effects"])
    found = next(item["probability"] for item in data["stages"]["finalists"] if item["label"] == label)
    what = "" if data["verdict"] == "named" else ", the best of several and no name"
    return f"Probability of {label}{what}", probability(found), ""


def _keys(data: Data) -> list[tuple[str, str]]:
    return list(dict.fromkeys((item["channel"], item["part"]) for item in data["rows"]))


def _columns(data: Data) -> list[dict[str, str]]:
    """Return the headings of the gap table."""
    return [
        {"channel": CHANNEL_LABELS.get(channel, channel).capitalize(), "part": part.replace("_", " ")}
        for channel, part in _keys(data)
    ]


def _gap_rows(data: Data) -> list[dict[str, Any]]:
    """Return the rows of the gap table as text."""
    rows = []
    for name, label in ROWS.items():
        found = {(item["channel"], item["part"]): item for item in data["rows"] if item["row"] == name}
        if found:
            cells = [_cell(found.get(key)) for key in _keys(data)]
            rows.append({"label": label, "cells": cells, "chosen": name == "with effect"})
    return rows


def _cell(item: Data | None) -> str:
    return "-" if item is None else f"{item['percent']:.1f} ({item['chi']:.1f})"


def _facts(data: Data) -> list[tuple[str, str]]:
    """Return the numbers of the stages as label and text."""
    stages = data["stages"]
    gate, detect, screen = stages["gate"], stages["detect"], stages["screen"]
    errors = ", ".join(f"{i['channel'].replace('_', ' ')} {i['percent']:.2f} %" for i in gate["lattice_error"])
    noise = ", ".join(
        f"{i['quantity'].replace('_', ' ')} {i['value']:.3g} {i['unit']}".strip() for i in stages["noise"]["instrument"]
    )
    scatter = stages["noise"]["scatter"]
    scores = ", ".join(f"{name} {score:+.1f}" for name, score in list(screen["scores"].items())[:6])
    facts = [
        ("0 Numerics gate", f"coarsening {_numbers(gate['coarsenings'])}; error that stays open: {errors}"),
        ("Instruments", noise),
        (
            "Specimens",
            f"gain {100 * scatter['gain']:.2f} %, datum shift {scatter['shift']:.3f} {data['load_unit']}, "
            f"drift {100 * scatter['drift']:.2f} %",
        ),
        ("Base parameters", "; ".join(f"{family}: {source}" for family, source in stages["base"].items())),
        (
            "1 Detect",
            f"largest |z| {detect['largest']:.1f}, noise alone passes {detect['critical']:.1f} in 5 % of tests "
            f"(p = {detect['p_value']:.2g})",
        ),
        ("2 Screen", f"signed scores {scores}" if scores else ""),
        ("Look alike", "; ".join(" = ".join(group) for group in screen["alike"])),
        ("Cannot be seen", ", ".join(screen["unseen"])),
    ]
    if detect["detected"]:
        ranked = ", ".join(f"{item['label']} {probability(item['probability_exactly'])}" for item in stages["rank"][:5])
        facts.append(("3, 4 Fit and rank", f"exactly these effects and nothing else: {ranked}"))
        facts += [(f"Finalist {item['label']}", _finalist(item)) for item in stages["finalists"]]
    return [(label, text) for label, text in facts if text]


def _finalist(item: Data) -> str:
    """Return what was found of a finalist."""
    parts = [
        f"without others {probability(item['probability_alone'])} (on the case's own lattice "
        f"{probability(item['probability_coarse'])})",
        f"chance of its rest {item['rest_p']:.2g}",
    ]
    if item["closed"] is not None:
        parts.append(f"{100 * item['closed']:.0f} % of the held-out gap closed")
    return ", ".join(parts) + (f"; against it: {'; '.join(item['objections'])}" if item["objections"] else "")


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.3g}" for value in values)


def _chart(panel: Panel, label: str) -> dict[str, Any]:
    """Return a panel as an SVG data address, the same panel gives the same bytes, and where the slider meets it."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    with drawing(), rc_context({"svg.fonttype": "path", "font.size": 9, "axes.labelsize": 9}):
        figure = panel_figure(panel, after_label=label)
        FigureCanvasSVG(figure)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None}, transparent=True)
        found = track(*figure.axes, unit=panel.load_unit)
    return {"source": data_address(buffer.getvalue(), "image/svg+xml"), "track": found}
