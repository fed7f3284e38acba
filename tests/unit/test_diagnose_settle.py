"""What the lattice leaves open in an effect: covariance of a moved change, and of what a card calls undetermined."""

from __future__ import annotations

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from etextile.diagnose.data.noise import NoiseScatter, SignalShape, WeightedScatter
from etextile.diagnose.data.points import Points, Series, Thinning
from etextile.diagnose.decide.rank import rank_pairs, rejudged
from etextile.diagnose.infer import refit_pairs, refit_runs
from etextile.diagnose.infer.fit import bound, judge
from etextile.diagnose.infer.lattice_doubt import doubted, facing, left_open, undetermined
from etextile.diagnose.infer.refit_pairs import averaged, settled_pairs
from etextile.diagnose.infer.refit_runs import Refit, on_both
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable, ParameterAxis, ParameterGrid, axes_of
from etextile.effects.base import Card, Example, Parameter, Undetermined
from etextile.effects.registry import EFFECTS
from etextile.effects.rotational_shear import RotationalShear
from etextile.types import Array
from etextile.vocabulary import EDGE, FORCE


def measured() -> Points:
    """Return two force curves and the height of the free edge at two places, 0 to 40 mm."""
    u = np.linspace(1.0, 40.0, 40)
    force = [Series(FORCE, "force", "N", n, f"punch_{n}") for n in (0, 1)]
    edge = Series(EDGE, "height", "mm", 0, EDGE)
    place = np.repeat([0.0, 40.0], 40)
    nowhere = np.full(80, np.nan)
    return Points(
        (*force, edge), np.repeat([0, 1, 2, 2], 40), np.tile(u, 4), np.concatenate([nowhere, place]),
        np.concatenate([nowhere, np.full(80, np.inf)]), np.zeros(160), np.full(160, np.nan),
    )  # fmt: skip


def open_in(moved: Array, change: Array | None = None) -> Array:
    """Return what is left open in an effect that calls nothing undetermined."""
    card = replace(RotationalShear.card, undetermined=())
    return left_open(measured(), moved, [card], change=np.zeros(160) if change is None else change)


def deviation(covariance: Array) -> Array:
    return np.sqrt(np.diag(covariance))


def test_a_change_that_every_lattice_gives_alike_is_in_no_doubt() -> None:
    assert not open_in(np.zeros(160)).any()


def test_the_doubt_has_the_size_of_the_move_where_it_moved_and_fades_away_from_there() -> None:
    points = measured()
    moved = np.where(points.of(EDGE) & (points.displacement > 20.0), 0.7, 0.0)
    found = deviation(open_in(moved))
    assert found[points.of(EDGE) & (points.displacement > 32.0)] == pytest.approx(0.7, rel=0.01)
    assert found[points.of(EDGE) & (points.displacement < 5.0)].max() < 0.07
    assert not found[points.of(FORCE)].any()


def test_specimens_are_wrong_together_and_channels_apart() -> None:
    points = measured()
    found = open_in(np.ones(160))
    first, second, edge = (np.flatnonzero(points.owner == i) for i in range(3))
    np.testing.assert_allclose(found[np.ix_(first, first)], found[np.ix_(first, second)])
    assert not found[np.ix_(first, edge)].any()
    assert np.linalg.eigvalsh(found).min() > -1e-9


def test_over_places_a_field_is_known_up_to_its_form_and_a_force_is_not_judged_twice() -> None:
    points = measured()
    found = deviation(open_in(np.zeros(160), np.full(160, 3.0)))
    assert found[points.of(EDGE)] == pytest.approx(0.3)
    assert not found[points.of(FORCE)].any()


def test_what_a_card_leaves_undetermined_is_as_large_as_it_says_and_there_alone() -> None:
    points = measured()
    card = replace(RotationalShear.card, undetermined=(Undetermined(EDGE, "height", 1.5),))
    found = deviation(undetermined(points, card))
    assert found[points.of(EDGE)] == pytest.approx(1.5)
    assert not found[points.of(FORCE)].any()
    assert not left_open(points, np.full(160, 7.0), [card], change=np.zeros(160))[80:, 80:].any()
    assert undetermined(points.where(points.of(FORCE)), card) is None


