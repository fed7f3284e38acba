"""Going on: further tests of the measurements weighed into a diagnosis that the first test left open."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

from etextile.diagnose.data.measured import MeasuredTest
from etextile.diagnose.data.points import Points, gather
from etextile.diagnose.decide.directed import checks
from etextile.diagnose.decide.foretell import Explanation, explanation
from etextile.diagnose.decide.rank import Ranking
from etextile.diagnose.decide.verdict import Answer, Finalist, decide
from etextile.diagnose.further import Round, said, stand, weighed
from etextile.diagnose.infer.free import form_modes
from etextile.diagnose.predict.run_tables import Levels
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.workflow import Diagnosis, leading_classes
from etextile.errors import BadInput
from etextile.studies.diagnose.question import Listener
from etextile.studies.diagnose.setting import DiagnosisTask, simulator_of
from loadcases.reader import LoadedCase, dump_case, read_case


MOST = 5
"""Explanations that are followed into further tests."""
UNLIKELY = 1e-5
"""Probability relative to the best below which one is followed no more, unless no channel tells it from the best."""


@dataclass(frozen=True)
class _Part:
    """A part of a further test that one kind of run predicts: the way there, or the way back."""

    name: str
    channels: tuple[str, ...]
    points: Points
    back: float | None


def go_on(task: DiagnosisTask, diagnosis: Diagnosis, runner: Runner, show: Listener) -> Diagnosis:
    """Return the diagnosis after all further tests of the measurements, in their order.

    Where the first test found nothing to follow (no gap, or nothing that explains it) it stays as it is.
    """
    measured = task.measured
    tests = list(measured.tests)
    if measured.punch_unloading:
        own = replace(measured, tests=(), punch_force=(), free_edge=None, strain_field=None, clamp_line=None)
        tests.insert(0, MeasuredTest("the way back of the first test", (), own))
    if diagnosis.verdict.kind not in (Answer.NAMED, Answer.AMBIGUOUS):
        return diagnosis
    for test in tests:
        loaded = changed_case(task.loaded, test)
        simulator = simulator_of(loaded.case, task.setting.candidates)
        with closing(Runner(simulator, runner.folder, workers=runner.workers, watch=runner.watch)) as own_runner:
            for part in _parts(test):
                diagnosis = _after(task, diagnosis, test, part, loaded, own_runner, show)
            diagnosis = replace(diagnosis, simulations=diagnosis.simulations + own_runner.count)
    return diagnosis


def changed_case(loaded: LoadedCase, test: MeasuredTest) -> LoadedCase:
    """Return the case of a further test; raises BadInput that names it."""
    try:
        return read_case(dump_case(loaded.case), overrides=test.case, file=f"the case of test {test.name!r}")
    except BadInput as error:
        problems = [replace(item, message=f"test {test.name!r}: {item.message}") for item in error.problems]
        raise BadInput(problems) from error


def _parts(test: MeasuredTest) -> Iterator[_Part]:
    there = gather(test.measured)
    if len(there):
        yield _Part(test.name, there.channels, there, None)
    curves = test.measured.punch_unloading
    if curves:
        back = gather(replace(test.measured, punch_force=curves, free_edge=None, strain_field=None, clamp_line=None))
        yield _Part(test.name, ("punch_unloading",), back, float(max(back.displacement.min(), 0.0)))


def followed(diagnosis: Diagnosis) -> tuple[Explanation, ...]:
    """Return the explanations that are possible: likely ones, and those that no channel tells from the best."""
    best, ranking = diagnosis.verdict.best, diagnosis.ranking
    if best is None:
        return ()
    top = ranking.probability(best.contender.ids)
    twins = [set(ids) for ids in itertools.product(*diagnosis.verdict.classes)]
    sets = [set(ids) for ids in diagnosis.verdict.sets]
    found = []
    for item in ranking.effects:
        p = ranking.probability(item.ids)
        if set(item.ids) in twins or set(item.ids) in sets or p >= max(UNLIKELY * top, 1e-12):
            found.append((set(item.ids) in twins or set(item.ids) in sets, p, item))
    found.sort(key=lambda entry: (not entry[0], -entry[1]))
    return tuple(explanation(item, p, diagnosis.tables, diagnosis.setting.candidates) for _, p, item in found[:MOST])


def _after(
    task: DiagnosisTask, diagnosis: Diagnosis, test: MeasuredTest, part: _Part, loaded: LoadedCase, runner: Runner,
    show: Listener,
) -> Diagnosis:  # fmt: skip
    """Return the diagnosis after one part of a further test."""
    items, setting = followed(diagnosis), diagnosis.setting
    levels = Levels.for_points(float(loaded.case.fabric.coarsening), part.points, back=part.back)
    at = stand(part.name, part.points, setting.base, levels, runner, without=test.without)
    told = said(at, items, diagnosis.tables, runner, seed=setting.seed)
    ranking = weighed(diagnosis.ranking, at, items, told)
    rest = {item.ids: one.rest_p for item, one in zip(items, told, strict=True)}
    lost = {item.ids for item, one in zip(items, told, strict=True) if not one.foretold.completed}
    finalists = _judged_again(diagnosis, ranking, items, rest, lost)
    form = form_modes(diagnosis.bench.points)
    classes = leading_classes(finalists, diagnosis.bench, diagnosis.tables, form, diagnosis.screening.unseen)
    verdict = decide(
        ranking, finalists, detected=True, lattice_doubt=diagnosis.lattice_doubt, confused=setting.confused,
        classes=classes, faults=diagnosis.faults, checks=[*checks(diagnosis.bench), *checks(at.bench)],
    )  # fmt: skip
    done = Round(
        part.name, part.channels,
        {item.label: diagnosis.ranking.probability(item.ids) for item in items},
        {item.label: ranking.probability(item.ids) for item in items},
        {item.label: rest[item.ids] for item in items},
    )  # fmt: skip
    show.tell("further", f"{part.name}: {_words(done)}")
    show.tell("verdict", verdict.sentence)
    return replace(diagnosis, ranking=ranking, finalists=finalists, verdict=verdict, rounds=(*diagnosis.rounds, done))


def _judged_again(
    diagnosis: Diagnosis, ranking: Ranking, items: Sequence[Explanation], rest: dict[tuple[str, ...], float],
    lost: set[tuple[str, ...]],
) -> tuple[Finalist, ...]:  # fmt: skip
    """Return the finalists that were followed, with their probabilities and rests after a further test."""
    found = []
    for item in diagnosis.finalists:
        ids = item.contender.ids
        if ids in rest:
            beside = {other.contender.ids: other.faint for other in diagnosis.finalists}
            found.append(replace(
                item, probability=ranking.including(*ids), alone=ranking.support(ids, beside),
                probability_coarse=1.0, rest_p=min(item.rest_p, rest[ids]),
                simulated=ids not in lost,
            ))  # fmt: skip
    return tuple(sorted(found, key=lambda item: -item.alone))


def _words(done: Round) -> str:
    order = sorted(done.after, key=lambda label: -done.after[label])
    return ", ".join(f"{label} {done.before[label]:.2g} to {done.after[label]:.2g}" for label in order)
