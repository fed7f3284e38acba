"""One sample of an ensemble: the task that worker processes run, from a row of unit numbers to a sample's file.

A sample depends on its task alone, not on what its worker did before. Runs that find no equilibrium are results too.
"""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.ensemble.store import BROKEN_OFF, DONE, Sample, write_sample
from etextile.errors import EtextileError
from etextile.results.wire_history import WireHistory
from etextile.solve.path import Increment, advance
from etextile.studies.ensemble.specimen import Nominal, SampledSpecimen, SampleTask, nominal, specimen_of
from etextile.studies.run.limits import Course, check_path
from etextile.studies.run.pressing import cut_at
from etextile.types import Array
from loadcases.build import Built, settings
from loadcases.nets import circuits_of, numbered_nets
from loadcases.schema import Case
from wires.damage import FailureResult
from wires.dependence import EventProbability
from wires.electrical import net_losses
from wires.strain import wire_strains


FINE = 100
"""Steps at least over which probabilities are kept."""
OVER_STEPS = ("displacement_mm", "span_strain", "wire_strain", "element_strain")


def run_sample(task: SampleTask) -> Sample:
    """Run one sample, keep it in the folder of the ensemble where that can be reached, and return it."""
    begun = time.perf_counter()
    now = nominal(task.case_text)
    specimen = specimen_of(now, task)
    increments, trouble = _run(specimen.built)
    sample = _judged(now, specimen, increments, trouble, task, time.perf_counter() - begun)
    if Path(task.folder).is_dir():
        write_sample(sample, Path(task.folder))
    return sample


def warm_up(case_text: str) -> None:
    """Compile what a run needs, so that workers find it in numba's cache on disk."""
    built = nominal(case_text).built
    with suppress(EtextileError):
        next(iter(advance(built.model, settings(built.case))), None)


def unknown_sample(task: SampleTask, reason: str) -> Sample:
    """Return a sample of which nothing is known: probabilities are NaN from the first step on."""
    now = nominal(task.case_text)
    sample = _judged(now, SampledSpecimen(now.built, 1.0, {}), [], reason or "unknown", task, 0.0)
    return replace(sample, max_strain=np.full_like(sample.max_strain, np.nan))


@dataclass(frozen=True)
class KeptIncrement:
    """What is kept of an increment: numbers for the trust limits, strains of the wires when it is an output."""

    output: bool
    displacement_mm: float
    force_N: float
    clamp_force_N: float
    penetration_mm: float
    softening: int
    work: float
    energy_gap: float
    cut_share: float
    strains: dict[str, Array]


def _run(built: Built) -> tuple[list[KeptIncrement], str]:
    """Return the increments of a run and why it broke off, if it did."""
    rows: list[KeptIncrement] = []
    try:
        rows.extend(_row(built, increment) for increment in advance(built.model, settings(built.case)))
    except EtextileError as error:
        return rows, str(error) or type(error).__name__
    return rows, ""


def _row(built: Built, increment: Increment) -> KeptIncrement:
    energy, lattice, followers = increment.energy, built.model.lattice, built.model.followers
    last = increment.displacement_mm == built.model.travel[-1]
    cells = lattice.trusses if followers is None else np.concatenate([lattice.trusses, followers.cells])
    return KeptIncrement(
        output=increment.output,
        displacement_mm=increment.displacement_mm,
        force_N=increment.punch_force_N,
        clamp_force_N=increment.clamp_force_N,
        penetration_mm=increment.max_penetration_mm,
        softening=increment.softening,
        work=energy.external,
        energy_gap=energy.gap,
        cut_share=cut_at(built, increment.displacement_mm, increment.positions, cells).share if last else 0.0,
        strains=wire_strains(built.wires, built.model, increment) if increment.output and built.wires else {},
    )


