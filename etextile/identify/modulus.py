r"""Young's modulus of a truss family from the unloading of one specimen (Beex et al., section 4.2).

Unloading is a straight line in Hencky strain, s = a + k (eps - eps_0), from the turning point eps_0 on. The slope is
taken on the top 40 % in stress. True stress is s lambda_p, so E = k lambda_p. The two procedures differ in lambda_p:

* `paper`: all strain at the turning point counts as plastic, lambda_p = exp(eps_0). This overrates E by the elastic
  strain there, exp(a / k) - 1: 5 to 9 % for the estimated fabrics.
* `consistent`: the elastic strain at the turning point is a / k, so lambda_p = exp(eps_0 - a / k) exactly. The line is
  also tied to the stress at the end of loading, unless the two do not meet (stress relaxation at the turning point).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from etextile.errors import BadInput
from etextile.identify.segments import MIN_UNLOADING, Segments
from etextile.identify.statistics import residual_variance
from etextile.importers.records import JITTER
from etextile.types import Array


Procedure = Literal["consistent", "paper"]
# Share of the stress, counted from the top, on which the slope is taken (paper, section 4.2).
TOP = 0.4
# The line is tied to the end of loading unless the two differ by more standard deviations than this.
TIE_LIMIT = 2.5
# Share of the loading strain before the turning point from which the stress there is estimated.
END_OF_LOADING = 0.25


@dataclass(frozen=True)
class ModulusFit:
    """Modulus of one specimen: `E` in MPa (true stress of the truss), `variance` of ln E.

    `line`: (stress at the turning point, slope) in engineering truss stress over Hencky strain; `turning`: Hencky
    strain of the turning point; `hencky`, `stress` (k,): the points used; `plastic_stretch`: lambda_p.
    """

    E: float
    variance: float
    line: tuple[float, float]
    turning: float
    plastic_stretch: float
    hencky: Array
    stress: Array
    notes: tuple[str, ...] = ()


def fit_modulus(segments: Segments, area_ratio: float, *, procedure: Procedure = "consistent") -> ModulusFit | None:
    """Return the modulus from the unloading of one specimen, or None when there is too little of it.

    `area_ratio` is A_n / A_0. Raises BadInput when the stress does not fall with the strain.
    """
    if not segments.unloads:
        return None
    hencky, stress = _unloading(segments, area_ratio)
    turning = float(hencky.max())
    top = _top_part(hencky, stress, turning)
    if np.count_nonzero(top) < MIN_UNLOADING:
        return None
    x, y = hencky[top] - turning, stress[top]
    line, covariance = _straight_line(x, y, area_ratio * segments.noise)
    notes: tuple[str, ...] = ()
    if procedure == "consistent":
        line, covariance, notes = _tie(line, covariance, segments, turning, area_ratio=area_ratio)
    a, k = float(line[0]), float(line[1])
    if not (k > 0.0 and a > 0.0):
        raise BadInput.of("stress does not fall with strain in the unloading", file=segments.file)
    elastic = a / k if procedure == "consistent" else 0.0
    stretch = float(np.exp(turning - elastic))
    slopes = np.array([-1.0 / k, (1.0 + elastic) / k]) if procedure == "consistent" else np.array([0.0, 1.0 / k])
    return ModulusFit(k * stretch, float(slopes @ covariance @ slopes), (a, k), turning, stretch, hencky[top], y, notes)


def _unloading(segments: Segments, area_ratio: float) -> tuple[Array, Array]:
    """Return Hencky strain and engineering truss stress of the unloading, without a dwell at its start."""
    strain, stress = segments.unloading_strain, segments.unloading_stress
    moving = np.flatnonzero(strain < strain.max() * (1.0 - JITTER))
    start = max(int(moving[0]) - 1, 0) if len(moving) else 0
    return np.log1p(strain[start:]), stress[start:] * area_ratio


def _top_part(hencky: Array, stress: Array, turning: float) -> Array:
    """Mark the top 40 % in stress, judged on the fitted line: judged on noisy points the slope would be biased."""
    peak = float(stress[: max(2, len(stress) // 20)].mean())
    top = stress >= (1.0 - TOP) * peak
    for _ in range(20):
        if np.count_nonzero(top) < MIN_UNLOADING:
            break
        slope, start = np.polyfit(hencky[top] - turning, stress[top], 1)
        if slope <= 0.0:
            break
        new = hencky - turning >= -TOP * start / slope * (1.0 + 1e-9)
        if np.array_equal(new, top):
            break
        top = new
    return np.asarray(top)


def _straight_line(x: Array, y: Array, noise: float) -> tuple[Array, Array]:
    """Return (value at x = 0, slope) of the least-squares line and their covariance."""
    basis = np.column_stack([np.ones_like(x), x])
    line, *_ = np.linalg.lstsq(basis, y, rcond=None)
    variance = residual_variance(y - basis @ line, parameters=2, floor=noise**2)
    return np.asarray(line, dtype=np.float64), variance * np.linalg.inv(basis.T @ basis)


def _tie(
    line: Array, covariance: Array, segments: Segments, turning: float, *, area_ratio: float
) -> tuple[Array, Array, tuple[str, ...]]:
    """Tie the line to the stress at the end of loading, or say that the two do not meet.

    The end of loading is a second, independent measurement of the line's value at the turning point.
    """
    end = _end_of_loading(segments, turning, area_ratio)
    if end is None:
        return line, covariance, ()
    value, variance = end
    miss = float(line[0]) - value
    spread = float(covariance[0, 0]) + variance
    if spread <= 0.0:
        return line, covariance, ()
    if abs(miss) > TIE_LIMIT * np.sqrt(spread) + 1e-3 * value:
        note = f"stress {'falls' if miss < 0.0 else 'jumps'} by {abs(miss) / value:.1%} at the start of unloading"
        return line, covariance, (note,)
    gain = covariance[:, 0] / spread
    return line - gain * miss, covariance - np.outer(gain, covariance[0]), ()


def _end_of_loading(segments: Segments, turning: float, area_ratio: float) -> tuple[float, float] | None:
    """Return the truss stress at the end of loading and its variance, from a parabola through its last part."""
    hencky = np.log1p(segments.strain)
    x = hencky - turning
    near = np.abs(x) <= END_OF_LOADING * (turning - float(hencky[0]))
    if np.count_nonzero(near) < 6 or float(hencky[-1]) < turning * (1.0 - 0.05):
        return None
    basis = np.vander(x[near] / np.abs(x[near]).max(), 3, increasing=True)
    stress = segments.stress[near] * area_ratio
    fit, *_ = np.linalg.lstsq(basis, stress, rcond=None)
    variance = residual_variance(stress - basis @ fit, parameters=3, floor=(area_ratio * segments.noise) ** 2)
    return float(fit[0]), float(variance * np.linalg.inv(basis.T @ basis)[0, 0])
