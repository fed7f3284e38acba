"""The gap of a case to heights and motions of points, specimen by specimen: how large, and of what simple kind.

Beside the errors it says what a shift of the coordinates would take away (cameras have their own origin) and how the
measured heights run against the computed ones: a factor is stiffness or thickness, an offset the datum or slack.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from etextile.diagnose.data.inflated import DisplacementField
from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.points import load_unit
from etextile.diagnose.data.surface import Surface, motions
from etextile.errors import NoEquilibrium
from etextile.studies.calibrate.observed import CaseModel, Observed, observed_of
from etextile.studies.calibrate.parameters import Change
from etextile.studies.calibrate.study import errors
from etextile.studies.diagnose.folder import Folder, claim_for, measured_files
from etextile.types import Array
from loadcases.fabric import load_fabric
from loadcases.reader import LoadedCase
from viz.calibration_plots import save_check
from viz.field_plots import DrawnField, save_fields


Wires = Callable[[LoadedCase, Measurements, Folder], dict[str, Any] | None]
FILES = ("compare.json", "compare.png", "field.png", "run")
MOST_SHIFT, TURNS = 15.0, 6


def is_surface(loaded: LoadedCase, measured: Measurements) -> bool:
    """Tell whether a comparison is one of surfaces under a load or of fields, not of a punch test's channels."""
    apart = ("pressure_height", "displacement_field", "joint_moment", "moment_curvature", "cyclic_force")
    return any(getattr(measured, name) for name in apart) or loaded.case.motion.unit != "mm"


def compare_surface(
    loaded: LoadedCase, measured: Measurements, folder: Path, *, force: bool = False, wires: Wires | None = None
) -> dict[str, Any]:
    """Compare, write compare.json and a picture into `folder`, and return the data; raises NoEquilibrium.

    `wires`: compares observed wire states, where there are any.
    """
    begun = time.perf_counter()
    with loaded.locating():
        observed = observed_of(loaded.case, measured)
        fabric = load_fabric(loaded.case.fabric.set)
    key = hashlib.sha256(loaded.sha256.encode())
    for file in sorted(set(measured_files(measured))):
        key.update(Path(file).read_bytes())
    place = claim_for(folder, key.hexdigest(), FILES, verb="compare", force=force)
    states = None if wires is None or measured.wires is None else wires(loaded, measured, place)
    model, change = CaseModel(loaded.case, observed), Change(fabric, {}, measured.centre)
    predicted = model.predict([change])[0]
    if not np.all(np.isfinite(predicted)):
        raise NoEquilibrium(f"the case finds no equilibrium up to {observed.load.max():.4g} {load_unit(measured)}")
    surface = model.surface(change) if measured.displacement_field else None
    data = {
        "case": {"title": loaded.case.title, "sha256": loaded.sha256},
        "measured": {"title": measured.title, "channels": list(observed.present)},
        "fabric": f"the case's own, {Path(loaded.case.fabric.set).stem}",
        "surface": True,
        "gap": list(_rows(observed, predicted)),
        "registration": [] if surface is None else list(_registrations(surface, measured)),
        **({} if states is None else {"wires": states}),
        "notes": list(observed.notes),
        "simulations": model.count,
        "wall_s": round(time.perf_counter() - begun, 1),
    }
    place.write("compare.json", json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    save_check(
        place.path / "compare.png",
        title=f"{loaded.case.title}: {measured.title}",
        load_unit=load_unit(measured),
        readings=observed.readings(predicted),
        specimens=[Path(name).stem for name in observed.names],
        computed="computed",
    )
    fields = [
        DrawnField(Path(item.file).stem, item.load, item.places - measured.centre, item.motion, motion)
        for item in measured.displacement_field
        if surface is not None
        for motion in [motions(surface, item, centre=measured.centre)]
    ]
    if fields:
        title = f"{loaded.case.title}: measured (dots) and computed (lines), and what is left at the last load"
        save_fields(place.path / "field.png", fields, title=title, load_unit=loaded.case.motion.unit)
    return data


def _rows(observed: Observed, predicted: Array) -> Iterator[dict[str, Any]]:
    """Yield the error of every specimen, and how its heights run against the computed ones."""
    for number, name in enumerate(observed.names):
        own = observed.specimen == number
        for row in errors(observed, predicted, own):
            chosen = own & observed.of(row["channel"])
            value, found, load = observed.value[chosen], predicted[chosen], observed.load[chosen]
            if row["channel"] == "displacement_field":
                value, found, load = value[2::3], found[2::3], load[2::3]
            line = np.stack([np.ones(len(found)), found], axis=1)
            offset, factor = np.linalg.lstsq(line, value, rcond=None)[0]
            first, last = load == load.min(), load == load.max()
            yield {
                "specimen": Path(name).name,
                **row,
                "measured_over_computed": {"offset": float(offset), "factor": float(factor)},
                "mean_difference": [float((value - found)[part].mean()) for part in (first, last)],
            }


def _registrations(surface: Surface, measured: Measurements) -> Iterator[dict[str, Any]]:
    """Yield for every field the centre that leaves least of it, and what it leaves."""
    for item in measured.displacement_field:
        centre = registered(surface, item, measured.centre)
        left = motions(surface, item, centre=centre) - item.motion
        yield {
            "specimen": Path(item.file).name,
            "centre_mm": list(centre),
            "sum_of_mean_absolute_mm": float(np.abs(left).sum(axis=1).mean()),
        }


def registered(surface: Surface, item: DisplacementField, start: tuple[float, float]) -> tuple[float, float]:
    """Return the centre of the piece in the coordinates of a field by least squares of its motion (Gauss-Newton)."""
    centre, step = np.array(start), 0.5

    def left(place: Array) -> Array:
        return (motions(surface, item, centre=(place[0], place[1])) - item.motion).ravel()

    for _ in range(TURNS):
        now = left(centre)
        slope = np.stack([(left(centre + step * row) - left(centre - step * row)) / (2 * step) for row in np.eye(2)], 1)
        move = np.linalg.lstsq(slope, -now, rcond=None)[0]
        centre = np.clip(centre + move, np.array(start) - MOST_SHIFT, np.array(start) + MOST_SHIFT)
        if np.abs(move).max() < 1e-3:
            break
    return (float(centre[0]), float(centre[1]))
