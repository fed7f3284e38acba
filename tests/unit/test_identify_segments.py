"""Parts of a curve: loading, unloading, cycles, failure, preload, slack."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.identify.coupon import pull
from etextile.identify.curves import TensileCurve
from etextile.identify.fit import fit_direction
from etextile.identify.segments import point_noise, split
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


LAW = PowerLaw(3000.0, 0.2, 9960.0, 1.5)
RATIO = 3.62
STRAIN, STRESS = pull(LAW, 0.12, area_ratio=RATIO, loading=100, unloading=40)
PEAK = float(STRESS.max())


def noisy(stress: Array, seed: int = 1) -> Array:
    return stress + np.random.default_rng(seed).normal(0.0, 0.01 * PEAK, len(stress))


def test_loading_and_unloading_are_told_apart_under_noise() -> None:
    parts = split(TensileCurve.of("a", STRAIN, noisy(STRESS)))
    assert len(parts.strain) == 101
    assert len(parts.unloading_strain) == 41
    assert parts.unloads
    assert not parts.failed
    assert parts.preload == 0.0
    assert parts.noise == pytest.approx(0.01 * PEAK, rel=0.35)


@pytest.mark.parametrize("jitter", [0.0, 1e-5, 1e-4])
def test_thousands_of_points_and_jitter_of_the_strain_do_not_hide_the_unloading(jitter: float) -> None:
    strain, stress = pull(LAW, 0.12, area_ratio=RATIO, loading=6000, unloading=4000)
    strain = strain + np.random.default_rng(2).normal(0.0, jitter, len(strain))
    parts = split(TensileCurve.of("a", strain, noisy(stress)))
    assert len(parts.strain) == pytest.approx(6000, abs=25)
    assert len(parts.unloading_strain) == pytest.approx(4000, abs=25)


def test_loading_only_has_no_unloading() -> None:
    assert not split(TensileCurve.of("a", STRAIN[:101], noisy(STRESS[:101]))).unloads


def test_reloading_is_left_out_and_the_last_unloading_is_used() -> None:
    first, stress = pull(LAW, 0.06, area_ratio=RATIO, loading=50, unloading=20)
    strain = np.concatenate([first, first[50:-1][::-1], STRAIN[51:]])
    stress = np.concatenate([stress, stress[50:-1][::-1], STRESS[51:]])
    parts = split(TensileCurve.of("a", strain, noisy(stress)))
    np.testing.assert_allclose(parts.strain, STRAIN[:101], atol=1e-12)
    assert parts.unloading_strain[0] == pytest.approx(0.12)
    assert "2 unloadings" in parts.notes[0]


def test_a_failure_is_cut_off_at_its_start() -> None:
    strain = np.concatenate([STRAIN[:101], np.linspace(0.1212, 0.15, 25)])
    stress = np.concatenate([STRESS[:101], PEAK * np.exp(-(((strain[101:] - 0.12) / 0.01) ** 2))])
    parts = split(TensileCurve.of("a", strain, noisy(stress)))
    assert parts.failed
    assert parts.strain[-1] == pytest.approx(0.12, abs=0.006)
    assert "start of failure" in parts.notes[0]


def test_softening_before_the_peak_belongs_to_the_failure() -> None:
    strain = np.linspace(0.0, 0.16, 161)
    intact, _ = STRAIN[:101], STRESS[:101]
    rise = np.interp(np.minimum(strain, 0.12), intact, STRESS[:101])
    late = np.maximum(strain - 0.12, 0.0)
    stress = rise + 380.0 * late - 9500.0 * late**2 - 6e5 * np.maximum(late - 0.022, 0.0) ** 2
    parts = split(TensileCurve.of("a", strain, stress))
    assert parts.failed
    peak = strain[int(np.argmax(stress))]
    assert parts.strain[-1] < peak - 0.004
    assert parts.strain[-1] > 0.115


def test_an_unloading_before_the_failure_still_gives_the_modulus() -> None:
    reload = np.linspace(STRAIN[-1], 0.12, 41)[1:]
    broken = np.linspace(0.121, 0.14, 20)
    strain = np.concatenate([STRAIN, reload, broken])
    stress = np.concatenate([STRESS, STRESS[101:][::-1], [PEAK], PEAK * np.linspace(0.9, 0.1, 19)])
    parts = split(TensileCurve.of("a", strain, stress))
    assert parts.failed
    assert parts.unloads


def test_a_preload_stands_out_of_the_noise_and_zero_does_not() -> None:
    start = int(np.argmax(STRESS > 0.1 * PEAK))
    shifted = split(TensileCurve.of("a", STRAIN[start:] - STRAIN[start], noisy(STRESS[start:])))
    assert shifted.preload == pytest.approx(0.1 * PEAK, rel=0.4)


def test_slack_can_be_no_longer_than_the_quiet_start() -> None:
    quiet = np.linspace(0.0, 0.02, 18)[:-1]
    strain = np.concatenate([quiet, STRAIN + 0.02])
    stress = np.concatenate([np.zeros(17), STRESS])
    assert 0.02 < split(TensileCurve.of("a", strain, noisy(stress))).slack_limit < 0.04


def test_noise_is_measured_about_any_smooth_curve() -> None:
    x = np.linspace(0.0, 1.0, 2000)
    noise = np.random.default_rng(4).normal(0.0, 0.02, 2000)
    assert point_noise(np.sin(6.0 * x) + x**3 + noise) == pytest.approx(0.02, rel=0.08)
    assert point_noise(x**3) < 1e-8


def held(at: int, points: int, share: float) -> tuple[Array, Array]:
    """Return the curve with the crosshead standing still after some points while a share of the stress relaxes."""
    rest = STRESS[at] * (1.0 - share * (1.0 - np.exp(-np.linspace(0.0, 4.0, points))))
    back = np.linspace(rest[-1], STRESS[at + 4], 5)[1:]
    strain = np.concatenate([STRAIN[: at + 1], np.full(points, STRAIN[at]), STRAIN[at + 1 :]])
    stress = np.concatenate([STRESS[: at + 1], rest, back, STRESS[at + 5 :]])
    return strain, stress


@pytest.mark.parametrize(("at", "share"), [(80, 0.1), (50, 0.3), (90, 0.15)])
def test_a_pause_is_no_failure_and_its_relaxed_points_are_left_out(at: int, share: float) -> None:
    strain, stress = held(at, 20, share)
    parts = split(TensileCurve.of("a", strain, stress + np.random.default_rng(4).normal(0.0, 0.05, len(stress))))
    assert not parts.failed
    assert parts.strain[-1] == pytest.approx(0.12)
    assert len(parts.unloading_strain) == 41
    assert "paused" in parts.notes[0]
    law = np.interp(parts.strain, STRAIN[:101], STRESS[:101])
    # the way back to the curve passes the earlier peak before it gets there: 4 of 100 steps of loading
    assert np.abs(parts.stress - law).max() < 0.045 * PEAK


@pytest.mark.parametrize("slow", [True, False])
def test_what_follows_a_break_is_left_out_and_said(slow: bool) -> None:
    after = np.concatenate([[0.1205, 0.121, 0.122] if slow else [0.1201], np.linspace(0.1195, 0.0, 60)])
    rest = np.concatenate([[0.25 * PEAK, 0.05 * PEAK, 0.0] if slow else [0.0], np.zeros(60)])
    parts = split(TensileCurve.of("a", np.r_[STRAIN[:101], after], noisy(np.r_[STRESS[:101], rest])))
    assert parts.failed
    assert not parts.unloads
    assert parts.strain[-1] == pytest.approx(0.12, abs=0.006)
    assert any("the specimen broke at strain 0.1" in note and "left out" in note for note in parts.notes)


def test_jitter_as_of_a_crosshead_is_no_unloading_and_shuffled_rows_are_refused() -> None:
    rng = np.random.default_rng(5)
    strain = STRAIN + rng.normal(0.0, 30e-3 / 60.0, len(STRAIN))
    parts = split(TensileCurve.of("a", strain, noisy(STRESS)))
    assert len(parts.strain) == pytest.approx(101, abs=4)
    assert len(parts.unloading_strain) == pytest.approx(41, abs=4)
    order = rng.permutation(len(STRAIN))
    with pytest.raises(BadInput, match="rows must be in time order"):
        split(TensileCurve.of("a", STRAIN[order], STRESS[order]))


def test_slack_is_searched_from_the_top_so_that_a_bump_is_no_begin_of_loading() -> None:
    strain, stress = np.r_[np.linspace(0.0, 0.02, 40)[:-1], 0.02 + STRAIN], np.r_[np.zeros(39), STRESS]
    stress[10:13] = 0.05 * PEAK
    assert split(TensileCurve.of("a", strain, stress)).slack_limit > 0.02


def test_a_pause_at_the_top_is_no_failure_and_the_unloading_behind_it_gives_the_modulus() -> None:
    relaxed = PEAK * (1.0 - 0.12 * (1.0 - np.exp(-np.linspace(0.1, 4.0, 40))))
    back = np.maximum(STRESS[101:] - 0.12 * PEAK, 0.0)
    strain = np.r_[STRAIN[:101], np.full(40, 0.12), STRAIN[101:]]
    parts = split(TensileCurve.of("a", strain, np.r_[STRESS[:101], relaxed, back]))
    assert not parts.failed
    assert parts.unloads
    assert "paused at strain 0.1200" in parts.notes[0]
    assert parts.stress.max() == pytest.approx(PEAK)
    found = fit_direction([TensileCurve.of("a", strain, np.r_[STRESS[:101], relaxed, back])], RATIO)
    assert abs(found.law.E / LAW.E - 1.0) < 0.05


@pytest.mark.parametrize(("at", "share"), [(80, 0.02), (30, 0.15)])
def test_a_short_or_early_pause_shows_by_the_strain_that_stands_still(at: int, share: float) -> None:
    strain, stress = held(at, 30, share)
    parts = split(TensileCurve.of("a", strain, stress + np.random.default_rng(4).normal(0.0, 0.02, len(stress))))
    assert "paused" in parts.notes[0]
    assert np.count_nonzero(parts.strain == STRAIN[at]) < 10


def test_a_strain_that_jitters_only_while_it_is_held_is_no_disorder() -> None:
    strain, stress = held(80, 40, 0.1)
    strain[81:121] += np.random.default_rng(6).normal(0.0, 3e-5, 40)
    assert not split(TensileCurve.of("a", strain, stress)).failed


@pytest.mark.parametrize("value", [0.0, 5.0 * PEAK, -PEAK])
def test_a_single_reading_far_from_both_neighbours_is_left_out_and_said(value: float) -> None:
    stress = noisy(STRESS)
    stress[50] = value
    parts = split(TensileCurve.of("a", STRAIN, stress))
    assert parts.notes == ("a single reading far from the neighbours left out (line 51)",)
    assert len(parts.strain) == 100
    assert parts.unloads
    assert parts.left_out[0][1].tolist() == [51]
