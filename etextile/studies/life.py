"""From lives of specimens to what may be promised: fits per area, B10 with bounds, P(life below the required one)."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from etextile.errors import BadInput
from etextile.files import write_whole
from etextile.life.curve import NEEDS, SurvivalCurve, survival
from etextile.life.events import EventRule, is_record, read_record
from etextile.life.fit import FAMILIES, WEIBULL, Bounded, LifeFit, fit
from etextile.life.lives import Lives, read_lives
from loadcases.agreement import Agreement, read_agreement, terms
from wires.report_files import plain


JSON, PICTURE = "life.json", "life.png"
FEW = 5
"""Fewer failures than this in an area are named as too few for a choice of the distribution."""
ALIKE = 2.0
"""Families whose Akaike criteria differ by less are not told apart."""


@dataclass(frozen=True)
class Study:
    """What was found: the data of life.json, lives, fits and curves by area, and the folder it was written to."""

    data: dict[str, Any]
    lives: dict[str, Lives]
    fits: dict[str, dict[str, LifeFit | str]]
    curves: dict[str, SurvivalCurve | str]
    folder: Path | None = None


def life(
    path: str | Path,
    folder: str | Path | None = None,
    *,
    required_cycles: float | None = None,
    confidence: float = 0.95,
    mode: str | None = None,
    rule: EventRule | None = None,
    agreed: str | Path | Agreement | None = None,
    force: bool = False,
) -> Study:
    """Fit lives of `path` per area; with `folder` write life.json and the probability plot life.png.

    path: CSV with specimen, cycles_low, cycles_high and, if any, area, event, mode (`etextile.life.lives`); or a record
    with specimen, cycle, resistance_ohm, which `rule` turns into lives. `required_cycles` (else that of `agreed`): what
    the product must last. `mode`: the failure mode to judge, others stop the watch. Raises BadInput.
    """
    path = Path(path)
    place = None if folder is None else Path(folder)
    if not 0.5 <= confidence < 1.0:
        raise BadInput.of(f"must be at least 0.5 and below 1 (got {confidence:g})", key="confidence")
    if place is not None:
        _check_folder(place, force=force)
    agreement = (
        agreed if isinstance(agreed, Agreement) else Agreement() if agreed is None else read_agreement(Path(agreed))
    )
    required = agreement.required_cycles if required_cycles is None else required_cycles
    if required is not None and not required > 0.0:
        raise BadInput.of(f"must be greater than 0 (got {required:g})", key="required_cycles")
    lives, remarks = _read(path, rule, mode)
    study = _study(lives, required, confidence)
    used = agreement.model_copy(update={"required_cycles": required, **_ruled(agreement, rule)})
    head = {
        "file": path.name,
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "confidence": confidence,
        "required_cycles": required,
        "mode": mode,
        "agreed": dict(terms(used)),
    }
    data = plain({**head, **study.data, "notes": [*remarks, *study.data["notes"]]})
    found = replace(study, data=data, folder=place)
    return found if place is None else _write(found, place)


def _read(path: Path, rule: EventRule | None, mode: str | None) -> tuple[Lives, tuple[str, ...]]:
    """Return the lives of a life file or of a record of resistances."""
    if not path.is_file():
        raise BadInput.of("no such file, give a CSV with specimen, cycles_low, cycles_high", file=str(path))
    if is_record(path):
        if rule is None:
            raise BadInput.of(
                "readings of resistance need an event rule, give a limit (--limit-ratio 2 or --limit-ohm 10)",
                file=str(path),
                key="resistance_ohm",
            )
        return read_record(path, rule)
    if rule is not None:
        message = "an event rule is for readings (specimen, cycle, resistance_ohm); this file holds lives"
        raise BadInput.of(message, file=str(path))
    lives = read_lives(path)
    if mode is None:
        return lives, ()
    known = sorted({name for name, failed in zip(lives.mode, lives.failed, strict=True) if failed and name})
    if mode not in known:
        message = f"no failure of mode {mode!r}, there are {', '.join(known) or 'no modes in the file'}"
        raise BadInput.of(message, file=str(path), key="mode")
    other = int((lives.failed & np.array([name != mode for name in lives.mode])).sum())
    if other and ((lives.low == 0.0) & lives.failed & np.array([name != mode for name in lives.mode])).any():
        message = f"a failure of another mode than {mode!r} before the first inspection tells nothing, leave it out"
        raise BadInput.of(message, file=str(path), key="mode")
    return lives.by_mode(mode), (
        f"{other} failures of other modes than {mode} count as lives that go on",
    ) if other else ()


def _ruled(agreement: Agreement, rule: EventRule | None) -> dict[str, Any]:
    """Return the terms that follow from the event rule, beside the words that were agreed upon."""
    if rule is None:
        return {}
    parameter = agreement.parameter or "electrical resistance, ohm"
    return {
        "event": rule.words() if agreement.event is None else f"{agreement.event} ({rule.words()})",
        "parameter": parameter,
    }


def _study(lives: Lives, required: float | None, confidence: float) -> Study:
    """Return fits and curves of every area, and of all together when there are several."""
    groups = {area: lives.of(area) for area in lives.areas}
    fits = {area: {name: fit(own, family) for name, family in FAMILIES.items()} for area, own in groups.items()}
    curves = {area: survival(own, confidence) for area, own in groups.items()}
    areas = [_area(area, groups[area], fits[area], curves[area], required, confidence) for area in groups]
    together = _together(lives, fits)
    rated = [row for row in areas if row["b10"] is not None]
    critical = min(rated, key=lambda row: row["b10"]["value"])["area"] if rated else None
    data = {"critical_area": critical, "areas": areas, "areas_differ": together, "notes": list(_notes(areas, curves))}
    return Study(data, groups, fits, curves)


def _area(
    area: str,
    lives: Lives,
    fits: Mapping[str, LifeFit | str],
    curve: SurvivalCurve | str,
    required: float | None,
    confidence: float,
) -> dict[str, Any]:
    """Return the entry of one area."""
    good = [found for found in fits.values() if isinstance(found, LifeFit)]
    best = _chosen(good)
    entries = {name: _fit(found, required, confidence) for name, found in fits.items()}
    chosen = None if best is None else entries[best.family.name]
    failed = lives.failed
    known = failed & (lives.low == lives.high)
    modes = Counter(name for name, own in zip(lives.mode, failed, strict=True) if own and name)
    return {
        "area": area,
        "specimens": len(lives),
        "failures": int(failed.sum()),
        "known": int(known.sum()),
        "between_inspections": int((failed & ~known).sum()),
        "going_on": int((~failed).sum()),
        "modes": dict(modes),
        "best": None if best is None else best.family.name,
        "told_apart": len(good) < len(FAMILIES) or abs(good[0].aic - good[1].aic) >= ALIKE,
        "b10": None if chosen is None else chosen["b10"],
        "p_below_required": None if chosen is None else chosen["p_below_required"],
        "fits": entries,
        "without_failures": None if failed.any() else _none_failed(lives, confidence),
        "curve": curve if isinstance(curve, str) else {**vars(curve)},
    }


def _chosen(good: Sequence[LifeFit]) -> LifeFit | None:
    """Return the Weibull fit unless another is clearly better: it promises less at the short lives that matter."""
    if not good:
        return None
    best = min(good, key=lambda found: found.aic)
    return next((found for found in good if found.family is WEIBULL and found.aic < best.aic + ALIKE), best)


def _fit(found: LifeFit | str, required: float | None, confidence: float) -> dict[str, Any]:
    """Return the entry of one fit, or why there is none."""
    if isinstance(found, str):
        return {"failed": found, "b10": None, "p_below_required": None}
    sigma = found.sigma_bounds(confidence)
    own: dict[str, Any] = {"sigma": vars(sigma), "median": vars(found.quantile_bounds(0.5, confidence))}
    if found.family is WEIBULL:
        own["shape"] = vars(Bounded(1.0 / sigma.value, 1.0 / sigma.high, 1.0 / sigma.low if sigma.low else np.inf))
        own["scale"] = vars(found.quantile_bounds(-np.expm1(-1.0), confidence))
    return {
        "failed": None,
        "mu": found.mu,
        **own,
        "b10": vars(found.quantile_bounds(0.1, confidence)),
        "p_below_required": None if required is None else vars(found.failed_bounds(required, confidence)),
        "log_likelihood": found.log_likelihood,
        "aic": found.aic,
    }


def _none_failed(lives: Lives, confidence: float) -> dict[str, float]:
    """Return what n specimens without a failure show: P(life below the shortest watch) <= 1 - (1 - C)^(1/n)."""
    return {"cycles": float(lives.low.min()), "p_below_high": 1.0 - (1.0 - confidence) ** (1.0 / len(lives))}


def _together(lives: Lives, fits: Mapping[str, Mapping[str, LifeFit | str]]) -> dict[str, Any] | None:
    """Return the likelihood-ratio test that all areas have one distribution, by the family that fits better.

    2 (sum of the areas' L - L of all together) is chi2 with 2 (areas - 1) degrees of freedom when they do. Areas of
    the same specimens are taken as independent.
    """
    if len(fits) < 2:
        return None
    tests = []
    for name, family in FAMILIES.items():
        own = [found[name] for found in fits.values()]
        pooled = fit(lives, family)
        if isinstance(pooled, LifeFit) and all(isinstance(found, LifeFit) for found in own):
            apart = sum(found.log_likelihood for found in own if isinstance(found, LifeFit))
            tests.append((apart, name, 2.0 * (apart - pooled.log_likelihood)))
    if not tests:
        return None
    _, name, ratio = max(tests)
    return {"family": name, "p_value": float(chi2.sf(max(ratio, 0.0), 2 * (len(fits) - 1))), "ratio": ratio}


def _notes(areas: list[dict[str, Any]], curves: Mapping[str, SurvivalCurve | str]) -> list[str]:
    """Return what the reader must know of the numbers."""
    notes = []
    for row in areas:
        if 0 < row["failures"] < FEW:
            notes.append(f"area {row['area']}: {row['failures']} failures do not tell which distribution holds")
        if row["failures"] and row["b10"] is None:
            reasons = "; ".join(f"{name}: {own['failed']}" for name, own in row["fits"].items())
            notes.append(f"area {row['area']}: no fit ({reasons})")
        if len(row["modes"]) > 1:
            modes = ", ".join(f"{count} {mode}" for mode, count in row["modes"].items())
            notes.append(f"area {row['area']}: failure modes are mixed ({modes}); judge one with --mode")
    if NEEDS in curves.values():
        notes.append(f"no curve without a distribution: {NEEDS}")
    return notes


def _check_folder(folder: Path, *, force: bool) -> None:
    """Raise BadInput when there is no writing into a folder."""
    if folder.exists() and not folder.is_dir():
        raise BadInput.of("is a file, give a folder", file=str(folder))
    if (folder / JSON).exists() and not force:
        raise BadInput.of("is there already; choose another output folder or give --force", file=str(folder / JSON))


def _write(found: Study, folder: Path) -> Study:
    """Write life.json and the picture."""
    from viz.life_plots import save_lives

    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(found.data, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    write_whole(folder / JSON, text)
    fits = {area: own[name] if (name := _best(found.data, area)) else None for area, own in found.fits.items()}
    save_lives(
        {area: own if isinstance(own, LifeFit) else None for area, own in fits.items()},
        found.curves,
        found.lives,
        required=found.data["required_cycles"],
        confidence=found.data["confidence"],
        path=folder / PICTURE,
    )
    return found


def _best(data: Mapping[str, Any], area: str) -> str | None:
    return next((row["best"] for row in data["areas"] if row["area"] == area), None)
