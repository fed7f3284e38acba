"""The pictures of an ensemble, drawn from `ensemble.json` and the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from etextile.files import write_whole
from etextile.results.reader import open_results
from etextile.studies.ensemble.plan import PLAIN
from etextile.studies.ensemble.report import OUTPUTS
from etextile.studies.run.drawing import scenes_at
from etextile.types import Array
from loadcases.build import Built
from viz.ensemble_html import EVENTS as WORDS
from viz.ensemble_html import EnsembleView, render_comparison_html, render_ensemble_html
from viz.ensemble_plots import Bar, fragility, probability_map, ranking, specimen_scene, wire_fragility
from viz.legend import titled
from viz.live import chosen_steps
from viz.plots import Curve, line_plot
from viz.scene import Scene


EVENTS = {
    "": ("failure_probability", "at least one filament\nis broken", "probability.png"),
    "open_": ("open_probability", "all filaments\nare broken", "probability_open.png"),
}
MOST_BARS = 10
PAGE, COMPARISON = "ensemble.html", "compare.html"


def draw(data: Mapping[str, Any], built: Built, folder: Path) -> tuple[Path, ...]:
    """Draw everything about an ensemble into `folder` and return the paths."""
    title, held = data["case"]["title"], data["verdict"]["withheld"]
    curves = data["fragility"]
    x, x_label = axis(curves, str(data.get("unit", "mm")))
    of_specimen = [
        curve(x, curves[name], f"share of {words}" if name.startswith("share") else words)
        for name, words in WORDS.items()
    ]
    drawn = [
        fragility(
            of_specimen,
            folder / "fragility.png",
            x_label=x_label,
            title=titled("Fragility of the specimen", title, provisional=held),
        )
    ]
    if curves["wires"]:
        values = np.array([wire["value"] for wire in curves["wires"]]).T
        places = np.array([wire["weft_mm"] for wire in data["wires"]])
        drawn.append(
            wire_fragility(
                x,
                places,
                values,
                folder / "fragility_wires.png",
                x_label=x_label,
                title=titled("Fragility of the wires", title, provisional=held),
                names=[wire["name"] for wire in data["wires"]],
            )
        )
    if data["ranking"]:
        drawn.append(ranking(_bars(data), folder / "ranking.png", title=title, provisional=held))
    shown = chances(data, built, folder)
    if shown is not None:
        drawn += _maps(data, shown.specimen, folder)
        text = render_ensemble_html(shown, curves=of_specimen, x_label=x_label, maps=drawn)
        write_whole(folder / PAGE, text)
        drawn.append(folder / PAGE)
    return tuple(drawn)


def chances(data: Mapping[str, Any], built: Built, folder: Path, name: str = "") -> EnsembleView | None:
    """Return what a page shows of an ensemble: specimen as modelled, run without scatter; None without wires."""
    if built.wires is None or not data["wires"]:
        return None
    clamped = np.asarray(built.model.fixed[: len(built.model.lattice.points)].all(axis=1))
    specimen = specimen_scene(built.model.lattice, built.wires.layout, clamped, portion=built.case.fabric.portion)
    results = open_results(folder / PLAIN)
    if not results.steps:
        return EnsembleView(data, specimen, name)
    steps = chosen_steps(len(specimen.quads), results.steps)
    fields = scenes_at(results, steps, damage=None, title="")
    way = np.abs(np.diff([built.model.begins, *results.displacement_mm])).cumsum()
    return EnsembleView(data, specimen, name, fields, way[steps].tolist())


def axis(curves: Mapping[str, Any], unit: str) -> tuple[Array, str]:
    """Return displacements (S,) with the axis label, or the way there and back when the motion turns round."""
    what = "flexion [deg]" if unit == "deg" else f"displacement [{unit}]"
    displacement, travel = np.array(curves["displacement_mm"]), np.array(curves["travel_mm"])
    if np.allclose(displacement, travel):
        return displacement, what
    return travel, f"way of the motion, there and back [{unit}]"


def curve(x: Array, values: Mapping[str, Any], label: str) -> Curve:
    """Return a curve with its 95 % band."""
    return Curve(x, np.array(values["value"]), label, np.column_stack([values["low"], values["high"]]))


def _bars(data: Mapping[str, Any]) -> list[tuple[str, list[Bar]]]:
    """Return the strongest inputs of each output."""
    panels = []
    for output, words in OUTPUTS.items():
        rows = [row for row in data["ranking"] if row["output"] == output][:MOST_BARS]
        if rows:
            bars = [Bar(row["label"], row["rank_correlation"], row["low"], row["high"]) for row in rows]
            panels.append((words, bars))
    return panels


def _maps(data: Mapping[str, Any], scene: Scene, folder: Path) -> list[Path]:
    """Draw the probability maps."""
    drawn = []
    for prefix, (name, what, file) in EVENTS.items():
        rows = [loop for wire in data["wires"] for loop in wire["loops"]]
        values = np.array([row[name] for row in rows])
        width = max((row[f"{prefix}high"] - row[f"{prefix}low"] for row in rows), default=0.0)
        remark = (
            f"At {data['fragility']['displacement_mm'][-1]:.4g} {data.get('unit', 'mm')}.  {data['samples']} samples"
            + (f", {data['failed_runs']} without equilibrium" if data["failed_runs"] else "")
            + f".  Widest 95 % interval of a loop {width:.2f}."
        )
        wires = np.array([wire[name] for wire in data["wires"]])
        drawn.append(probability_map(scene, values, wires, folder / file, what=what, remark=remark,
                                     title=data["case"]["title"], provisional=data["verdict"]["withheld"]))  # fmt: skip
    return drawn


def draw_comparison(
    data: Mapping[str, Any], folder: Path, *, designs: Sequence[EnsembleView | None]
) -> tuple[Path, ...]:
    """Draw the difference of two designs over displacement, B less A, with 95 % bands, and both side by side on a page.

    Designs without wires have no page.
    """
    curves = data["over_displacement"]
    shown = [item for item in designs if item is not None]
    x = np.array(curves["travel_mm"])
    names = {"share_failed": WORDS["share_failed"], "share_open": WORDS["share_open"]}
    differences = [curve(x, curves[name], words) for name, words in names.items()]
    path = line_plot(
        differences,
        folder / "difference.png",
        x_label="displacement [mm]",
        y_label="share of the wires, B less A (below 0: B is better)",
        title=titled("Difference of the designs, B less A", "", provisional=data["verdict"]["withheld"]),
    )
    if len(shown) < len(designs):
        return (path,)
    own = [(item, axis(item.data["fragility"], str(item.data.get("unit", "mm")))) for item in shown]
    page = render_comparison_html(
        data,
        shown,
        curves=differences,
        fragility=[curve(places, item.data["fragility"]["share_failed"], item.name) for item, (places, _) in own],
        x_label=own[0][1][1],
        maps={item.name: folder / item.name / EVENTS[""][2] for item in shown},
    )
    write_whole(folder / COMPARISON, page)
    return path, folder / COMPARISON
