"""The result of an ensemble as plain data (`ensemble.json`) and as a table of its samples (`samples.csv`).

Nothing in them depends on how many workers ran it or how long it took.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.ensemble.statistics import Probability, bounds, crossing, mean_of, probability, rank_correlation
from etextile.ensemble.store import DONE, Sample
from etextile.files import write_table, write_whole
from etextile.studies.ensemble.ends import of_garment, of_nets
from etextile.types import Array, IntArray
from etextile.vocabulary import FABRIC_FAMILIES
from loadcases.judging import judge_for
from wires.chances import WHOLE_BELOW
from wires.layout import WireLayout
from wires.report_files import plain
from wires.trust import withheld
from wires.wording import chance


if TYPE_CHECKING:
    from etextile.studies.ensemble.plan import Ensemble

VERSION = 1
PACKAGES = ("etextile", "numpy", "scipy", "numba", "distributed")
LIMIT_SHARE = 0.05
"""Share of samples beyond a trust limit from which on the verdict is withheld and the exit code is 4."""
OUTPUTS = {
    "share_failed": "wires broken at the end",
    "first_failure_mm": "displacement of the first break",
}
"""What inputs are ranked by."""
COMBINED = {
    "punch_off_centre": ("body, distance off its place", ("punch_x", "punch_y")),
    "wire_shift": ("wires, distance of shift", ("wire_offset",)),
    "loop_shift": ("loops, distance of shift", ("loop_offset",)),
}
"""Inputs whose size may matter more than their sign."""


def report(ensemble: Ensemble, samples: Sequence[Sample], layout: WireLayout) -> dict[str, Any]:
    """Return everything about an ensemble in JSON types."""
    broken = [sample for sample in samples if sample.status != DONE]
    limits = Counter(name for sample in samples for name in sample.limits)
    curves = FragilityCurves.of(samples, layout)
    judge = judge_for(ensemble.case)
    unknown = of_garment(samples)
    data = {
        "ensemble_version": VERSION,
        "case": {"title": ensemble.case.title, "name": ensemble.name, "sha256": ensemble.key.sha256},
        "unit": ensemble.case.motion.unit,
        "failure": {
            "criterion": judge.criterion.name,
            "strain_kind": judge.strain_kind,
            "parameters": dict(judge.parameters),
        },
        "samples": len(samples),
        "failed_runs": len(broken),
        "seed": ensemble.key.seed,
        "method": ensemble.key.method,
        "specimen": {name: _last(curve) | unknown.get(name, {}) for name, curve in curves.specimen.items()}
        | {"wires": int(layout.wire_copies.sum()), "half_failed_mm": curves.halfway(curves.specimen["any_failure"])},
        "wires": [_wire(wire, curves, samples, layout) for wire in range(layout.n_wires)],
        "nets": of_nets(ensemble.case, samples),
        "fragility": {
            "displacement_mm": samples[0].displacement_mm,
            "travel_mm": curves.travel,
            **{name: _curve(curve) for name, curve in curves.specimen.items()},
            "wires": [_curve(part) for part in _columns(curves.wire_failure)],
            "loops": [_curve(part) for part in _columns(curves.loop_failure)],
        },
        "inputs": _inputs(ensemble),
        "ranking": ranking(ensemble, samples, curves),
        "failed": [{"sample": sample.number, "reason": sample.reason} for sample in broken],
        "trust": {"samples_over_limits": sum(bool(sample.limits) for sample in samples), "limits": dict(limits)},
        "notes": list(ensemble.notes),
        "versions": {name: metadata.version(name) for name in PACKAGES},
    }
    cleaned: dict[str, Any] = plain(data)
    return cleaned


@dataclass(frozen=True)
class FragilityCurves:
    """Probabilities over the steps with intervals: of wires (S, W), loops (S, L), specimen (S,); its bounds (N, S)."""

    travel: Array
    loop_failure: Probability
    loop_open: Probability
    wire_failure: Probability
    wire_open: Probability
    bounds: dict[str, tuple[Array, Array]]
    specimen: dict[str, Probability]

    @classmethod
    def of(cls, samples: Sequence[Sample], layout: WireLayout) -> FragilityCurves:
        """Return the curves of an ensemble."""
        names = ("loop_failure", "loop_open", "wire_failure", "wire_open")
        stacked = {name: np.stack([getattr(sample, name) for sample in samples]) for name in names}
        found = {name: probability(*bounds(values)) for name, values in stacked.items()}
        of_specimen = specimen_bounds(samples, layout.wire_copies)
        specimen = {name: probability(*pair) for name, pair in of_specimen.items()}
        return cls(
            travel=travel_of(samples[0].displacement_mm),
            loop_failure=found["loop_failure"],
            loop_open=found["loop_open"],
            wire_failure=found["wire_failure"],
            wire_open=found["wire_open"],
            bounds=of_specimen,
            specimen=specimen,
        )

    def halfway(self, curve: Probability) -> dict[str, float | None]:
        """Return the travel at which a curve (S,) reaches one half, with the interval from its bounds."""
        return {
            "value": crossing(self.travel, curve.value),
            "low": crossing(self.travel, curve.high),
            "high": crossing(self.travel, curve.low),
        }


def specimen_bounds(samples: Sequence[Sample], copies: IntArray) -> dict[str, tuple[Array, Array]]:
    """Return bounds (N, S) of what happens to the specimen: any wire as judged, and shares of its wires."""

    def stacked(name: str) -> Array:
        return np.stack([getattr(sample, name) for sample in samples])

    return {
        "any_failure": bounds(stacked("any_failure")),
        "any_open": bounds(stacked("any_open")),
        "share_failed": bounds(mean_of(stacked("wire_failure"), copies)),
        "share_open": bounds(mean_of(stacked("wire_open"), copies)),
    }


def travel_of(displacement: Array) -> Array:
    """Return the way (S,) of a motion that may go back and forth; what comes below 0, putting on, counts below 0."""
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(displacement)))]) + min(float(displacement[0]), 0.0)


def _wire(wire: int, curves: FragilityCurves, samples: Sequence[Sample], layout: WireLayout) -> dict[str, Any]:
    """Return one wire with its loops."""
    failure = _columns(curves.wire_failure)[wire]
    loops = np.flatnonzero(layout.loop_wire == wire)
    return {
        "wire": wire,
        "name": layout.names[wire],
        "weft_mm": layout.weft_mm[wire],
        "copies": layout.wire_copies[wire],
        **_flat(curves.wire_failure, wire, "failure_probability", ""),
        **_flat(curves.wire_open, wire, "open_probability", "open_"),
        "half_failed_mm": curves.halfway(failure),
        "loops": [_loop(int(loop), curves, samples, layout) for loop in loops],
    }


def _loop(loop: int, curves: FragilityCurves, samples: Sequence[Sample], layout: WireLayout) -> dict[str, Any]:
    """Return one loop; strains are those of the runs that ended."""
    strains = np.array([sample.max_strain[loop] for sample in samples if sample.status == DONE])
    return {
        "loop": layout.loop_index[loop],
        "warp_mm": layout.loop_warp_mm[loop],
        "copies": layout.loop_copies[loop],
        **_flat(curves.loop_failure, loop, "failure_probability", ""),
        **_flat(curves.loop_open, loop, "open_probability", "open_"),
        "max_strain_mean": strains.mean() if len(strains) else None,
        "max_strain_std": strains.std(ddof=1) if len(strains) > 1 else None,
    }


def _flat(curve: Probability, column: int, name: str, prefix: str) -> dict[str, float]:
    """Return the value at the end and its interval under the names of `ensemble.json`."""
    value, low, high = (part[-1, column] for part in (curve.value, curve.low, curve.high))
    return {name: value, f"{prefix}low": low, f"{prefix}high": high}


def _last(curve: Probability) -> dict[str, float]:
    return {"value": curve.value[-1], "low": curve.low[-1], "high": curve.high[-1]}


def _curve(curve: Probability) -> dict[str, Array]:
    return {"value": curve.value, "low": curve.low, "high": curve.high}


def _columns(curve: Probability) -> list[Probability]:
    """Return the curves (S,) of the columns of (S, W)."""
    return [Probability(curve.value[:, k], curve.low[:, k], curve.high[:, k]) for k in range(curve.value.shape[1])]


def _inputs(ensemble: Ensemble) -> list[dict[str, Any]]:
    """Return what scattered, how, and where the numbers come from."""
    plan = ensemble.plan
    rows: list[dict[str, Any]] = [
        {"name": f"{family}_level", "label": f"{family} law", "distribution": scatter.distribution, "origin": "fabric"}
        for family, scatter in plan.families.items()
    ]
    if plan.loop_slack > 0.0:
        words = f"normal loop by loop, standard deviation {100 * plan.loop_slack:g} % of the slack"
        rows.append({"name": "loop_slack", "label": "loop slack", "distribution": words, "origin": "estimated"})
    rows += [
        {"name": item.name, "label": item.label, "distribution": item.distribution, "origin": item.origin}
        for item in plan.inputs
    ]
    return rows


def ranking(ensemble: Ensemble, samples: Sequence[Sample], curves: FragilityCurves) -> list[dict[str, Any]]:
    """Return the rank correlation of every input with every output, strongest first, over the runs that ended."""
    done = [k for k, sample in enumerate(samples) if sample.status == DONE]
    outputs = {
        "share_failed": curves.bounds["share_failed"][0][done, -1],
        "first_failure_mm": np.array([_or_infinite(samples[k].first_failure_mm) for k in done]),
    }
    rows = []
    for name, label, values in _ranked([samples[k] for k in done], ensemble):
        for output, found in outputs.items():
            correlation = rank_correlation(values, found, seed=ensemble.key.seed)
            if correlation is not None:
                numbers = {"rank_correlation": correlation.value, "low": correlation.low, "high": correlation.high}
                rows.append(
                    {"output": output, "input": name, "label": label, **numbers, "matters": correlation.matters}
                )
    return sorted(rows, key=lambda row: (list(outputs).index(row["output"]), -abs(row["rank_correlation"])))


def _or_infinite(value: float | None) -> float:
    return np.inf if value is None else value


def _ranked(samples: Sequence[Sample], ensemble: Ensemble) -> Iterator[tuple[str, str, Array]]:
    """Yield name, label and values (N,) of what is ranked."""
    names = samples[0].inputs if samples else {}
    labels = {f"{family}_level": f"{family} stress level" for family in FABRIC_FAMILIES}
    labels |= {"loop_slack": "loop slack, mean"}
    labels |= {item.name: item.label for item in ensemble.plan.inputs}
    for name in names:
        yield name, labels[name], np.array([sample.inputs[name] for sample in samples])
    for name, (label, parts) in COMBINED.items():
        if all(part in names for part in parts):
            yield name, label, np.linalg.norm([[s.inputs[part] for part in parts] for s in samples], axis=1)


def conclude_verdict(data: dict[str, Any], passed: Sequence[str]) -> None:
    """Add the verdict, withheld in the words of a run where trust limits are passed; `passed`: without scatter.

    `survive` is true when the chance that a filament of any wire breaks is below `WHOLE_BELOW`, as in a run.
    """
    trust = data["trust"]
    trust["exceeded"] = [*passed, *_over(data)]
    instead = withheld(trust["exceeded"])
    whole = data["specimen"]["any_failure"]["value"] < WHOLE_BELOW
    data["verdict"] = {
        "withheld": bool(instead),
        "survive": None if instead or not data["wires"] else bool(whole),
        "sentence": instead or sentence(data),
    }


def _over(data: Mapping[str, Any]) -> list[str]:
    """Return the sentence about samples beyond a trust limit, where they are more than a few."""
    over, count = data["trust"]["samples_over_limits"], data["samples"]
    names = ", ".join(data["trust"]["limits"])
    return [f"{over} of {count} samples passed a trust limit ({names})"] if over > LIMIT_SHARE * count else []


def sentence(data: Mapping[str, Any]) -> str:
    """Say how likely some wire loses a filament, and which wire is the likeliest."""
    end, unit = data["fragility"]["displacement_mm"][-1], str(data["unit"]).replace("**", "")
    some = data["specimen"]["any_failure"]
    text = f"At {end:.4g} {unit} some wire has lost a filament with probability {_chance(some)}"
    worst = max(data["wires"], key=lambda wire: float(wire["failure_probability"]), default=None)
    if worst is None:
        return f"{text}."
    own = _chance({"value": worst["failure_probability"], "low": worst["low"], "high": worst["high"]})
    return f"{text}; the likeliest is wire {worst['name']}, {own}."


def _chance(values: Mapping[str, float]) -> str:
    return f"{chance(values['value'])} (95 %: {chance(values['low'])} to {chance(values['high'])})"


def write_report(data: Mapping[str, Any], path: Path) -> None:
    """Write `ensemble.json`."""
    write_whole(path, json.dumps(data, indent=1, allow_nan=False, ensure_ascii=False) + "\n")


def write_samples(data: Mapping[str, Any], samples: Sequence[Sample], layout: WireLayout, path: Path) -> None:
    """Write one row per sample: how it ended, what became of its wires, its inputs; empty where nothing is known."""
    inputs = [item["name"] for item in data["inputs"]]
    header = [
        "sample",
        "status",
        "first_failure_mm",
        "share_failed",
        "share_open",
        "max_strain",
        "force_end_N",
        *inputs,
    ]
    lines = []
    for sample in samples:
        shares = [
            mean_of(values[None], layout.wire_copies)[0, -1] for values in (sample.wire_failure, sample.wire_open)
        ]
        strain = float(np.max(sample.max_strain, initial=0.0))
        cells = [sample.first_failure_mm, *shares, strain, sample.force_N[-1], *map(sample.inputs.get, inputs)]
        lines.append([sample.number, sample.status, *map(_cell, cells)])
    write_table(path, [header, *lines])


def _cell(value: float | None) -> str:
    return "" if value is None or not np.isfinite(value) else f"{value:.7g}"
