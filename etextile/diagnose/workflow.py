"""The diagnosis from measurements to verdict: gate, detect, screen, fit, refit with the simulator, rank, decide.

Knows the simulator only as a callable (`Runner`), so everything here is pure but for the runs it asks for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.data.points import Points, gather
from etextile.diagnose.decide.audit import AuditRow, audit
from etextile.diagnose.decide.classes import Classes, classes_of
from etextile.diagnose.decide.directed import Fault, checks, faults
from etextile.diagnose.decide.finalists import finalists_of
from etextile.diagnose.decide.heldout import split_at
from etextile.diagnose.decide.localise import Scan, scan
from etextile.diagnose.decide.opening import reopened, to_open
from etextile.diagnose.decide.rank import VISIBLE, Contender, Ranking, rank_pairs, rank_singles
from etextile.diagnose.decide.screen import Screening, screen
from etextile.diagnose.decide.survivors import survivors
from etextile.diagnose.decide.verdict import Finalist, Verdict, decide
from etextile.diagnose.decide.where import NAMES as WHERE_NAMES
from etextile.diagnose.decide.where import GapPlace, agreeing, headline, places
from etextile.diagnose.further import Round
from etextile.diagnose.infer.finer_table import depends, on_finer_lattice
from etextile.diagnose.infer.fit import Evidence
from etextile.diagnose.infer.free import form_modes, judge_free, rests
from etextile.diagnose.infer.full_table import requests_on, tables_on, whole
from etextile.diagnose.infer.lattice_doubt import doubted
from etextile.diagnose.infer.refit import refit
from etextile.diagnose.infer.refit_runs import Refit
from etextile.diagnose.infer.whitened import LatticeDoubt, Workbench, scale, set_up
from etextile.diagnose.predict.run_tables import (
    BaseRuns,
    Levels,
    anchor_laws,
    base_requests,
    change,
    doubt_requests,
    freedom,
    grids,
    slope_requests,
    slopes_of,
    turned_request,
)
from etextile.diagnose.predict.simulate import Runner, affordable
from etextile.diagnose.predict.table import EffectTable
from etextile.diagnose.setting import Prepared, Setting
from etextile.types import Array


Tell = Callable[[str, str], None]
# A lattice error above this share of the gap forbids naming.
LATTICE_SHARE = 1.0 / 3.0


@dataclass(frozen=True)
class Diagnosis:
    """Everything a report needs; `split` parts fitted from held-out displacements (or pressures).

    `opened`: sentences on ranges that were opened beyond what is usual; `faults`: faults of the test that compete;
    `lattice_doubt`: the lattice error is too large for the gap; `rounds`: further tests.
    """

    setting: Setting
    levels: Levels
    points: Points
    base_runs: BaseRuns
    bench: Workbench
    lattice: LatticeDoubt
    scan: Scan
    places: tuple[GapPlace, ...]
    where: str
    screening: Screening
    ranking: Ranking
    finalists: tuple[Finalist, ...]
    verdict: Verdict
    audit: tuple[AuditRow, ...]
    split: float
    tables: Mapping[str, EffectTable]
    free_columns: Array
    next_measurement: str
    simulations: int
    opened: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()
    slope_runs: tuple[Record, ...] = ()
    lattice_doubt: bool = False
    rounds: tuple[Round, ...] = ()

    @property
    def onset(self) -> float | None:
        """Onset of the strongest gap, in the unit of the load."""
        return self.places[0].onset.at if self.places else None


def diagnose(setting: Setting, runner: Runner, tell: Tell = lambda stage, text: None) -> Diagnosis:
    """Return the diagnosis of a measurement; `tell(stage, text)` is told what each stage found."""
    ready = prepare(setting, runner, tell)
    bench, form = ready.bench, form_modes(ready.bench.points)
    found = _detect(bench, ready.tables, seed=setting.seed)
    spots = places(bench, found)
    agree = agreeing(bench, spots)
    where = headline(spots, agree, tension=_tension(setting))
    tell("detect", f"{where} (p = {found.p_value:.3g})")
    free = judge_free(bench.samples, bench.points, scale(bench), form)
    split = split_at(spots[0].onset.high if spots else 0.0, float(ready.points.displacement.max()))
    likely: tuple[str, ...] = ()
    if found.detected:
        ready, likely = _looked_at(setting, ready, runner, form, tell)
        ready = _with_doubts(setting, ready, runner, likely, tell)
    wrong = _faults(setting, ready, runner, form) if found.detected else ()
    beside = [item.contender for item in wrong]
    explain = partial(
        _explained, setting, runner=runner, form=form, free=free, beside=beside, likely=likely, split=split,
        detected=found.detected, tell=tell,
    )  # fmt: skip
    told = explain(ready)
    wider = to_open(told.finalists, told.tables)
    if wider:
        tell("rank", "; ".join(item.words for item in wider))
        again = reopened(ready, wider, setting.candidates, runner)
        if again is not None:
            ready = again
            told = explain(ready)
    ranking, screening, tables, finalists = told.ranking, told.screening, told.tables, told.finalists
    doubt = _lattice_doubt(bench, ready.lattice, spots)
    verdict = decide(
        ranking, finalists, detected=found.detected, lattice_doubt=doubt,
        confused=setting.confused, classes=leading_classes(finalists, bench, tables, form, screening.unseen),
        faults=wrong, checks=checks(bench),
    )  # fmt: skip
    tell("verdict", verdict.sentence)
    return Diagnosis(
        setting, ready.levels, ready.points, ready.runs, bench, ready.lattice, found, spots, where, screening, ranking,
        finalists, verdict, audit(ready.runs.finer, setting.base, spots[0].onset.at if spots else None), split, tables,
        free[1], "", runner.count, tuple(item.words for item in wider), wrong,
        ready.slope_runs, doubt,
    )  # fmt: skip


@dataclass(frozen=True)
class _Explained:
    """What one pass from the screen to the finalists found."""

    ranking: Ranking
    screening: Screening
    tables: Mapping[str, EffectTable]
    finalists: tuple[Finalist, ...]


def _explained(
    setting: Setting, ready: Prepared, *, runner: Runner, form: Array, free: tuple[Evidence, Array],
    beside: Sequence[Contender], likely: Sequence[str], split: float, detected: bool, tell: Tell,
) -> _Explained:  # fmt: skip
    """Screen, fit, refit and rank all hypotheses with the tables that are ready; `likely`: effects to be refitted."""
    bench = ready.bench
    ranking = rank_singles(bench, ready.tables, form, free)
    fits = {item.ids[0]: item.evidence for item in ranking.effects}
    screening = screen(bench.mean_sample, ready.tables, fits)
    tell("screen", _screen_text(screening))
    tables: dict[str, EffectTable] = dict(ready.tables)
    if not detected:
        return _Explained(ranking, screening, tables, ())
    seen = {name: table for name, table in tables.items() if name not in screening.unseen}
    ranking = ranking.replaced(rank_pairs(bench, seen, form, likely=likely))
    tell("fit", _ranking_text(ranking))
    left = rests(bench.points, scale(bench))
    context = Refit(setting, ready, runner, form, left, split, setting.seed, tuple(seen), tuple(likely))
    ranking, tables, finalists = finalists_of(context, ranking, refit(context, ranking), beside)
    tell("rank", _ranking_text(ranking))
    return _Explained(ranking, screening, tables, finalists)


def _faults(setting: Setting, ready: Prepared, runner: Runner, form: Array) -> tuple[Fault, ...]:
    """Return the faults of the test that compete with effects; one more run, of the specimen turned."""
    run = runner([turned_request(ready.levels, setting.base.laws)])[0]
    points, base = ready.points, ready.lattice.value
    turned = ready.bench.bins.average(change(points, observe(run, points), observe(ready.runs.coarse, points), base))
    seen = np.linalg.norm(ready.bench.mean_sample.whiten(np.nan_to_num(turned))) >= VISIBLE
    exponents = [law[3] for law in setting.base.laws]
    return faults(
        ready.bench, form, ready.jacobian, exponents=exponents, coupons=any(setting.base.coupons),
        turned=turned if seen else None,
    )  # fmt: skip


def leading_classes(
    finalists: Sequence[Finalist], bench: Workbench, tables: Mapping[str, EffectTable], form: Array,
    unseen: Sequence[str],
) -> Classes:  # fmt: skip
    """Return the classes of the hypothesis that leads."""
    sound = [item for item in finalists if item.sound]
    if not sound:
        return ()
    leader = max(sound, key=lambda item: item.alone).contender
    seen = {name: table for name, table in tables.items() if name not in unseen or name in leader.ids}
    return classes_of(leader, bench, seen, form)


def prepare(setting: Setting, runner: Runner, tell: Tell) -> Prepared:
    """Run base, derivatives and all effects at few of their parameters, and set up the workbench."""
    points = gather(setting.measured)
    levels = Levels.for_points(setting.coarsening, points)
    anchor = anchor_laws(setting.base, setting.case_laws)
    plans = grids(setting.candidates, yarns_seen_to=setting.base.yarns_seen_to)
    first = {name: grid.thinned() for name, grid in plans.items()}
    base = base_requests(levels, setting.base.laws, anchor)
    slopes = slope_requests(levels, setting.base, anchor)
    todo = runner.missing([*base, *slopes])
    tell("simulate", f"{todo} runs to make for base and fabric parameters")
    records = runner([*base, *slopes])
    runs, of_slopes = BaseRuns(*records[: len(base)]), records[len(base) :]
    lattice = runs.lattice_error(points)
    at_anchor = observe(runs.anchor, points)
    moved = [observe(record, points) for record in of_slopes]
    bench = set_up(points, runs.finer, lattice, freedom(setting.base, at_anchor, moved))
    tell("gate", _gate_text(points, lattice))
    jacobian = bench.bins.average(slopes_of(at_anchor, moved))
    levels = replace(levels, solves=affordable(runs.anchor))
    bare = Prepared(levels, points, runs, lattice, bench, {}, anchor, jacobian, tuple(of_slopes), plans)
    if not first:
        return bare
    todo = runner.missing(requests_on(bare, first, setting.candidates))
    tell("simulate", f"{todo} runs to make for a first look at {len(first)} effects")
    return replace(bare, tables=tables_on(bare, first, setting.candidates, runner))


def _looked_at(
    setting: Setting, ready: Prepared, runner: Runner, form: Array, tell: Tell
) -> tuple[Prepared, tuple[str, ...]]:
    """Return whole tables for the effects that come into question, and the names of these."""
    while True:
        names = survivors(ready.bench, ready.tables, form, few=ready.few)
        todo = [name for name in names if name in ready.few]
        if not todo:
            words = _lost_words(ready.tables)
            if words:
                tell("look", words)
            return ready, names
        count = runner.missing(requests_on(ready, {name: ready.plans[name] for name in todo}, setting.candidates))
        tell("look", f"whole tables for {', '.join(todo)}: {count} more runs")
        ready = whole(ready, todo, setting.candidates, runner)


def _lost_words(tables: Mapping[str, EffectTable]) -> str:
    """Return which effects could not be simulated at all that was asked of them, as a sentence; empty for none."""
    lost = [
        f"{name} ({np.count_nonzero(~table.valid)} of {len(table.grid.nodes())})"
        for name, table in tables.items()
        if not np.all(table.valid)
    ]
    return f"could not be simulated at some of their parameters: {', '.join(lost)}" if lost else ""


def _with_doubts(
    setting: Setting, ready: Prepared, runner: Runner, names: Sequence[str], tell: Tell
) -> Prepared:  # fmt: skip
    """Return the prepared tables with what the lattice leaves open in the effects that survived the first look."""
    chosen = [item for item in setting.candidates if item.card.id in names]
    points, base, tables = ready.points, ready.lattice.value, dict(ready.tables)
    plans = {item.card.id: tables[item.card.id].grid for item in chosen}
    requests = doubt_requests(ready.levels, chosen, plans, ready.anchor)
    tell("look", f"{len(chosen)} of {len(tables)} effects come into question: {runner.missing(requests)} finer runs")
    reference, *finer = (observe(record, points) for record in runner(requests))
    for item, on_finer in zip(chosen, finer, strict=True):
        moved = ready.bench.bins.average(change(points, on_finer, reference, base))
        tables[item.card.id] = doubted(tables[item.card.id], ready.bench, moved)
    moving = [item for item in chosen if depends(tables[item.card.id])]
    if moving:
        tell("look", f"tables on a finer lattice for {', '.join(item.card.id for item in moving)}")
    tables |= {item.card.id: on_finer_lattice(ready, item, tables[item.card.id], runner) for item in moving}
    return replace(ready, tables=tables)


def _detect(bench: Workbench, tables: Mapping[str, EffectTable], *, seed: int) -> Scan:
    """Scan for a gap in windows and along the changes that effects make."""
    weights = np.array([item.weight for item in bench.scatters])
    patterns = np.stack([table.basis[:, 0] for table in tables.values()], axis=1) if tables else None
    return scan(
        bench.points, bench.residual, [sample.whiten for sample in bench.samples], weights,
        size=scale(bench), patterns=patterns, seed=seed,
    )  # fmt: skip


def _lattice_doubt(bench: Workbench, lattice: LatticeDoubt, spots: Sequence[GapPlace]) -> bool:
    """Tell whether the lattice error is too large for the gap: rms over the strongest window of the gap."""
    if not spots:
        return False
    window = spots[0].window
    own = bench.points.owner == window.series
    inside = own & (bench.points.displacement >= window.low) & (bench.points.displacement <= window.high)
    error = bench.bins.average(lattice.deviation)
    gap = float(np.sqrt(np.mean(bench.residual[inside] ** 2)))
    return bool(np.sqrt(np.mean(error[inside] ** 2)) > LATTICE_SHARE * gap)


def _gate_text(points: Points, lattice: LatticeDoubt) -> str:
    force = points.curves
    if not force.any():
        return "base from two finer lattices"
    share = float(np.sqrt(np.mean(lattice.deviation[force] ** 2)) / np.sqrt(np.mean(points.value[force] ** 2)))
    return f"base from two finer lattices; {100 * share:.2f} % of the {WHERE_NAMES[points.channels[0]]} stay open"


def _tension(setting: Setting) -> str:
    names = [name for name, used in zip(("warp", "weft", "bias"), setting.base.coupons, strict=True) if used]
    if not names:
        return "the coupons were not used" if setting.measured.tensile else ""
    return f"base identified from {', '.join(names)} coupons"


def _screen_text(screening: Screening) -> str:
    order = sorted(screening.scores.items(), key=lambda item: -abs(item[1]))[:3]
    text = "strongest: " + ", ".join(f"{name} ({z:+.1f})" for name, z in order)
    if screening.groups:
        text += "; look alike: " + ", ".join(" = ".join(group) for group in screening.groups)
    if screening.unseen:
        text += f"; these channels cannot show {', '.join(screening.unseen)}"
    return text


def _ranking_text(ranking: Ranking) -> str:
    pairs = zip(ranking.contenders, ranking.probabilities, strict=True)
    return ", ".join(f"{item.label} {p:.2f}" for item, p in list(pairs)[:4] if p > 0.005)


def with_next(diagnosis: Diagnosis, text: str) -> Diagnosis:
    """Return the diagnosis with the next measurement to make."""
    return replace(diagnosis, next_measurement=text)
