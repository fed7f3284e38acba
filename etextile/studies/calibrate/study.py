"""Calibrate: from a case, measurements and a list of free parameters to a fabric file that says what it knows.

The noise is what is stated, or what the residuals show. The run is repeated on a finer lattice, and what that shifts
the estimate by is part of its covariance. What the fit is worth is told by data it did not see: a specimen left out in
turn where there are several, the last third of the loads where there is one.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.diagnose.data.measured import Measurements
from etextile.errors import BadInput, NoEquilibrium
from etextile.files import write_whole
from etextile.identify.calibration import PosteriorEstimate
from etextile.identify.calibration import calibrate as search
from etextile.studies.calibrate.between import Between, between, between_data, foretold_row
from etextile.studies.calibrate.observed import (
    CHANNELS,
    UNITS,
    CaseModel,
    Models,
    Observed,
    observed_of,
    percent,
    sum_of_mean_absolute,
)  # fmt: skip
from etextile.studies.calibrate.parameters import Space, parse
from etextile.studies.cases import AnyCase
from etextile.studies.diagnose.question import AnyMeasured, question
from etextile.studies.diagnose.rounds import changed_case
from etextile.types import Array, BoolArray
from etextile.vocabulary import CYCLE
from loadcases.fabric import Covariance, Fabric, Family, dump_fabric, load_fabric
from loadcases.measured import Measured
from loadcases.reader import LoadedCase
from loadcases.schema import Case


FINER = 1.5
"""The coarsening over this is the lattice that the error is estimated on (it does not nest)."""
SEEN = 2.0 / 3.0
"""Share of the loads of a single specimen that predicts the rest."""
MOST_FOLDS = 6
TURNS, ENOUGH = 3, 3
"""Fits in turn with noise that the residuals of the last one show; specimens from which on each has its own."""
HEAD = "# Written by etextile calibrate"
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Calibration:
    """What calibrate leaves: the fabric, the files, and data as in the .json beside the fabric."""

    fabric: Fabric
    files: tuple[Path, ...]
    data: dict[str, Any]


def calibrate(
    case: AnyCase,
    measured: AnyMeasured,
    *,
    free: Sequence[str],
    output: str | Path,
    prior: bool = True,
    held_out: bool = True,
    finer: bool = True,
    force: bool = False,
    tell: Tell | None = None,
) -> Calibration:
    """Fit parameters of a case to a measurement; write the fabric file, its .json and a check plot (.png) beside it.

    `free`: keys such as `fabric.warp.H`, `effects.pretension.strain` (of an effect in the case), `measured.centre.x`;
    `prior` False: standard deviations that the fabric states do not count; `held_out`, `finer` False: leave out the
    prediction of unseen data, the finer lattice; `force`: overwrite a file that calibrate did not write. Raises
    BadInput with all that is wrong, NoEquilibrium when the case does not reach what was measured.
    """
    loaded, found = question(case, measured)
    path, say = _claimed(Path(output), force=force), tell or (lambda text: None)
    with loaded.locating():
        fabric = load_fabric(loaded.case.fabric.set)
        keys = parse(free, loaded.case, with_field=bool(found.displacement_field))
        model = _models(loaded, found)
        observed = model.observed
    space = Space(keys, loaded.case, fabric, found.centre, prior)
    begun = time.perf_counter()
    fit = _fit(space, model, np.ones(len(observed.value), dtype=bool), tell=say)
    shift, lattice = (np.zeros(len(keys)), []) if not finer else _lattice(space, model, fit)
    covariance = fit.estimate.covariance + np.outer(shift, shift)
    blind = _blind(space, model, fit, say) if held_out else []
    data = _data(space, observed, fit, covariance=covariance)
    scatter = between(space, model, fit.estimate.y, fit.noise, np.ones(len(observed.value), dtype=bool))
    data |= {
        "between_specimens": None if scatter is None else between_data(scatter),
        "case": {"title": loaded.case.title, "sha256": loaded.sha256},
        "measured": {"title": found.title, "channels": list(observed.present), "specimens": list(observed.names)},
        "held_out": blind,
        "lattice": lattice,
        "notes": [*observed.notes, *_notes(loaded.case, space, fit, observed)],
        "simulations": model.count,
        "wall_s": round(time.perf_counter() - begun, 1),
    }
    result = _fabric(space, fit, covariance, source=f"calibrated on {found.title} by the case {loaded.case.title}")
    files = (path, path.with_suffix(".json"), path.with_suffix(".png"))
    write_whole(path, f"{HEAD} on {found.title}\n{dump_fabric(result)}")
    write_whole(files[1], json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    _draw(files[2], loaded.case, observed, fit, data)
    return Calibration(result, files, data)


@dataclass(frozen=True)
class CalibrationFit:
    """An estimate, the noise (n,) it was found with, and the predicted readings (n,) at it."""

    estimate: PosteriorEstimate
    noise: Array
    predicted: Array


def _claimed(path: Path, *, force: bool) -> Path:
    """Return the path of the fabric file; raises BadInput for a file of somebody else."""
    if path.suffix not in (".yaml", ".yml"):
        raise BadInput.of(f"a fabric file ends with .yaml (got {str(path)!r})", key="--output")
    if path.exists() and not force and not path.read_text(encoding="utf-8").startswith(HEAD):
        raise BadInput.of("calibrate did not write this file, choose another or overwrite it (--force)", file=str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _models(loaded: LoadedCase, measured: Measurements) -> Models:
    """Return the tests of a folder with their cases: the one of the case itself, then those under `tests`."""
    parts = []
    if any(getattr(measured, name) for name in CHANNELS) or not measured.tests:
        parts.append(CaseModel(loaded.case, observed_of(loaded.case, measured)))
    for test in measured.tests:
        case = changed_case(loaded, test).case
        parts.append(CaseModel(case, observed_of(case, test.measured)))
    return Models(tuple(parts))


def _fit(space: Space, model: Models, mask: BoolArray, *, tell: Tell, start: Array | None = None) -> CalibrationFit:
    """Return the fit to a part of the readings; noise that is not stated is what the residuals show."""
    observed, unknowns = model.observed, space.unknowns()
    if start is not None:
        unknowns = replace(unknowns, start=start)
    noise = _noise(observed, None, mask)
    predict = model.residuals(space.change, mask)
    try:
        for _ in range(TURNS):
            estimate = search(predict, unknowns, observed.data(noise, mask), tell=tell)
            predicted = model.predict([space.change(estimate.y)])[0]
            if not np.any(np.isnan(observed.stated)):
                break
            noise = _noise(observed, predicted, mask)
            unknowns = replace(unknowns, start=estimate.y)
    except ValueError as error:
        reach = float(observed.load.max())
        message = (
            f"the case finds no equilibrium up to {reach:.4g} {space.case.motion.unit} with the fabric it starts from"
        )
        raise NoEquilibrium(message) from error
    return CalibrationFit(estimate, noise, predicted)


def _noise(observed: Observed, predicted: Array | None, mask: BoolArray) -> Array:
    """Return the noise (n,) of all readings: as stated, else 2 % of the channel at first, then what residuals show.

    Of three specimens or more each has its own, so that one unlike the others counts as the noisier one that it is;
    of two nothing tells which is the odd one.
    """
    noise = observed.stated.copy()
    fitted = np.unique(observed.specimen[mask])
    groups = [observed.specimen == number for number in fitted] if len(fitted) >= ENOUGH else [mask]
    for channel in observed.present:
        missing = observed.of(channel) & np.isnan(observed.stated)
        noise[missing] = 1.0
        for group in groups:
            own = missing & group & mask
            if own.any():
                left = 0.02 * observed.value[own] if predicted is None else (predicted - observed.value)[own]
                noise[own] = max(float(np.sqrt(np.mean(left**2))), 1e-9)
    return noise


def _lattice(space: Space, model: Models, fit: CalibrationFit) -> tuple[Array, list[dict[str, Any]]]:
    """Return by how much (p,) a finer lattice shifts the estimate, and the change of every channel."""
    observed = model.observed
    coarsening = max(model.case.fabric.coarsening / FINER, 1.0)
    finer = model.predict([space.change(fit.estimate.y)], finer=FINER)[0]
    change = finer - fit.predicted
    if not np.all(np.isfinite(change)):
        return np.zeros(len(fit.estimate.y)), []
    before = np.diag(1.0 / space.unknowns().spread ** 2)
    scaled = fit.estimate.jacobian
    shift = np.linalg.solve(
        scaled.T @ scaled + before, scaled.T @ (change / (fit.noise * max(fit.estimate.scale, 1.0)))
    )
    rows: list[dict[str, Any]] = [
        {"channel": name, "coarsening": coarsening, "change_percent": percent(change[own], observed.value[own])}
        for name in observed.present
        for own in [observed.of(name)]
    ]
    return np.asarray(shift), rows


def _blind(space: Space, model: Models, fit: CalibrationFit, tell: Tell) -> list[dict[str, Any]]:
    """Return the error on readings that a fit did not see."""
    observed, rows = model.observed, []
    for name, unseen in _folds(observed):
        tell(f"left out: {name}")
        try:
            other = _fit(space, model, ~unseen, tell=lambda text: None, start=fit.estimate.y)
        except NoEquilibrium:
            continue
        scatter = between(space, model, other.estimate.y, other.noise, ~unseen)
        for row in errors(observed, other.predicted, unseen):
            rows.append({"left_out": name, **row} | _foretold(scatter, row))
    return rows


def _foretold(scatter: Between | None, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the error that the scatter of the specimens that were fitted foretells of the one left out."""
    if scatter is None:
        return {}
    found = foretold_row(scatter, row["channel"])
    inside = found["low"] <= row[found["measure"]] <= found["high"]
    return {"foretold": {name: found[name] for name in ("low", "value", "high")} | {"inside": inside}}


