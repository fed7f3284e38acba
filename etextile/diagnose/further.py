"""Further tests: what they say of the explanations that the first test left, without going through the library again.

A further test has its own base (two finer lattices, fabric slopes) and one or a few runs per surviving explanation. Its
likelihood under each multiplies what the first test gave; nothing of the first is repeated. A free smooth discrepancy
competes here too, so that a test which none of the explanations foretold leads back to `unexplained`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.diagnose.data.observe import observe
from etextile.diagnose.data.points import Points
from etextile.diagnose.decide.foretell import Explanation, Foretold
from etextile.diagnose.decide.localise import scan
from etextile.diagnose.decide.plan import log_density
from etextile.diagnose.decide.rank import OF_EFFECTS, Contender, Kind, Ranking
from etextile.diagnose.infer.fit import FORM
from etextile.diagnose.infer.free import LENGTHS, SIZES, form_modes, free_modes
from etextile.diagnose.infer.gauss import Whitener, log_sum
from etextile.diagnose.infer.lattice_doubt import left_open, undetermined
from etextile.diagnose.infer.whitened import MEAN_LOOSE, Workbench, scale, set_up
from etextile.diagnose.predict.parameters import BaseParameters
from etextile.diagnose.predict.run_tables import BaseRuns, Levels, base_requests, change, freedom, slope_requests
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.predict.table import EffectTable
from etextile.types import Array


@dataclass(frozen=True)
class Stand:
    """A further test against the base: lattices, base runs, workbench; `without`: effects that cannot act in it."""

    name: str
    points: Points
    levels: Levels
    base: BaseParameters
    runs: BaseRuns
    bench: Workbench
    value: Array
    without: tuple[str, ...] = ()


@dataclass(frozen=True)
class TestedExplanation:
    """What a test says of one explanation: prediction on thinned points, log likelihood, chance of what it leaves."""

    foretold: Foretold
    log_likelihood: float
    rest_p: float


@dataclass(frozen=True)
class Round:
    """One further test: its name and channels, and what it said of every explanation, by label.

    `before`, `after`: probabilities of exactly these effects; `rest_p`: chance that noise leaves what they leave.
    """

    test: str
    channels: tuple[str, ...]
    before: dict[str, float]
    after: dict[str, float]
    rest_p: dict[str, float]


def stand(
    name: str, points: Points, base: BaseParameters, levels: Levels, runner: Runner, *, without: Sequence[str] = ()
) -> Stand:  # fmt: skip
    """Run the base of a further test and set up its workbench."""
    laws = base.laws
    requests = [*base_requests(levels, laws, laws), *slope_requests(levels, base, laws)]
    records = runner(requests)
    runs = BaseRuns(*records[:5])
    lattice = runs.lattice_error(points)
    moved = [observe(record, points) for record in records[5:]]
    bench = set_up(points, runs.finer, lattice, freedom(base, observe(runs.anchor, points), moved))
    return Stand(name, points, levels, base, runs, bench, lattice.value, tuple(without))


def said(
    at: Stand, items: Sequence[Explanation], tables: Mapping[str, EffectTable], runner: Runner, *, seed: int = 0
) -> list[TestedExplanation]:  # fmt: skip
    """Return what a further test says of every explanation, by runs on the case's lattice and the first finer one."""
    laws, fine = at.base.laws, at.levels.gate[0]
    wanted = []
    for item in items:
        central, *moved = item.requests(at.without)
        wanted.append(at.levels.request(laws, central, coarsening=fine))
        wanted += [at.levels.request(laws, specs) for specs in (central, *moved)]
    records = iter(runner(wanted))
    found = []
    for item in items:
        on_fine = _change(at, next(records), finer=True)
        coarse = [_change(at, next(records), finer=False) for _ in item.requests(at.without)]
        found.append(_said(at, item, on_fine, coarse, tables, seed=seed))
    return found


def _change(at: Stand, record: object, *, finer: bool) -> Array:
    """Return the change (n,) of thinned points by an explanation, from its run and that of the base beside it."""
    reference = observe(at.runs.fine if finer else at.runs.coarse, at.points)
    run = observe(record, at.points)  # type: ignore[arg-type]
    return at.bench.bins.average(change(at.points, run, reference, at.value))


def _said(
    at: Stand, item: Explanation, on_fine: Array, coarse: Sequence[Array], tables: Mapping[str, EffectTable], *,
    seed: int,
) -> TestedExplanation:  # fmt: skip
    bench, central = at.bench, coarse[0]
    completed = bool(np.all(np.isfinite(on_fine)) and np.all(np.isfinite(central)))
    moved = np.nan_to_num(on_fine - central)
    mean = np.where(np.isfinite(on_fine), on_fine, np.nan_to_num(central))
    spread = np.stack([np.nan_to_num(other - central) for other in coarse[1:]] or [np.zeros_like(mean)], axis=1)
    factors = FORM * form_modes(bench.points) * mean[:, None]
    columns = np.concatenate([spread, factors], axis=1)
    covariance = bench.mean_covariance + columns @ columns.T
    acting = [name for name in item.ids if name not in at.without]
    cards = [tables[name].grid.card for name in acting]
    if cards:
        covariance = covariance + left_open(bench.points, moved, cards, change=mean)
    for card in cards:
        loose = undetermined(bench.points, card)
        covariance = covariance if loose is None else covariance + MEAN_LOOSE**2 * loose
    whiten = Whitener.of(covariance)
    rest = bench.residual - mean
    p = scan(bench.points, rest, [whiten], np.ones(1), size=scale(bench), seed=seed).p_value
    foretold = Foretold(item.label, item.probability, bench.base + mean, covariance, completed)
    return TestedExplanation(foretold, float(log_density(rest[:, None], whiten)[0]), p)


def free_likelihood(bench: Workbench) -> float:
    """Return the log likelihood of a test under a free smooth discrepancy, all sizes and lengths alike."""
    values = []
    for length in LENGTHS:
        modes = np.concatenate(list(free_modes(bench.points, scale(bench), length).values()), axis=1)
        for size in SIZES:
            if size:
                whiten = Whitener.of(bench.mean_covariance + size**2 * modes @ modes.T)
                values.append(float(log_density(bench.residual[:, None], whiten)[0]))
    return float(log_sum(np.array(values))) - float(np.log(len(values)))


def weighed(ranking: Ranking, at: Stand, items: Sequence[Explanation], told: Sequence[TestedExplanation]) -> Ranking:
    """Return the ranking after a further test: explanations by what it said of them, all others by a free curve.

    Effects that were not run are out; nothing at all is judged by the base.
    """
    own = {item.contender.key: said.log_likelihood for item, said in zip(items, told, strict=True)}
    bench = at.bench
    nothing = float(log_density(bench.residual[:, None], Whitener.of(bench.mean_covariance))[0])
    free = free_likelihood(bench)

    def after(item: Contender) -> Contender:
        if item.kind is Kind.NONE:
            gained = nothing
        elif item.kind in OF_EFFECTS:
            gained = own.get(item.key, -np.inf)
        else:
            gained = free
        return replace(item, log_prior=item.log_prior + gained)

    return Ranking.of([after(item) for item in ranking.contenders])
