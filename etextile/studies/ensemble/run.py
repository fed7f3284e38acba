"""From a case to failure probabilities: sample what scatters, run the samples on workers, judge, report, draw.

Every sample is kept in its own file. An ensemble that was interrupted or enlarged goes on with the samples that are
there, and the numbers do not depend on how many workers there were.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from etextile.ensemble.sample import Method, unit_rows
from etextile.ensemble.store import (
    BROKEN_OFF,
    FOLDER,
    Sample,
    SampleKey,
    foreign,
    read_samples,
    sample_path,
    write_sample,
)
from etextile.errors import BadInput, EtextileError
from etextile.files import check_targets, one_writer, short, write_whole
from etextile.kept import code_digest
from etextile.process import begin_server
from etextile.studies.cases import AnyCase, loaded_case
from etextile.studies.ensemble.plan import PLAIN, Ensemble, ensemble_case, plan_of
from loadcases.reader import LoadedCase, as_loaded


if TYPE_CHECKING:
    from etextile.studies.ensemble.specimen import SampleTask

Watcher = Callable[[int, str], None]
"""Is told how many samples are there and a few words."""
WRITTEN = (
    "case.yaml", "ensemble.json", "samples.csv", "fragility.png", "fragility_wires.png", "ranking.png",
    "probability.png", "probability_open.png",
)  # fmt: skip
"""Files in an ensemble's folder beside its samples."""
ASIDE = ("app", "manual", "identify", "diagnose")
"""Parts of the package that no sample depends on."""
MOST_SAMPLES = 100_000


@dataclass(frozen=True)
class EnsembleOutcome:
    """What an ensemble leaves: exit code, folder, `ensemble.json` (or `compare.json`) as data."""

    exit_code: int
    folder: Path
    data: dict[str, Any]


@one_writer("folder")
def ensemble(
    case: AnyCase,
    folder: str | Path,
    *,
    samples: int = 128,
    seed: int = 0,
    method: Method = "sobol",
    jobs: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    force: bool = False,
    watch: Watcher | None = None,
) -> EnsembleOutcome:
    """Scatter fabric, wires, body and mounting; write ensemble.json, samples.csv and plots into `folder`.

    `jobs`: worker processes (as many as cores by default), or `scheduler`: address of a dask scheduler with workers.
    Exit codes: 0 done, 3 no run found equilibrium, 4 more than a twentieth of the runs passed a trust limit. Raises
    BadInput before anything is computed or written.
    """
    if scheduler is None:
        begin_server()
    loaded = loaded_case(case)
    with loaded.locating():
        plan = prepare(loaded, Path(folder), samples=samples, seed=seed, method=method, resume=resume, force=force)
        (found,) = run_missing([plan], jobs=jobs, scheduler=scheduler, watch=watch)
        return conclude(plan, found)


def prepare(
    loaded: LoadedCase,
    folder: Path,
    *,
    samples: int,
    seed: int,
    method: Method,
    resume: bool = False,
    force: bool = False,
) -> Ensemble:
    """Return what is to be run; raises BadInput for a case that cannot be sampled and for another ensemble's folder."""
    if not 1 <= samples <= MOST_SAMPLES:
        raise BadInput.of(f"from 1 to {MOST_SAMPLES} samples can be run (got {short(str(samples))})")
    check_targets(folder, (f"{FOLDER}/", *WRITTEN))
    case, notes = ensemble_case(loaded.case)
    plan = plan_of(case)
    text = as_loaded(case)
    key = SampleKey(text.sha256, seed, method, 0 if method == "sobol" else samples, _code())
    if foreign(folder, key):
        if resume or not force:
            raise BadInput.of(
                "holds samples of another case, seed or method, choose another --output or overwrite it with --force",
                file=str(folder),
            )
        for path in (folder / FOLDER).glob("sample_*.npz"):
            path.unlink()
    elif resume and not any((folder / FOLDER).glob("sample_*.npz")):
        raise BadInput.of("there are no samples to go on from, run without --resume", file=str(folder))
    rows = unit_rows(samples, seed=seed, method=method)
    name = loaded.path.stem if loaded.path else ""
    return Ensemble(case, text.source_text, name, key, folder, plan, rows, (*notes, *plan.notes))


@lru_cache(maxsize=1)
def _code() -> str:
    """Return a digest of all code that a sample depends on."""
    root = Path(__file__).parents[3]
    inside = sorted(path.name for path in (root / "etextile").iterdir() if path.name not in ASIDE)
    parts = [f"etextile/{name}" for name in inside if name.endswith(".py") or (root / "etextile" / name).is_dir()]
    return code_digest(root, (*parts, "wires", "loadcases"))


def run_missing(
    ensembles: Sequence[Ensemble], *, jobs: int | None, scheduler: str | None, watch: Watcher | None
) -> list[list[Sample]]:
    """Return all samples of each ensemble, in order; runs those that are not in its folder yet."""
    found = [read_samples(item.folder, item.key, item.count) for item in ensembles]
    tasks = [task for item, there in zip(ensembles, found, strict=True) for task in _tasks(item, there)]
    if tasks:
        by_key = {item.key: there for item, there in zip(ensembles, found, strict=True)}
        for sample in _run(tasks, done=sum(map(len, found)), jobs=jobs, scheduler=scheduler, watch=watch):
            by_key[sample.key][sample.number] = sample
    return [[there[number] for number in range(item.count)] for item, there in zip(ensembles, found, strict=True)]