def _folds(observed: Observed) -> Iterator[tuple[str, BoolArray]]:
    """Yield what is left out in turn: specimens, or the upper third of the loads of the only one."""
    if len(observed.names) > 1:
        for number, name in enumerate(observed.names[:MOST_FOLDS]):
            yield Path(name).name, observed.specimen == number
    elif len(np.unique(observed.load)) >= 6:
        limit = float(np.quantile(np.unique(observed.load), SEEN))
        yield f"above {limit:.4g}", observed.load > limit


def errors(observed: Observed, predicted: Array, mask: BoolArray) -> list[dict[str, Any]]:
    """Return the error of every channel over a mask: in per cent and, for fields, as mean |dx| + |dy| + |dz| in mm."""
    rows: list[dict[str, Any]] = []
    for name in observed.present:
        own = observed.of(name) & mask
        if not own.any():
            continue
        left = (predicted - observed.value)[own]
        row: dict[str, Any] = {
            "channel": name,
            "percent": percent(left, observed.value[own]),
            "points": int(own.sum()),
        }
        row[f"rms_{UNITS[name]}"] = float(np.sqrt(np.mean(left**2)))
        if name == "displacement_field":
            row["sum_of_mean_absolute_mm"] = sum_of_mean_absolute(left)
        rows.append(row)
    return rows