def toy(name: str, curve: Array, *, undetermined: tuple[Undetermined, ...] = ()) -> EffectTable:
    """An effect whose change is its parameter, 0 to 4, times a curve."""
    parameter = Parameter("size", "", 0.0, 4.0, "the size")
    card = Card(name, "a toy", (parameter,), Example({"size": 4.0}), undetermined=undetermined)
    grid = ParameterGrid(card, (ParameterAxis(parameter, np.array([0.0, 4.0]), 0),))
    return EffectTable(grid, curve[:, None], np.array([[0.0, 4.0]]), np.array([True, True]))


def workbench(residual: Array) -> Workbench:
    points = measured()
    shape = SignalShape(np.zeros(160), np.zeros(160), np.zeros(160))
    small = (WeightedScatter(1.0, NoiseScatter(1e-6, 1e-6, 1e-6)),)
    bins = Thinning(np.arange(160), np.ones(160))
    return Workbench(
        points, bins, points, np.zeros(160), residual, np.full(160, 0.1), np.full(160, 0.1), shape, small,
        np.zeros((160, 1)), np.zeros(160),
    )  # fmt: skip


def test_an_effect_without_an_answer_on_the_finer_lattice_is_in_doubt_altogether() -> None:
    curve = np.where(measured().of(EDGE), 0.5, 0.0)
    table = toy("a", curve)
    bench = workbench(np.zeros(160))
    settled = doubted(table, bench, 4.0 * curve)
    failed = doubted(table, bench, np.full(160, np.nan))
    assert deviation(failed.doubt)[80:] == pytest.approx(np.hypot(2.0, 0.2), rel=1e-6)
    assert deviation(settled.doubt)[80:] == pytest.approx(0.2, rel=1e-6)


def test_doubts_of_a_pair_add_up_and_an_effect_without_any_faces_the_bench_as_it_is() -> None:
    bench = workbench(np.zeros(160))
    first, second = (replace(toy(name, np.ones(160)), doubt=np.eye(160)) for name in "ab")
    assert facing(bench, [toy("c", np.ones(160))]) is bench
    np.testing.assert_allclose(facing(bench, [first, second]).doubt, 2.0 * np.eye(160))


@pytest.mark.parametrize("fold", [0.0, 1.0])
def test_what_is_undetermined_costs_little_where_it_does_not_show_and_is_taken_up_where_it_does(fold: float) -> None:
    """An effect that lifts the edge by 1 mm, with and without a fold of 1 mm that its own simulation lacks."""
    points = measured()
    rng = np.random.default_rng(4)
    lift = np.where(points.of(EDGE), 1.0, 0.0)
    wave = np.where(points.of(EDGE), np.sin(points.displacement / 6.0), 0.0)
    bench = workbench(lift + fold * wave + 0.1 * rng.standard_normal(160))
    form = np.zeros((160, 1))
    strict = toy("strict", lift)
    loose = replace(strict, loose=undetermined(points, toy("b", lift, undetermined=LOOSE).grid.card))
    evidence = [judge(facing(bench, (table,)).samples, (table,), form).log_evidence for table in (strict, loose)]
    nothing = judge(bench.samples, (), form).log_evidence
    if fold:
        assert evidence[1] > evidence[0] + 100.0
    else:
        assert evidence[1] > evidence[0] - 10.0
    assert evidence[1] > nothing + 20.0