def _tasks(ensemble: Ensemble, there: dict[int, Sample]) -> list[SampleTask]:
    """Return the tasks whose samples are missing; makes the folder."""
    from etextile.studies.ensemble.specimen import SampleTask

    (ensemble.folder / FOLDER).mkdir(parents=True, exist_ok=True)
    write_whole(ensemble.folder / "case.yaml", ensemble.case_text)
    folder = str(ensemble.folder.resolve())
    return [
        SampleTask(ensemble.case_text, ensemble.key, folder, number, tuple(row.tolist()))
        for number, row in enumerate(ensemble.rows)
        if number not in there
    ]


def _run(
    tasks: Sequence[SampleTask], *, done: int, jobs: int | None, scheduler: str | None, watch: Watcher | None
) -> list[Sample]:
    """Return the samples of all tasks; raises the error of the program when no task at all ended."""
    from etextile.ensemble.schedule import run_all, workers
    from etextile.studies.ensemble.sample import run_sample, warm_up

    _say(watch, done, "starting")
    if scheduler is None:
        for text in {task.case_text for task in tasks}:
            warm_up(text)
    begun = 0.0  # when the first sample came: workers need some seconds to start
    samples: list[Sample] = []
    lost: list[tuple[SampleTask, BaseException]] = []
    names = [f"sample-{task.key.sha256[:12]}-{task.key.seed}-{task.key.method}-{task.number}" for task in tasks]
    with workers(jobs=min(jobs or len(tasks), len(tasks)) if jobs else None, scheduler=scheduler) as client:
        for outcome in run_all(client, run_sample, tasks, names=names):
            if outcome.result is None:
                lost.append((outcome.task, outcome.error or RuntimeError("no result")))
            else:
                samples.append(_kept(outcome.task, outcome.result))
            ended = len(samples) + len(lost)
            begun = begun or time.monotonic()
            left = (time.monotonic() - begun) / max(ended - 1, 1) * (len(tasks) - ended)
            broken = sum(sample.status == BROKEN_OFF for sample in samples) + len(lost)
            words = f"about {left:.0f} s left" if ended > 1 else "running"
            words += f", {broken} without equilibrium" if broken else ""
            _say(watch, done + ended, words)
    if lost and not samples and not done:
        raise lost[0][1]
    return [*samples, *(_lost(task, error) for task, error in lost)]


def _say(watch: Watcher | None, done: int, words: str) -> None:
    if watch is not None:
        watch(done, words)


def _kept(task: SampleTask, sample: Sample) -> Sample:
    """Return a sample that has its file; a worker on another machine may have no access to the folder."""
    path = sample_path(Path(task.folder), task.number)
    if not path.exists():
        write_sample(sample, Path(task.folder))
    return sample


def _lost(task: SampleTask, error: BaseException) -> Sample:
    """Return a run that ended by an error of program or machine: nothing is known of it, and it is not kept on disk."""
    from etextile.studies.ensemble.sample import unknown_sample

    return unknown_sample(task, f"{type(error).__name__}: {error}")


def _without_scatter(ensemble: Ensemble, data: dict[str, Any]) -> list[str]:
    """Run the case without scatter, add what its laws say to the data, return what its trust limits say."""
    from etextile.studies.run.limits import limits_of
    from etextile.studies.run.simulate import simulate
    from etextile.studies.run.worn import folded_loops
    from loadcases.judging import judge_for
    from wires.trust import exceeded

    judge = judge_for(ensemble.case)
    folder = ensemble.folder / PLAIN
    done = simulate(as_loaded(ensemble.case), folder, resume=False, force=True, seed=0, watch=None)
    laws, checks = limits_of(done, ensemble.case, judge, damage=judge.verdict(done.results.wires))
    passed = exceeded(checks)
    data["trust"]["without_scatter"] = {"limits": passed, "laws": laws.as_dict()["sentence"]}
    folded = int(folded_loops(done.results).sum()) if ensemble.case.worn else 0
    if folded:
        data["notes"].append(
            f"{folded} of the loops of the case without scatter lie in folds of the crook, where the model has no "
            "answer: they count as neither whole nor broken by folding"
        )
    if laws.beyond:
        data["notes"].append(f"the case without scatter: {laws.as_dict()['sentence']}")
    return passed


def conclude(ensemble: Ensemble, samples: Sequence[Sample]) -> EnsembleOutcome:
    """Judge the samples of an ensemble and write everything about it."""
    from etextile.studies.ensemble.drawing import draw
    from etextile.studies.ensemble.report import conclude_verdict, report, write_report, write_samples
    from etextile.studies.ensemble.specimen import nominal

    built = nominal(ensemble.case_text).built
    if built.wires is None:
        raise EtextileError("a sampled case has no wires")
    data = report(ensemble, samples, built.wires.layout)
    conclude_verdict(data, _without_scatter(ensemble, data))
    write_report(data, ensemble.folder / "ensemble.json")
    write_samples(data, samples, built.wires.layout, ensemble.folder / "samples.csv")
    draw(data, built, ensemble.folder)
    code = 3 if data["failed_runs"] == data["samples"] else 4 if data["verdict"]["withheld"] else 0
    return EnsembleOutcome(code, ensemble.folder, data)