def _judged(
    now: Nominal, specimen: SampledSpecimen, rows: list[KeptIncrement], trouble: str, task: SampleTask, seconds: float
) -> Sample:
    """Return what the criterion says step by step."""
    travel = np.concatenate([[now.built.model.begins], now.built.model.travel])
    parts = max(1, -(-FINE // (len(travel) - 1)))
    outputs = [row for row in rows if row.output]
    history = _finer(_history(specimen.built, outputs, specimen.strength), parts)
    displacement = between(travel, parts)
    steps = len(displacement)
    worst = now.judge.judge(history)
    found = now.judge.over_steps(history)
    firsts = worst.first_failure_mm[np.isfinite(worst.first_failure_mm)]
    return Sample(
        key=task.key,
        number=task.number,
        status=BROKEN_OFF if trouble else DONE,
        reason=trouble,
        inputs=specimen.inputs,
        first_failure_mm=float(firsts.min()) if len(firsts) else None,
        limits=_limits(now.case, specimen.built, rows),
        seconds=seconds,
        displacement_mm=displacement,
        loop_failure=_padded(found.loop_failure, steps),
        loop_open=_padded(found.loop_open, steps),
        wire_failure=_padded(found.wire_failure, steps),
        wire_open=_padded(found.wire_open, steps),
        any_failure=_padded(found.any_failure, steps),
        any_open=_padded(found.any_open, steps),
        any_at_end=_any_at_end(worst),
        nets_at_end=_events(
            net_losses(history, worst, nets=numbered_nets(now.case), circuits=circuits_of(specimen.built.case))
        ),
        max_strain=worst.max_strain * specimen.strength,
        force_N=_padded(between(np.array([0.0, *(row.force_N for row in outputs)]), parts), steps),
    )


def _any_at_end(damage: FailureResult) -> Array:
    """Return that a wire loses a filament, and that one is interrupted (2, 3)."""
    known = damage.reliability
    if known is None:
        raise ValueError("a judgement is needed")
    return _events([known.garment("broken").anything, known.garment("opened").anything])


def _events(events: list[EventProbability]) -> Array:
    """Return value, low and high of events (n, 3)."""
    return np.array([[event.value, event.low, event.high] for event in events]).reshape(-1, 3)


def _history(built: Built, outputs: list[KeptIncrement], strength: float) -> WireHistory:
    """Return the strains of the wires from the flat fabric on, divided by the sampled strength."""
    wires = built.wires
    if wires is None:
        raise ValueError("a sample needs wires")
    layout = wires.layout
    sizes = {"span_strain": layout.n_loops, "wire_strain": layout.n_loops, "element_strain": wires.count}
    strains = {
        name: np.array([row.strains[name] for row in outputs]).reshape(len(outputs), size) / strength
        for name, size in sizes.items()
    }
    return wires.history(np.array([row.displacement_mm for row in outputs]), strains, begins=built.model.begins)


def between(values: Array, parts: int) -> Array:
    """Return values (S, ...) with `parts` - 1 more between neighbours, linear."""
    at = np.arange(parts * (len(values) - 1) + 1)
    low, weight = at // parts, (at % parts) / parts
    weight = weight.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray((1.0 - weight) * values[low] + weight * values[np.minimum(low + 1, len(values) - 1)])


def _finer(history: WireHistory, parts: int) -> WireHistory:
    """Return a history with more steps: probabilities rise far more steeply than the strains they come from."""
    changes: dict[str, Any] = {name: between(getattr(history, name), parts) for name in OVER_STEPS}
    return replace(history, **changes)


def _padded(values: Array, steps: int) -> Array:
    return np.concatenate([values, np.full((steps - len(values), *values.shape[1:]), np.nan)])


def _limits(case: Case, built: Built, rows: list[KeptIncrement]) -> tuple[str, ...]:
    """Return the names of the trust limits that a run exceeded; that it broke off is said elsewhere."""
    if not rows:
        return ()

    def over(name: str) -> Array:
        return np.array([getattr(row, name) for row in rows])

    path = Course(
        displacement_mm=over("displacement_mm"),
        force_N=over("force_N"),
        clamp_force_N=over("clamp_force_N"),
        penetration_mm=over("penetration_mm"),
        softening=np.array([row.softening for row in rows]),
        work=over("work"),
        energy_gap=over("energy_gap"),
        unconverged=0,
        cut_share=rows[-1].cut_share,
    )
    checks = check_path(path, built, case)
    return tuple(check.name for check in checks if not check.ok)