def test_a_pair_does_not_gain_by_what_its_effects_leave_open() -> None:
    """What an effect may be wrong by costs its pairs evidence in the quick ranking as in the full one."""
    points = measured()
    curves = {"rise": points.displacement / 40.0, "kink": np.maximum(points.displacement - 25.0, 0.0) / 15.0}
    tables = {name: toy(name, np.where(points.of(FORCE), curve, 0.0)) for name, curve in curves.items()}
    vague = toy("vague", np.where(points.of(EDGE), 0.1, 0.0))
    tables["vague"] = replace(vague, doubt=open_in(np.full(160, 5.0)))
    rng = np.random.default_rng(7)
    hidden = sum(2.0 * table.basis[:, 0] for name, table in tables.items() if name != "vague")
    bench = workbench(hidden + 0.1 * rng.standard_normal(160))
    (first,) = rank_pairs(bench, tables, np.zeros((160, 1)), keep=1)
    assert set(first.ids) == {"rise", "kink"}
    pair = [tables[name] for name in first.ids]
    quick = judge((facing(bench, pair).mean_sample,), pair, np.zeros((160, 1))).log_evidence
    assert quick == pytest.approx(first.evidence.log_evidence, abs=0.01)


def test_a_pair_whose_fabric_folds_in_another_way_at_every_run_is_judged_by_their_mean_and_scatter() -> None:
    """A machine's rise and an edge that lifts; each run folds by a wave of 0.4 mm elsewhere, as the piece does."""
    points, form = measured(), np.zeros((160, 1))
    edge, phase = points.of(EDGE), points.displacement / 6.0
    waves = [np.where(edge, 0.4 * np.sin(phase + shift), 0.0) for shift in (0.0, 1.3, 2.6, 3.9, 5.2)]
    curves = {"rise": np.where(points.of(FORCE), points.displacement / 40.0, 0.0), "lift": np.where(edge, 1.0, 0.0)}
    tables = {name: toy(name, curve) for name, curve in curves.items()}
    rng = np.random.default_rng(11)
    bench = workbench(2.0 * curves["rise"] + 2.0 * curves["lift"] + waves[4] + 0.1 * rng.standard_normal(160))
    context = Refit(None, SimpleNamespace(bench=bench), None, form, (), 0.0, 0, (), ())
    (pair,) = rank_pairs(bench, tables, form, keep=1)
    single = [rejudged(pair, bench, tables, form, offset=wave) for wave in waves[:4]]
    together = averaged(context, tables, pair, waves[:4])
    assert together.score > max(item.score for item in single) + 50.0
    assert deviation(together.doubt)[edge] == pytest.approx(0.4 / np.sqrt(2.0), rel=0.4)
    assert not together.doubt[np.ix_(~edge, ~edge)].any()
    for i, _ in enumerate(pair.ids):
        _, low, high = together.evidence.interval(i)
        assert low < 2.0 < high


def test_runs_that_never_settle_are_averaged_with_that_on_the_finest_lattice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run folds by 2 mm in another way, so that the likeliest lift moves with each."""
    points, form = measured(), np.zeros((160, 1))
    edge = points.of(EDGE)
    curves = {"rise": np.where(points.of(FORCE), points.displacement / 40.0, 0.0), "lift": np.where(edge, 1.0, 0.0)}
    tables = {name: toy(name, curve) for name, curve in curves.items()}
    rng = np.random.default_rng(12)
    hidden = 2.0 * curves["rise"] + 2.0 * curves["lift"]
    bench = workbench(hidden + 0.1 * rng.standard_normal(160))
    runs = SimpleNamespace(fine=SimpleNamespace(cell=2.0), finer=SimpleNamespace(cell=1.0))
    context = Refit(None, SimpleNamespace(bench=bench, runs=runs), None, form, (), 0.0, 0, (), ())
    folds = itertools.cycle([-2.0, 2.0])
    for module in (refit_pairs, refit_runs):
        monkeypatch.setattr(
            module, "changes", lambda _, pairs, *__, **___: [hidden + next(folds) * curves["lift"] for _ in pairs]
        )
    restless, failed = set(), set()
    (pair,) = settled_pairs(
        context, tables, rank_pairs(bench, tables, form, keep=1), failed, restless, least=-np.inf
    )  # fmt: skip
    assert restless == {pair.ids}
    assert not failed
    assert deviation(pair.doubt)[edge].min() > 1.0


def test_what_is_lost_on_one_gate_lattice_is_not_run_on_the_finest(monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes longest there, and without the other lattice it says nothing; a pair that jumps is averaged with it."""
    asked: list[tuple[bool, list[str]]] = []

    def simulated(_: object, items: list[SimpleNamespace], __: object, *, finest: bool = False) -> list[Array]:
        asked.append((finest, [item.ids[0] for item in items]))
        return [np.full(3, np.nan if item.ids[0] != "runs" else 1.0) for item in items]

    monkeypatch.setattr(refit_runs, "changes", simulated)
    items = [SimpleNamespace(ids=(name,)) for name in ("lost", "runs", "jumps")]
    fine, finer = on_both(None, items, {}, wanted={("jumps",)})
    assert asked == [(False, ["lost", "runs", "jumps"]), (True, ["runs", "jumps"])]
    assert [np.isfinite(curve).all() for curve in finer] == [False, True, False]
    assert len(fine) == len(finer) == 3


