"""Least squares of the truss law on one specimen: loading and, when the modulus is free, the top of unloading.

Unknowns are the logarithm of the stress at a strain inside the curve instead of ln H (which lies far outside, at a
plastic strain of one), n, and where asked for ln E, the datum of strain and the stress over which a progressive toe is
taken up. They are then nearly uncorrelated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.identify.coupon import (
    D_LOG_E,
    D_LOG_H,
    D_N,
    D_STRAIN,
    LoadingCurve,
    loading_curve,
    straightened,
    unloading_line,
)
from etextile.identify.statistics import residual_variance
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array, BoolArray


N_LIMITS = (0.1, 10.0)
TOE = 4
"""Column of the stress over which a progressive toe is taken up."""
LEAST_OVER, MOST_OVER = 2e-3, 0.25
"""Shares of the peak stress between which it is looked for: at less it is taken up at once, at more it is the law."""
CLOSE, CLOSE_TOE = 1e-9, 1e-5
"""Relative change at which a search ends; most curves have no toe to be found, and the valley to it is flat."""
_REFERENCE = 0.6


@dataclass(frozen=True)
class CurveData:
    """Loading (n,) and top of unloading (m,): Hencky strain and engineering truss stress; its noise, MPa.

    `zeroed`: strain and stress were set to zero at a preload, so the stress there, at minus the datum, is missing.
    """

    hencky: Array
    stress: Array
    noise: float
    turning: float = 0.0
    unloading_hencky: Array | None = None
    unloading_stress: Array | None = None
    zeroed: bool = False


@dataclass(frozen=True)
class LawSolution:
    """Fitted law and datum of strain (subtracted from the Hencky strains), `over`: stress of a progressive toe, or 0.

    `covariance` (4, 4) of (ln E, ln H, n, datum), zero for what was held; `by_log_E` (2,): change of (ln H, n) with
    ln E where E was held; `residuals` (n,): measured minus fitted engineering truss stress of loading, MPa.
    """

    law: PowerLaw
    datum: float
    covariance: Array
    by_log_E: Array
    residuals: Array
    over: float = 0.0


def solve(
    law: PowerLaw,
    data: CurveData,
    *,
    free_modulus: bool = False,
    free_datum: bool = False,
    datum: float = 0.0,
    over: float = 0.0,
) -> LawSolution:
    """Return the least-squares fit that starts from `law`, `datum` and `over`.

    `over` > 0, engineering truss stress, MPa: the datum is a toe that is taken up over this stress, which is fitted.
    """
    from scipy.optimize import least_squares

    reference = float(np.log(_REFERENCE * data.hencky.max()))
    scale = float(data.stress.max())
    free = np.array([free_modulus, True, True, free_datum, over > 0.0])
    start = np.array([np.log(law.E), np.log(law.H) + law.n * reference, law.n, datum, np.log(over or 1.0)])

    def full(x: Array) -> Array:
        values = start.copy()
        values[free] = x
        values[2] = np.clip(values[2], *N_LIMITS)
        if over > 0.0:
            values[TOE] = np.clip(values[TOE], np.log(LEAST_OVER * scale), np.log(MOST_OVER * scale))
            values[3] = max(values[3], 0.0)
        else:
            values[TOE] = -np.inf
        return values

    seen: list[Array] = []

    def both(x: Array) -> list[Array]:
        """Return x, residuals and derivatives; the search asks for the latter at an x it has just tried."""
        if not seen or not np.array_equal(seen[0], x):
            seen[:] = [x.copy(), *_miss(law, data, full(x), reference=reference)]
        return seen

    close = CLOSE_TOE if over > 0.0 else CLOSE
    fit = least_squares(
        lambda x: both(x)[1] / scale, start[free], jac=lambda x: both(x)[2][:, free] / scale, method="lm",
        xtol=close, ftol=close, max_nfev=200,
    )  # fmt: skip
    values = full(fit.x)
    residuals, design = _miss(law, data, values, reference=reference)
    return _solution(law, data, values, residuals=residuals, design=design, free=free, reference=reference)


def _miss(law: PowerLaw, data: CurveData, values: Array, *, reference: float) -> tuple[Array, Array]:
    """Return fitted minus measured stress of all points and its derivatives by the five unknowns."""
    now, datum, over = _law(law, values, reference), float(values[3]), float(np.exp(values[TOE]))
    curve = loading_curve(now, straightened(now, data.hencky, toe=datum, over=over))
    stress, slopes, measured = curve.stress, _by_toe(curve, datum, over), data.stress
    if data.unloading_hencky is not None and data.unloading_stress is not None:
        line, line_slopes = unloading_line(now, data.unloading_hencky - datum, from_hencky=data.turning - datum)
        line_slopes = np.column_stack([line_slopes, np.zeros(len(line))])
        stress, slopes = np.concatenate([stress, line]), np.vstack([slopes, line_slopes])
        measured = np.concatenate([measured, data.unloading_stress])
    if data.zeroed:
        start = loading_curve(now, np.array([-datum]))
        stress, slopes = stress - start.stress, slopes - np.append(start.slopes, [[0.0]], axis=1)
    design = slopes.copy()
    design[:, D_N] -= reference * slopes[:, D_LOG_H]
    design[:, D_STRAIN] *= -1.0
    return stress - measured, design


def _by_toe(curve: LoadingCurve, toe: float, over: float) -> Array:
    """Return the slopes (n, 5) of the loading at strains of the test: by ln E, ln H, n, minus the toe and ln over."""
    if over == 0.0:
        return np.column_stack([curve.slopes, np.zeros(len(curve.stress))])
    left = np.exp(-curve.stress / over)
    rise = curve.slopes[:, D_STRAIN]
    slopes = np.column_stack([curve.slopes, rise * toe * left * curve.stress / over])
    slopes[:, D_STRAIN] *= 1.0 - left
    return np.asarray(slopes / (1.0 + rise * toe * left / over)[:, None])


def _law(law: PowerLaw, values: Array, reference: float) -> PowerLaw:
    """Return the law for the unknowns (ln E, ln stress at the reference strain, n, datum, ln over)."""
    log_h = float(np.clip(values[1] - values[2] * reference, -50.0, 80.0))
    return replace(law, E=law.E * float(np.exp(values[0] - np.log(law.E))), H=float(np.exp(log_h)), n=float(values[2]))


def _solution(
    law: PowerLaw, data: CurveData, values: Array, *, residuals: Array, design: Array, free: BoolArray, reference: float
) -> LawSolution:
    """Turn the solution into (ln E, ln H, n, datum) with its covariance."""
    chosen = design[:, free]
    inverse = np.linalg.pinv(chosen.T @ chosen)
    count = int(np.count_nonzero(free))
    variance = residual_variance(residuals[: len(data.hencky)], parameters=count, floor=data.noise**2)
    covariance = np.zeros((5, 5))
    covariance[np.ix_(free, free)] = variance * inverse
    covariance = covariance[:TOE, :TOE]
    to_h = np.eye(4)
    to_h[D_LOG_H, D_N] = -reference
    by_log_e = np.zeros(5)
    by_log_e[free] = -inverse @ chosen.T @ design[:, D_LOG_E]
    by_log_e = by_log_e[:TOE]
    return LawSolution(
        _law(law, values, reference),
        float(values[3]),
        to_h @ covariance @ to_h.T,
        (to_h @ by_log_e)[[D_LOG_H, D_N]],
        -residuals[: len(data.hencky)],
        float(np.exp(values[TOE])),
    )