def _data(space: Space, observed: Observed, fit: CalibrationFit, *, covariance: Array) -> dict[str, Any]:
    """Return parameters with intervals, what is left open, and the errors by specimen."""
    estimate = fit.estimate
    return {
        "parameters": _rows(space, estimate, covariance),
        "open": [
            {"parameters": [space.free[i].key, space.free[j].key], "correlation": value}
            for i, j, value in estimate.pairs
        ],
        "converged": estimate.converged,
        "misfit_over_noise": estimate.scale,
        "gap": [
            {"specimen": Path(name).name, **row}
            for number, name in enumerate(observed.names)
            for row in errors(observed, fit.predicted, observed.specimen == number)
        ],
    }


def _rows(space: Space, estimate: PosteriorEstimate, covariance: Array) -> dict[str, dict[str, Any]]:
    """Return value, start, deviation and 95 % interval of every parameter; none where the data leave it open.

    Intervals of laws are symmetric in the logarithm.
    """
    from scipy.stats import t

    values, slope = space.values(estimate.y), space.derivatives(estimate.y)
    start = space.values(space.unknowns().start)
    own = np.sqrt(np.diag(slope @ covariance @ slope.T))
    reach = float(t.ppf(0.975, estimate.freedom))
    loose, rows = _open(space, estimate), {}
    for item, value, begun, std in zip(space.free, values, start, own, strict=True):
        wide = reach * std / value if item.kind == "law" else reach * std
        ends = [value * np.exp(sign * wide) if item.kind == "law" else value + sign * wide for sign in (-1.0, 1.0)]
        known = item.key not in loose
        spread = {"std": std, "low": ends[0], "high": ends[1]}
        rows[item.key] = {
            "value": float(value),
            "start": float(begun),
            **{name: float(number) if known else None for name, number in spread.items()},
            "identified": known,
        }
    return rows


