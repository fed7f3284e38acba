"""Linear-Gaussian algebra of the diagnosis against brute force, evidence of a linear toy against its closed form."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from etextile.diagnose.decide.rank import rank_pairs, rank_threes
from etextile.diagnose.infer.fit import ScatterSample, judge
from etextile.diagnose.infer.gauss import Whitener, log_evidence, log_sum, smooth_modes
from etextile.diagnose.predict.table import EffectTable, ParameterAxis, ParameterGrid
from etextile.effects.base import Card, Example, Parameter


def covariance(size: int, rng: np.random.Generator) -> np.ndarray:
    root = rng.normal(size=(size, size))
    return root @ root.T + 0.5 * np.eye(size)


def linear_table(direction: np.ndarray, *, low: float = 0.0, high: float = 4.0, name: str = "toy") -> EffectTable:
    """An effect whose change is its parameter times `direction`: two nodes say it all."""
    parameter = Parameter("size", "", low, high, "the size")
    card = Card(name, "a toy", (parameter,), Example({"size": 1.0}))
    axis = ParameterAxis(parameter, np.array([low, high]), 0)
    return EffectTable(
        ParameterGrid(card, (axis,)), direction[:, None], np.array([[low, high]]), np.array([True, True])
    )


def test_whitening_leaves_unit_covariance_and_the_right_determinant() -> None:
    rng = np.random.default_rng(1)
    c = covariance(7, rng)
    whiten = Whitener.of(c)
    np.testing.assert_allclose(whiten(whiten(c).T), np.eye(7), atol=1e-8)
    assert whiten.log_determinant == pytest.approx(np.linalg.slogdet(c)[1], abs=1e-7)


def test_evidence_with_freedom_is_the_density_with_the_freedom_in_the_covariance() -> None:
    """The density p(r) under C + H H^T by Woodbury's identity equals the density by brute force."""
    rng = np.random.default_rng(2)
    c, freedom, residual = covariance(9, rng), rng.normal(size=(9, 3)), rng.normal(size=9)
    whiten = Whitener.of(c)
    h, r = whiten(freedom), whiten(residual)
    found = log_evidence(np.vstack([h.T, r])[None])[0]
    common = -0.5 * (whiten.log_determinant + 9 * np.log(2 * np.pi))
    expected = multivariate_normal(np.zeros(9), c + freedom @ freedom.T).logpdf(residual)
    assert found + common == pytest.approx(expected, abs=1e-6)


def test_log_sum_does_not_overflow_and_ignores_what_is_impossible() -> None:
    assert log_sum(np.array([1000.0, 1000.0])) == pytest.approx(1000.0 + np.log(2.0))
    assert log_sum(np.array([-np.inf, 3.0])) == pytest.approx(3.0)
    assert log_sum(np.array([[-np.inf, -np.inf], [0.0, 0.0]]), axis=1)[0] == -np.inf


def test_smooth_modes_give_the_covariance_back() -> None:
    at = np.linspace(0.0, 1.0, 40)
    kernel = np.exp(-0.5 * ((at[:, None] - at[None, :]) / 0.3) ** 2)
    modes = smooth_modes(kernel, share=0.9999)
    assert modes.shape[1] < 12
    np.testing.assert_allclose(modes @ modes.T, kernel, atol=0.01)


def test_evidence_of_a_linear_effect_is_the_integral_in_closed_form() -> None:
    """A uniform amplitude a in [0, 4] on the direction v, unit noise:

    p(r) = N(r; 0, 1) (1/4) sqrt(2 pi / v.v) exp(z^2 / 2) [Phi(b - z) - Phi(-z)], z = v.r / |v|, b = 4 |v|.
    """
    rng = np.random.default_rng(3)
    v = rng.normal(size=12)
    r = 1.7 * v + rng.normal(size=12)
    sample = ScatterSample(Whitener(np.eye(12)), r, 0.0)
    found = judge((sample,), (linear_table(v),), np.zeros((12, 1)))
    size = np.linalg.norm(v)
    z = float(v @ r) / size
    expected = -0.5 * r @ r + np.log(0.25 * np.sqrt(2 * np.pi) / size) + 0.5 * z**2
    expected += np.log(norm.cdf(4 * size - z) - norm.cdf(-z))
    assert found.log_evidence == pytest.approx(expected, abs=0.02)
    middle, low, high = found.interval(0)
    assert middle == pytest.approx(z / size, abs=0.02)
    assert high - low == pytest.approx(2 * 1.96 / size, rel=0.1)


def test_wide_ranges_cost_what_they_should() -> None:
    """The same fit within a range ten times as wide is ten times less likely (Occam)."""
    rng = np.random.default_rng(4)
    v = rng.normal(size=30)
    sample = ScatterSample(Whitener(np.eye(30)), 1.5 * v + rng.normal(size=30), 0.0)
    form = np.zeros((30, 1))
    near = judge((sample,), (linear_table(v, high=4.0),), form).log_evidence
    wide = judge((sample,), (linear_table(v, high=40.0),), form).log_evidence
    assert near - wide == pytest.approx(np.log(10.0), abs=0.05)


def test_a_known_form_counts_more_than_an_uncertain_one_when_it_is_right() -> None:
    rng = np.random.default_rng(5)
    v = np.linspace(0.0, 3.0, 30)
    sample = ScatterSample(Whitener(np.eye(30)), 2.0 * v + rng.normal(size=30), 0.0)
    form = np.cos(np.linspace(0.0, 6.0, 30))[:, None]
    table = linear_table(v)
    exact = judge((sample,), (table,), 1e-5 * form).log_evidence
    loose = judge((sample,), (table,), 5.0 * form).log_evidence
    assert exact > loose
    bent = ScatterSample(sample.whiten, 2.0 * v * (1.0 + 0.4 * form[:, 0]) + rng.normal(size=30), 0.0)
    assert judge((bent,), (table,), 5.0 * form).log_evidence > judge((bent,), (table,), 1e-5 * form).log_evidence


def test_a_third_effect_is_found_beside_a_pair_where_there_is_one_and_costs_evidence_where_there_is_none() -> None:
    rng = np.random.default_rng(8)
    directions = {name: rng.normal(size=40) for name in "abcde"}
    tables = {name: linear_table(3.0 * v, name=name) for name, v in directions.items()}
    noise, form = rng.normal(size=40), np.zeros((40, 1))
    for hidden, third in (("ab", False), ("abd", True)):
        residual = noise + sum(6.0 * directions[name] for name in hidden)
        sample = ScatterSample(Whitener(np.eye(40)), residual, 0.0)
        bench = SimpleNamespace(samples=(sample,), mean_sample=sample)
        pairs = rank_pairs(bench, tables, form)
        pair = next(item for item in pairs if set(item.ids) == {"a", "b"})
        best = max(rank_threes(bench, ("a", "b"), tables, form), key=lambda item: item.score)
        assert bool(best.score > pair.score) is third
        if third:
            assert set(best.ids) == {"a", "b", "d"}
            assert best.evidence.mean == pytest.approx(np.full(3, 2.0), abs=0.5)
