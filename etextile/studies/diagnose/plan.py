"""The plan of the next measurement: every one of the catalogue foretold by every explanation that is left.

For planning the case's own lattice is enough: what differs is the explanations, not the lattice. What the fabric leaves
open in a force is carried over from the first test in proportion.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.measured import MeasuredTest, Measurements
from etextile.diagnose.data.noise import NoiseScatter, SignalShape, covariance
from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.data.points import Points, gather
from etextile.diagnose.data.punched import PunchForce
from etextile.diagnose.decide.foretell import Explanation, Foretold
from etextile.diagnose.decide.plan import ENOUGH, Gain, Repeats, gain, repeats
from etextile.diagnose.decide.verdict import Answer
from etextile.diagnose.infer.fit import FORM
from etextile.diagnose.infer.free import form_modes
from etextile.diagnose.infer.lattice_doubt import facing
from etextile.diagnose.infer.whitened import motion
from etextile.diagnose.predict.run_tables import Levels, freedom
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.predict.table import superposed
from etextile.diagnose.workflow import Diagnosis
from etextile.studies.diagnose.catalogue import DOWN_TO, UNLOADING, CatalogueTest, catalogue
from etextile.studies.diagnose.ordinary import imagined
from etextile.studies.diagnose.rounds import changed_case, followed
from etextile.studies.diagnose.setting import DiagnosisTask, simulator_of
from etextile.types import Array
from etextile.vocabulary import FORCE
from loadcases.reader import LoadedCase


FLOOR = 0.05
"""Least probability of an explanation in the plan: one that is possible is to be told apart, not to be forgotten."""
TELLING = 0.05
"""Bits below which a measurement is not worth to be asked for."""
READINGS, LEAST = 24, 0.5
"""Readings of a force that is foretold; share of the travel that all explanations have to reach."""
NUMERICS = 0.005
"""What the lattice leaves open in a prediction, as a share of the motion or force."""


@dataclass(frozen=True)
class Option:
    """A measurement with what it is expected to tell, and what every explanation says of it."""

    trial: CatalogueTest
    gain: Gain
    points: Points
    foretold: tuple[Foretold, ...]

    @property
    def decides(self) -> bool:
        """Whether it is likely to decide: odds of 1000 for one explanation against every other."""
        return bool(self.gain.decisive >= ENOUGH)


@dataclass(frozen=True)
class MeasurementPlan:
    """All options, the one to take first; `repeats`: how many specimens of the first test would do instead."""

    options: tuple[Option, ...]
    repeats: Repeats | None

    @property
    def best(self) -> Option | None:
        """The measurement to make: the cheapest that decides, else the one that tells most for its cost.

        None when the best of them tells next to nothing.
        """
        return self.options[0] if self.options and self.options[0].gain.bits >= TELLING else None


def plan(task: DiagnosisTask, diagnosis: Diagnosis, runner: Runner) -> MeasurementPlan:
    """Return the plan for what is left; empty where there is nothing to be told apart.

    The catalogue is one of punch tests: after another test the words of `next_measurement` stand.
    """
    punched = task.loaded.case.body is not None and not task.loaded.case.worn
    items = followed(diagnosis) if diagnosis.verdict.kind is Answer.AMBIGUOUS and punched else ()
    items = tuple(item for item in items if not set(items[0].ids) < set(item.ids)) if items else ()
    if len(items) < 2:
        return MeasurementPlan((), None)
    ids = sorted({name for item in items for name in item.ids})
    found = [_option(task, diagnosis, trial, items, runner) for trial in catalogue(task.loaded.case, diagnosis, ids)]
    options = sorted((item for item in found if item is not None), key=_order)
    return MeasurementPlan(tuple(options), _repeats(diagnosis, items))


def _order(item: Option) -> tuple[bool, float, float]:
    """Return what options are sorted by: those that decide by cost, others by bits per cost."""
    cost = item.trial.cost
    return (not item.decides, cost if item.decides else 0.0, -item.gain.bits / cost)


def _option(
    task: DiagnosisTask, diagnosis: Diagnosis, trial: CatalogueTest, items: Sequence[Explanation], runner: Runner
) -> Option | None:  # fmt: skip
    """Return a measurement as all explanations foretell it; None where the case or a run does not go there."""
    laws, total = diagnosis.setting.base.laws, diagnosis.levels.total
    case = task.loaded
    if trial.case:
        case = changed_case(task.loaded, MeasuredTest(trial.id, trial.case, Measurements("", "")))
    back = DOWN_TO * total if trial.back else None
    levels = Levels.of(float(case.case.fabric.coarsening), total, back=back)
    specs = [item.requests(trial.without) for item in items]
    wanted = [levels.request(laws), *(levels.request(laws, one) for group in specs for one in group)]
    with _runner(task, case, runner) if trial.case else nullcontext(runner) as own:
        base, *runs = own(wanted)
    if trial.back and not all(record.completed for record in (base, *runs)):
        return None
    reach = min(total, *(record.reach for record in (base, *runs)))
    if reach < LEAST * total:
        return None
    points = imagined_points(trial, diagnosis, base, reach=reach)
    common = _common(diagnosis, points, base, trial)
    found, start = [], 0
    shares = np.maximum([item.probability for item in items], FLOOR * max(item.probability for item in items))
    for item, group, share in zip(items, specs, shares / shares.sum(), strict=True):
        central, *moved = (observe(run, points) for run in runs[start : start + len(group)])
        start += len(group)
        change = central - observe(base, points)
        columns = [other - central for other in moved]
        spread = np.stack(columns or [np.zeros_like(central)], axis=1)
        factors = FORM * form_modes(points) * change[:, None]
        found.append(Foretold(item.label, float(share), central, common + spread @ spread.T + factors @ factors.T))
    if not all(np.all(np.isfinite(item.mean)) and np.all(np.isfinite(item.covariance)) for item in found):
        return None
    return Option(trial, gain(found, seed=diagnosis.setting.seed), points, tuple(found))


@contextmanager
def _runner(task: DiagnosisTask, case: LoadedCase, runner: Runner) -> Iterator[Runner]:
    """Yield a runner of another case that shares cache and workers' number; its runs are counted with the first's."""
    simulator = simulator_of(case.case, task.setting.candidates)
    with closing(Runner(simulator, runner.folder, workers=runner.workers, watch=runner.watch)) as own:
        yield own
        runner.count += own.count


def imagined_points(trial: CatalogueTest, diagnosis: Diagnosis, base: Record, *, reach: float) -> Points:
    """Return the points of a measurement that is yet to be made, valued by the base."""
    if trial.channel not in (FORCE, UNLOADING):
        return imagined(base, reach)[trial.channel]
    low = float(base.displacement[0]) if trial.back else 0.0
    travel = np.linspace(low, reach, READINGS + 1)[1:]
    # a curve that rises is not cut, whatever its values
    curves = tuple(PunchForce(name, travel, travel) for name in files_of(trial, diagnosis))
    return gather(Measurements("", "", punch_force=curves))


def files_of(trial: CatalogueTest, diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return the files to be filled: one per specimen of the first test for forces, one for a field."""
    if trial.channel not in (FORCE, UNLOADING):
        return (f"{trial.id}.csv",)
    count = sum(item.channel == FORCE for item in diagnosis.points.series) or 1
    return tuple(f"{trial.id}_{number}.csv" for number in range(1, count + 1))