def _open(space: Space, estimate: PosteriorEstimate) -> set[str]:
    """Return the keys that the data leave open: H too where the reference stress or n of its family is."""
    loose = {item.key for item, is_open in zip(space.free, estimate.open, strict=True) if is_open}
    keys = {item.key for item in space.free}
    return loose | {f"{key[:-1]}H" for key in loose if key.endswith(".n") and f"{key[:-1]}H" in keys}


def _notes(case: Case, space: Space, fit: CalibrationFit, observed: Observed) -> list[str]:
    """Return what a reader has to know."""
    notes = []
    if case.wires is not None:
        notes.append("wires are left out: what they carry is in the calibrated laws")
    stated = [item.key for item in space.free if item.kind == "law" and space.stated(item) is not None]
    if stated:
        notes.append(f"standard deviations that the fabric states count as known before: {', '.join(stated)}")
    if CYCLE not in observed.present and any(item.name == "E" for item in space.free if item.kind == "law"):
        notes.append("E acts in unloading; on a path that only loads it is known by what H and n leave of it")
    if not fit.estimate.converged:
        notes.append("the search did not come to rest, start nearer or free fewer parameters")
    return notes


def _fabric(space: Space, fit: CalibrationFit, covariance: Array, *, source: str) -> Fabric:
    """Return the fabric with the values found, their deviations and covariance by family."""
    y = fit.estimate.y
    values, slope = space.values(y), space.derivatives(y)
    own = slope @ covariance @ slope.T
    loose = _open(space, fit.estimate)
    fabric = space.fabric
    for name in dict.fromkeys(item.family for item in space.free if item.kind == "law"):
        chosen = [i for i, item in enumerate(space.free) if item.kind == "law" and item.family == name]
        known = [i for i in chosen if space.free[i].key not in loose]
        laws = {
            space.free[i].name: Measured(
                value=float(values[i]), std=float(np.sqrt(own[i, i])) if i in known else None, estimated=i not in known,
                source=None if i in known else "left open by the data",
            )
            for i in chosen
        }  # fmt: skip
        matrix = tuple(tuple(float(own[i, j]) for j in known) for i in known)
        kept = None
        if known:
            kept = Covariance.model_validate({"parameters": [space.free[i].name for i in known], "matrix": matrix})
        family: Family = getattr(fabric, name)
        update: dict[str, Any] = {**laws, "covariance": kept, "estimated": False, "source": source}
        fabric = fabric.model_copy(update={name: family.model_copy(update=update)})
    return fabric


def _draw(path: Path, case: Case, observed: Observed, fit: CalibrationFit, data: dict[str, Any]) -> None:
    from viz.calibration_plots import save_check

    save_check(
        path,
        title=f"{case.title}: {data['measured']['title']}",
        load_unit=case.motion.unit,
        readings=observed.readings(fit.predicted),
        specimens=[Path(name).stem for name in observed.names],
    )