def test_pairs_that_are_not_judged_could_not_have_been_among_the_best() -> None:
    """The bound is above the evidence of every pair, near it for a good one; the best are those of all pairs judged."""
    points, rng = measured(), np.random.default_rng(3)
    u = points.displacement / 40.0
    curves = (u, u**3, np.sin(9.0 * u), np.exp(-4.0 * u), np.where(points.of(EDGE), u, 0.0))
    tables = {name: toy(name, curve) for name, curve in zip("abcde", curves, strict=True)}
    bench = workbench(2.0 * curves[0] + 3.0 * curves[3] + 0.1 * rng.standard_normal(160))
    form = np.cos(3.0 * u)[:, None]
    pairs = list(itertools.combinations(tables.values(), 2))
    sample = facing(bench, pairs[0]).mean_sample
    found = [judge((sample,), pair, form).log_evidence for pair in pairs]
    most = [bound(sample, pair, form) for pair in pairs]
    assert all(a < b for a, b in zip(found, most, strict=True))
    assert most[int(np.argmax(found))] - max(found) < 15.0
    order = np.argsort([-value for value in found])[:2]
    assert [item.ids for item in rank_pairs(bench, tables, form, keep=2)] == [
        tuple(table.id for table in pairs[i]) for i in order
    ]


def test_both_free_edges_are_wrong_by_as_much_inwards() -> None:
    """Their weft coordinates move against each other, so what is open in them has opposite signs."""
    points = measured()
    weft = replace(points.series[2], quantity="weft")
    sides = np.where(points.warp0 > 20.0, -np.inf, points.weft0)
    two = replace(points, series=(*points.series[:2], weft), warp0=np.where(points.of(EDGE), 20.0, np.nan), weft0=sides)
    found = left_open(two, np.ones(160), [replace(RotationalShear.card, undetermined=())], change=np.zeros(160))
    np.testing.assert_allclose(found[80:120, 120:], -found[80:120, 80:120])
    assert found[80, 80] == pytest.approx(1.0)


LOOSE = (Undetermined(EDGE, "height", 1.0),)


def test_the_ordinary_node_is_next_to_the_example_and_never_the_neutral_one() -> None:
    card = RotationalShear.card
    grid = ParameterGrid(card, axes_of(card))
    at = grid.ordinary
    assert grid.parameters([grid.axes[0].nodes[at[0]]])["share"] == pytest.approx(card.example.parameters["share"])
    tiny = replace(card, example=replace(card.example, parameters={"share": 1e-6}))
    grid = ParameterGrid(tiny, axes_of(tiny))
    assert grid.ordinary[0] != grid.axes[0].neutral


@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_every_effect_of_the_library_is_simulated_near_its_example(name: str) -> None:
    """The doubt about an effect is taken at the node next to the example: the shape is there, the size within 2.5."""
    card = EFFECTS[name].card
    grid = ParameterGrid(card, axes_of(card))
    found = grid.parameters([axis.nodes[i] for axis, i in zip(grid.axes, grid.ordinary, strict=True)])
    first = card.parameters[0].name
    assert 0.4 < abs(found[first] / card.example.parameters[first]) < 2.5
