"""Modulus and hardening: exact without noise, the paper's bias as computed, datum, relaxation, missing unloading."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.identify.coupon import loading_curve, pull
from etextile.identify.curves import TensileCurve
from etextile.identify.fit import NamedLaw, fit_direction
from etextile.identify.modulus import fit_modulus
from etextile.identify.segments import split
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


LAWS = {
    "warp": (PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.0561 / 0.0155, 0.12),
    "weft": (PowerLaw(4500.0, 0.2, 4230.0, 1.1), 0.0997 / 0.0155, 0.12),
    "diagonal": (PowerLaw(1500.0, 0.2, 1550.0, 2.2), 0.0489 / 0.0155, 0.45),
}
LAW, RATIO, TOP = LAWS["warp"]
STRAIN, STRESS = pull(LAW, TOP, area_ratio=RATIO)
PEAK = float(STRESS.max())


def curve(strain: Array, stress: Array, *, noise: float = 0.0, seed: int = 0, name: str = "a") -> TensileCurve:
    return TensileCurve.of(name, strain, stress + np.random.default_rng(seed).normal(0.0, noise * PEAK, len(stress)))


@pytest.mark.parametrize("family", LAWS)
def test_a_curve_of_the_law_returns_the_law(family: str) -> None:
    law, ratio, top = LAWS[family]
    fit = fit_direction([curve(*pull(law, top, area_ratio=ratio))], ratio)
    found = (fit.law.E, fit.law.H, fit.law.n)
    np.testing.assert_allclose(found, (law.E, law.H, law.n), rtol=1e-5)
    assert fit.strain_range == pytest.approx((0.0, top))
    assert fit.residual < 1e-5


@pytest.mark.parametrize("family", LAWS)
def test_counting_all_strain_as_plastic_overrates_the_modulus_by_the_elastic_strain(family: str) -> None:
    """lambda_p = lambda instead of exp(eps_p): the factor is exp(sigma / E) at the turning point, exactly."""
    law, ratio, top = LAWS[family]
    part = split(curve(*pull(law, top, area_ratio=ratio)))
    paper, exact = (fit_modulus(part, ratio, procedure=way) for way in ("paper", "consistent"))
    stress = float(loading_curve(law, np.log1p(np.array([top]))).true_stress[0])
    assert paper is not None
    assert exact is not None
    assert pytest.approx(np.exp(stress / law.E), rel=1e-6) == paper.E / law.E
    assert pytest.approx(law.E, rel=1e-6) == exact.E
    assert 1.04 < paper.E / law.E < 1.10


@pytest.mark.parametrize("family", LAWS)
def test_the_papers_bias_is_what_the_documentation_says(family: str) -> None:
    law, ratio, top = LAWS[family]
    fit = fit_direction([curve(*pull(law, top, area_ratio=ratio))], ratio, procedure="paper")
    assert 0.02 < fit.law.n / law.n - 1.0 < 0.05
    assert 0.10 < fit.law.H / law.H - 1.0 < 0.22


def test_the_slope_comes_from_the_top_two_fifths_in_stress() -> None:
    """A lower part of unloading that bends off does not touch the modulus."""
    bent = STRESS.copy()
    low = (np.arange(len(bent)) > 100) & (bent < 0.55 * PEAK)
    bent[low] *= 0.5
    for way in ("paper", "consistent"):
        plain, other = (fit_modulus(split(curve(STRAIN, s)), RATIO, procedure=way) for s in (STRESS, bent))
        assert plain is not None
        assert other is not None
        assert pytest.approx(plain.E, rel=1e-9) == other.E
        assert other.stress.min() >= 0.6 * PEAK * RATIO * (1.0 - 1e-9)


def test_a_stress_drop_at_the_turning_point_is_named_and_does_not_steepen_the_line() -> None:
    dropped = STRESS.copy()
    dropped[101:] -= 0.05 * PEAK
    fit = fit_direction([curve(STRAIN, dropped, noise=0.002)], RATIO)
    assert any("at the start of unloading" in note for note in fit.notes)
    assert pytest.approx(LAW.E, rel=0.06) == fit.law.E


def test_slack_is_taken_out_where_the_start_is_quiet() -> None:
    slack = 0.02
    strain = np.concatenate([np.linspace(0.0, slack, 18)[:-1], (1.0 + slack) * (1.0 + STRAIN) - 1.0])
    stress = np.concatenate([np.zeros(17), STRESS])
    fit = fit_direction([curve(strain, stress, noise=0.005)], RATIO)
    assert fit.specimens[0].hardening.datum == pytest.approx(np.log1p(slack), abs=0.0015)
    assert fit.law.n == pytest.approx(LAW.n, rel=0.05)
    assert any("slack" in note for note in fit.notes)


def test_a_clean_start_is_left_alone() -> None:
    moved = [
        fit_direction([curve(STRAIN, STRESS, noise=0.01, seed=seed)], RATIO).specimens[0].hardening.datum
        for seed in range(20)
    ]
    assert np.count_nonzero(moved) <= 1


def test_a_preload_moves_the_datum_to_where_the_law_has_that_stress() -> None:
    start = 15
    strain = (1.0 + STRAIN[start:]) / (1.0 + STRAIN[start]) - 1.0
    fit = fit_direction([curve(strain, STRESS[start:], noise=0.002)], RATIO)
    assert fit.specimens[0].hardening.datum == pytest.approx(-np.log1p(STRAIN[start]), abs=0.002)
    assert fit.law.n == pytest.approx(LAW.n, rel=0.06)


def test_without_unloading_a_fabric_of_the_same_weave_lends_its_modulus() -> None:
    named = NamedLaw("estimated_mid", LAW, RATIO, 0.12)
    fit = fit_direction([curve(STRAIN[:101], STRESS[:101])], RATIO, named=named)
    assert fit.modulus_source == "unidentified (no unloading measured), taken from estimated_mid"
    np.testing.assert_allclose((fit.law.E, fit.law.H, fit.law.n), (LAW.E, LAW.H, LAW.n), rtol=1e-5)
    assert fit.covariance[0, 0] < 1e-12


@pytest.mark.parametrize("scale", [1.0, 5.0])
def test_a_modulus_below_the_slope_of_loading_is_not_taken_over(scale: float) -> None:
    """Another weave, or a stiffer curve: the ratio of modulus to loading slope is lent instead."""
    named = NamedLaw("soft", LAW, RATIO * (2.0 if scale == 1.0 else 1.0), 0.12)
    fit = fit_direction([curve(STRAIN[:101], scale * STRESS[:101])], RATIO, named=named)
    assert "times the steepest slope of loading, the ratio in soft" in fit.modulus_source
    assert pytest.approx(scale * LAW.E, rel=0.02) == fit.law.E


def test_without_unloading_and_without_a_named_law_nothing_is_made_up() -> None:
    with pytest.raises(BadInput, match="no specimen unloads"):
        fit_direction([curve(STRAIN[:101], STRESS[:101])], RATIO)


def test_a_specimen_without_unloading_uses_the_modulus_of_the_others() -> None:
    whole = [curve(STRAIN, STRESS, noise=0.005, seed=seed, name=f"s{seed}") for seed in (1, 2)]
    loading = curve(STRAIN[:101], STRESS[:101], noise=0.005, seed=3, name="s3")
    fit = fit_direction([*whole, loading], RATIO)
    assert not fit.modulus_source
    assert [item.modulus is None for item in fit.specimens] == [False, False, True]
    assert fit.law.n == pytest.approx(LAW.n, rel=0.02)


def test_an_elastic_curve_has_no_hardening_to_fit() -> None:
    up = np.linspace(0.0, 0.1, 40)
    strain = np.concatenate([up, up[:-1][::-1]])
    with pytest.raises(BadInput, match="leaves no plastic strain"):
        fit_direction([TensileCurve.of("a", strain, 300.0 * np.log1p(strain))], RATIO)


def test_the_outlier_is_named_and_left_out_unless_kept() -> None:
    gains = (1.0, 1.01, 0.8, 0.99)
    curves = [curve(STRAIN, g * STRESS, noise=0.01, seed=i, name=f"s{i}") for i, g in enumerate(gains)]
    fit = fit_direction(curves, RATIO)
    assert fit.scatter.outlier == (False, False, True, False)
    assert [item.name for item in fit.specimens] == ["s0", "s1", "s3"]
    assert any(note.startswith("outlier s2: 20% below") for note in fit.notes)
    assert len(fit_direction(curves, RATIO, keep_outliers=True).specimens) == 4


def test_two_specimens_that_differ_are_both_kept_and_said_to_differ() -> None:
    curves = [curve(STRAIN, g * STRESS, noise=0.01, seed=i, name=f"s{i}") for i, g in enumerate((1.0, 0.8))]
    fit = fit_direction(curves, RATIO)
    assert len(fit.specimens) == 2
    assert any("a third specimen would tell" in note for note in fit.notes)


@pytest.mark.parametrize(("first", "noise"), [(8, 0.0005), (15, 0.001), (12, 0.003)])
def test_a_curve_zeroed_at_a_preload_is_noticed_and_returns_the_law(first: int, noise: float) -> None:
    """Strain and stress start at zero although the specimen carried already: H came out a third too low."""
    strain, stress = STRAIN[first:] - STRAIN[first], STRESS[first:] - STRESS[first]
    fit = fit_direction([curve(strain, stress, noise=noise, seed=first)], RATIO)
    spread = float(np.sqrt(fit.covariance[1, 1]))
    assert any("set to zero at a preload" in note for note in fit.notes)
    assert abs(np.log(fit.law.H / LAW.H)) < 0.05 + 3.0 * spread
    assert pytest.approx(LAW.E, rel=0.05) == fit.law.E


def test_equal_specimens_keep_the_datum_of_their_strain() -> None:
    """One of twelve was shifted by 1.6 % of strain: a first point that stood out by chance."""
    specimens = [curve(STRAIN, STRESS, noise=0.004, seed=seed, name=f"s{seed}") for seed in range(12)]
    specimens[5].stress[:3] += 5.0 * 0.004 * PEAK
    fit = fit_direction(specimens, RATIO, keep_outliers=True)
    assert [item.hardening.datum for item in fit.specimens] == [0.0] * 12


def test_a_pause_leaves_the_modulus_where_it_is() -> None:
    """Held at 10 % strain, 10 % of the stress relaxes, on to 12 % and unloaded."""
    at = int(np.searchsorted(STRAIN[: int(np.argmax(STRAIN))], 0.1))
    rest = STRESS[at] * (0.9 + 0.1 * np.exp(-np.linspace(0.0, 4.0, 20)))
    strain = np.r_[STRAIN[: at + 1], np.full(20, STRAIN[at]), STRAIN[at + 2 :]]
    stress = np.r_[STRESS[: at + 1], rest, STRESS[at + 2 :]]
    fit = fit_direction([curve(strain, stress, noise=0.002)], RATIO)
    assert pytest.approx(LAW.E, rel=0.05) == fit.law.E
