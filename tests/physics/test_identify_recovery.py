"""Parameters come back from curves made with known ones: 1 % noise, two specimens, honest 95 % intervals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from etextile.identify.coupon import pull
from etextile.identify.curves import TensileCurve
from etextile.identify.fit import DirectionFit, fit_direction
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


LAWS = {
    "warp": (PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.0561 / 0.0155, 0.12),
    "weft": (PowerLaw(4500.0, 0.2, 4230.0, 1.1), 0.0997 / 0.0155, 0.12),
    "diagonal": (PowerLaw(1500.0, 0.2, 1550.0, 2.2), 0.0489 / 0.0155, 0.45),
}
NOISE = 0.01
LIMITS = {"E": 0.05, "H": 0.08, "n": 0.02}


@dataclass(frozen=True)
class Recovery:
    """Relative errors (repeats, 3) of E, H, n and whether the 95 % interval held the truth (repeats, 3)."""

    errors: Array
    held: Array

    @property
    def spread(self) -> Array:
        return np.asarray(self.errors.std(axis=0))


def specimens(
    family: str, rng: np.random.Generator, *, count: int, scatter: float, e0: float, points: tuple[int, int]
) -> tuple[list[TensileCurve], float]:
    law, ratio, top = LAWS[family]
    curves = []
    for i in range(count):
        own = replace(law, E=law.E * np.exp(scatter * rng.normal()), H=law.H * np.exp(scatter * rng.normal()), e0=e0)
        strain, stress = pull(own, top, area_ratio=ratio, loading=points[0], unloading=points[1])
        curves.append(TensileCurve.of(f"s{i}", strain, stress + rng.normal(0.0, NOISE * stress.max(), len(stress))))
    return curves, ratio


def recover(
    family: str, *, repeats: int, count: int = 2, scatter: float = 0.0, e0: float = 1e-3,
    points: tuple[int, int] = (100, 40), seed: int = 0,
) -> Recovery:  # fmt: skip
    rng = np.random.default_rng(seed)
    law = LAWS[family][0]
    errors, held = np.empty((repeats, 3)), np.empty((repeats, 3))
    for i in range(repeats):
        curves, ratio = specimens(family, rng, count=count, scatter=scatter, e0=e0, points=points)
        fit = fit_direction(curves, ratio)
        errors[i], held[i] = _judge(fit, law)
    return Recovery(errors, held)


def _judge(fit: DirectionFit, law: PowerLaw) -> tuple[Array, Array]:
    found = np.array([fit.law.E, fit.law.H, fit.law.n])
    truth = np.array([law.E, law.H, law.n])
    std = np.sqrt(np.diag(fit.covariance)) * [found[0], found[1], 1.0]
    return found / truth - 1.0, np.abs(found - truth) <= 1.96 * std


def check(found: Recovery) -> None:
    """Hold the targets: nearly all repeats within the limits, no bias (3.5 errors of the mean), intervals that hold."""
    within = np.abs(found.errors) < list(LIMITS.values())
    assert within.mean(axis=0).min() >= 0.97
    of_the_mean = found.spread / np.sqrt(len(found.errors))
    assert np.all(np.abs(found.errors.mean(axis=0)) < 3.5 * of_the_mean + 0.002)
    assert found.held.mean(axis=0).min() >= 0.90


def test_the_paper_procedure_misses_the_targets_by_its_bias_alone() -> None:
    """Why the consistent procedure is the default: without any noise E is off by 5 %, H by more than 8 %."""
    law, ratio, top = LAWS["warp"]
    strain, stress = pull(law, top, area_ratio=ratio)
    curve = TensileCurve.of("a", strain, stress)
    paper, consistent = (fit_direction([curve], ratio, procedure=way).law for way in ("paper", "consistent"))
    assert LIMITS["E"] < paper.E / law.E - 1.0
    assert LIMITS["H"] < paper.H / law.H - 1.0
    assert pytest.approx(law.H, rel=1e-5) == consistent.H


@pytest.mark.parametrize(
    ("family", "repeats"), [("warp", 20), *(pytest.param(name, 200, marks=pytest.mark.slow) for name in LAWS)]
)
def test_repeats_hold_the_targets(family: str, repeats: int) -> None:
    check(recover(family, repeats=repeats, seed=1))


@pytest.mark.slow
@pytest.mark.parametrize("family", LAWS)
def test_coarse_files_and_a_sharp_yield_point_do_too(family: str) -> None:
    """60 + 20 points per specimen, and yield stress without build-up (e0 -> 0) as in the paper."""
    found = recover(family, repeats=200, points=(60, 20), e0=1e-9, seed=2)
    assert (np.abs(found.errors) < list(LIMITS.values())).mean(axis=0).min() >= 0.95
    assert found.held.mean(axis=0).min() >= 0.90


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3])
def test_intervals_stay_honest_when_specimens_scatter(count: int) -> None:
    """2 % standard deviation of E and of H from specimen to specimen on top of the noise."""
    assert recover("warp", repeats=200, count=count, scatter=0.02, seed=3).held.mean(axis=0).min() >= 0.90