def noise_of(trial: CatalogueTest, diagnosis: Diagnosis) -> float:
    """Return the standard deviation of a reading: the trial's own, for forces that of the first test."""
    if trial.noise is not None:
        return trial.noise
    own = diagnosis.bench.raw.of(FORCE)
    if own.any():
        return float(np.sqrt(np.mean(diagnosis.bench.white_raw[own] ** 2)))
    return NUMERICS * float(np.abs(diagnosis.base_runs.coarse.force).max())


def _common(diagnosis: Diagnosis, points: Points, base: Record, trial: CatalogueTest) -> Array:
    """Return the covariance (n, n) of a measurement that all explanations share: noise, scatter, fabric, numerics."""
    value = observe(base, points)
    slope = np.gradient(base.force, base.displacement)
    slopes = np.where(points.of(FORCE), np.interp(points.displacement, base.displacement, slope), 0.0)
    scatters = diagnosis.bench.scatters
    sizes = np.array([[item.scatter.gain, item.scatter.shift, item.scatter.drift] for item in scatters])
    weights = np.array([item.weight for item in scatters])
    own, shift, drift = np.sqrt(weights @ sizes**2 / weights.sum()).tolist()
    moved = motion(base, points, value)
    white = np.full(len(points), noise_of(trial, diagnosis))
    found = covariance(points, white, SignalShape(value, slopes, moved), NoiseScatter(own, shift, drift))
    columns = _fabric(diagnosis, points, value)
    return np.asarray(found + columns @ columns.T + np.diag((NUMERICS * np.abs(moved)) ** 2))


def _fabric(diagnosis: Diagnosis, points: Points, value: Array) -> Array:
    """Return columns (n, 9) of what the fabric's parameters leave open, from the slopes of the first test.

    Fields of the same test as they are, forces in proportion: another punch changes by the same share.
    """
    setting = diagnosis.setting
    records = [diagnosis.base_runs.anchor, *diagnosis.slope_runs]
    at_anchor, *moved = (observe(record, points) for record in records)
    columns = freedom(setting.base, at_anchor, moved)
    force = points.of(FORCE)
    ratio = np.where(force & (np.abs(at_anchor) > 0.0), value / np.where(at_anchor == 0.0, 1.0, at_anchor), 1.0)
    return np.asarray(np.nan_to_num(columns) * ratio[:, None])


def _repeats(diagnosis: Diagnosis, items: Sequence[Explanation]) -> Repeats | None:
    """Return how many specimens of the first test would tell the best two apart; None without force curves."""
    bench, points = diagnosis.bench, diagnosis.bench.points
    force = [i for i, item in enumerate(points.series) if item.channel == FORCE]
    if not force:
        return None
    kept = ~points.of(FORCE) | (points.owner == force[0])
    curves = [
        superposed([diagnosis.tables[name] for name in item.ids], item.contender.evidence.best) for item in items[:2]
    ]
    form = FORM * form_modes(points) * curves[0][:, None]
    tables = [diagnosis.tables[name] for name in dict.fromkeys((*items[0].ids, *items[1].ids))]
    whole = facing(bench, tables).mean_covariance + form @ form.T
    noise = sum(item.weight * covariance(points, bench.white, bench.shape, item.scatter) for item in bench.scatters)
    own = points.of(FORCE)
    single = np.where(own[:, None] & own[None, :], noise, 0.0)
    part = np.ix_(kept, kept)
    return repeats((curves[0] - curves[1])[kept], single[part], np.asarray(whole - single)[part])
