r"""Noise of a measurement: instrument floor, specimen scatter, and what is known of both from the data alone.

A specimen s of the punch test is not the mean specimen: its curve is (1 + g) F(u - d) + drift(u) + noise with gain g,
datum shift d and a smooth drift, so neighbouring points of a curve are wrong together. Their sizes are inferred from
the differences between repeats (the common curve is projected out, so no gap to the simulation leaks in); with one
specimen the stated priors stand alone. The remaining uncertainty of the sizes is kept as a few weighted samples: with
two or three repeats it decides how often nothing is mistaken for something.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.points import Points
from etextile.diagnose.infer.gauss import log_sum
from etextile.types import Array, IntArray
from etextile.vocabulary import CURVES, EDGE, FIELD, FORCES, STRAIN


# Priors of the scatter between specimens: medians, and standard deviation of the logarithm.
GAIN, DRIFT, SPREAD = 0.008, 0.005, 0.9
SHIFT = {"mm": 0.05, "bar": 0.005, "deg": 0.5, "1/m": 0.01}
# Correlation length of drifts as a share of the displacement range; of the edge as a share of its length.
DRIFT_LENGTH, PLACE_LENGTH = 0.25, 0.4
# Smooth error of a full-field channel measured once: share of the motion or strain, and of its instrument floor.
FIELD_SHARE, FIELD_FLOOR = 0.01, 0.25
# Weight of a stated noise in points, when it is pooled with the roughness of the curve.
STATED_POINTS = 20.0
# Error of interpolation and of the solver's tolerance, as a share of the local value and of its largest.
SOLVER_SHARE = 5e-4


@dataclass(frozen=True)
class NoiseScatter:
    """Standard deviations between specimens: gain (relative), datum shift (mm or bar), smooth drift (relative)."""

    gain: float
    shift: float
    drift: float


@dataclass(frozen=True)
class WeightedScatter:
    """A sample of the scatter with its probability."""

    weight: float
    scatter: NoiseScatter


@dataclass(frozen=True)
class SignalShape:
    """What the noise model knows of the signal at points (n,): value, its slope over displacement, its motion.

    `motion` is the change since rest (for the force and strains the value itself).
    """

    value: Array
    slope: Array
    motion: Array


def roughness(at: Array, values: Array, groups: IntArray) -> tuple[Array, IntArray]:
    """Return third divided differences (k,), normalised to the noise of one point, and their middle points (k,).

    What a parabola through neighbours cannot follow is noise; `groups` (n,) tells places apart.
    """
    found, middle = [], []
    for group in np.unique(groups):
        own = np.flatnonzero(groups == group)
        own = own[np.argsort(at[own], kind="stable")]
        if len(own) < 4:
            continue
        windows = np.lib.stride_tricks.sliding_window_view(own, 4)
        place = at[windows]
        apart = place[:, :, None] - place[:, None, :] + np.eye(4)
        product = np.prod(apart, axis=2)
        usable = np.all(product != 0.0, axis=1)
        weights = 1.0 / product[usable]
        weights /= np.linalg.norm(weights, axis=1, keepdims=True)
        found.append(np.einsum("kj,kj->k", weights, values[windows[usable]]))
        middle.append(windows[usable][:, 1])
    if not found:
        return np.zeros(0), np.zeros(0, dtype=np.int64)
    return np.concatenate(found), np.concatenate(middle)


def instrument(points: Points, residual: Array, size: Array) -> Array:
    """Return the standard deviation (n,) of every raw point: constant plus, for forces, a share of the value.

    `residual` (n,): measured minus simulated (removes most of the curvature); `size` (n,): simulated value.
    """
    sigma = np.zeros(len(points))
    for channel in points.channels:
        for quantity in sorted({item.quantity for item in points.series if item.channel == channel}):
            numbers = [i for i, s in enumerate(points.series) if s.channel == channel and s.quantity == quantity]
            own = np.flatnonzero(np.isin(points.owner, numbers))
            sigma[own] = _one_instrument(points, own, residual[own], size[own], relative=channel in FORCES)
    return sigma


def _one_instrument(points: Points, own: IntArray, residual: Array, size: Array, *, relative: bool) -> Array:
    groups = _places(points, own)
    rough, middle = roughness(points.displacement[own], residual, groups)
    stated = points.stated[own]
    stated_value = float(np.nanmean(stated)) if np.any(np.isfinite(stated)) else 0.0
    scale = float(np.abs(size).max()) if len(size) else 1.0
    if len(rough) < 3:
        return np.full(len(own), stated_value or 0.01 * scale)
    limit = 4.0 * 1.4826 * float(np.median(np.abs(rough))) + 1e-12 * scale
    squares = np.minimum(rough**2, limit**2)
    prior = STATED_POINTS if stated_value > 0.0 else 0.0
    count = 0.4 * len(squares)  # neighbouring differences share points
    if not relative:
        variance = (prior * stated_value**2 + count * squares.mean()) / (prior + count)
        return np.full(len(own), np.sqrt(variance))
    floor, share = _floor_and_share(squares, np.abs(size[middle]), stated=stated_value, prior=prior, scale=scale)
    return np.hypot(floor, share * np.abs(size))


def _floor_and_share(squares: Array, size: Array, *, stated: float, prior: float, scale: float) -> tuple[float, float]:
    """Return the constant and the relative part of the noise that make squared differences likeliest, on a grid."""
    top = float(np.sqrt(squares.mean())) + stated + 1e-9 * scale
    floors = np.concatenate([[0.02], np.geomspace(0.05, 2.0, 24)]) * top
    shares = np.concatenate([[0.0], np.geomspace(0.02, 2.0, 24)]) * top / max(float(np.median(size)), 1e-3 * scale)
    variance = floors[:, None, None] ** 2 + (shares[None, :, None] * size[None, None, :]) ** 2
    cost = 0.4 * (np.log(variance) + squares / variance).sum(axis=2)
    if prior:
        whole = floors[:, None] ** 2 + 0.0 * shares[None, :]
        cost = cost + prior * (np.log(whole) + stated**2 / whole)
    # a relative part has to be clearly better than none
    cost = cost + np.where(shares > 0.0, 2.0, 0.0)[None, :]
    i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return float(floors[i]), float(shares[j])


def _places(points: Points, own: IntArray) -> IntArray:
    """Number the places (specimen, material point) of points."""
    key = np.stack([
        points.owner[own].astype(float), np.nan_to_num(points.warp0[own], posinf=1e6, neginf=-1e6),
        np.nan_to_num(points.weft0[own], posinf=1e6, neginf=-1e6),
    ], axis=1)  # fmt: skip
    return np.unique(np.round(key, 6), axis=0, return_inverse=True)[1].ravel().astype(np.int64)


def infer_scatter(
    points: Points, residual: Array, white: Array, shape: SignalShape, *, samples: int = 6
) -> tuple[WeightedScatter, ...]:
    """Return weighted samples of the scatter given the repeats of a curve, or of the heights of a field.

    Posterior on a grid of log gain, log shift, log drift under log-normal priors; the likelihood sees differences
    between specimens only, because a common curve of any smooth shape is allowed at no cost.
    """
    repeats = points.curves if points.curves.any() else points.of(FIELD) & points.is_quantity("height")
    own = np.flatnonzero(repeats)
    specimens = np.unique(points.owner[own])
    reach = np.linspace(-2.0, 2.0, 7)
    grid = np.stack([axis.ravel() for axis in np.meshgrid(reach, reach, reach, indexing="ij")], axis=1)
    log_p = -0.5 * (grid**2).sum(axis=1)
    sizes = np.array([GAIN, SHIFT[points.unit], DRIFT]) * np.exp(SPREAD * grid)
    if len(specimens) > 1:
        part = points.where(repeats)
        parts = _specimen_parts(part, SignalShape(shape.value[own], shape.slope[own], shape.motion[own]))
        fixed = np.diag(white[own] ** 2) + _common(part, shape.value[own])
        log_p = log_p + np.array([_log_likelihood(residual[own], fixed, parts, size) for size in sizes])
    weights = np.exp(log_p - log_sum(log_p))
    return _representatives(sizes, weights, samples)


def _representatives(sizes: Array, weights: Array, samples: int) -> tuple[WeightedScatter, ...]:
    """Return strata of equal probability along the total scatter, each with the root mean square of its sizes."""
    order = np.argsort(sizes[:, 0] ** 2 + sizes[:, 2] ** 2 + (sizes[:, 1] / 20.0) ** 2)
    stratum = np.minimum((np.cumsum(weights[order]) - 0.5 * weights[order]) * samples, samples - 1).astype(int)
    found = []
    for number in np.unique(stratum):
        own = order[stratum == number]
        weight = float(weights[own].sum())
        if weight > 1e-6:
            mean = np.sqrt((weights[own, None] * sizes[own] ** 2).sum(axis=0) / weight)
            found.append(WeightedScatter(weight, NoiseScatter(float(mean[0]), float(mean[1]), float(mean[2]))))
    return tuple(found)


def _common(points: Points, value: Array) -> Array:
    """Return a covariance that lets a curve common to all specimens take any smooth shape."""
    u = points.displacement
    size = np.abs(value) + 0.1 * float(np.abs(value).max())
    apart = (u[:, None] - u[None, :]) / max(0.12 * float(np.ptp(u)), 1e-9)
    return np.asarray((0.5 * size[:, None]) * (0.5 * size[None, :]) * np.exp(-0.5 * apart**2))


def _log_likelihood(residual: Array, fixed: Array, parts: Sequence[Array], sizes: Array) -> float:
    covariance = fixed + sum(size**2 * part for size, part in zip(sizes, parts, strict=True))
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, residual)
    return -0.5 * float(white @ white) - float(np.log(np.diag(factor)).sum())


def _specimen_parts(points: Points, shape: SignalShape) -> tuple[Array, Array, Array]:
    """Return the covariances (n, n) of curves and motions for unit gain, shift and drift of a specimen."""
    same = (points.specimen[:, None] == points.specimen[None, :]).astype(float)
    size = np.abs(shape.value) + 0.05 * float(np.abs(shape.value).max(initial=0.0))
    u = points.displacement
    apart = (u[:, None] - u[None, :]) / max(DRIFT_LENGTH * float(np.ptp(u)), 1e-9)
    drift = size[:, None] * size[None, :] * np.exp(-0.5 * apart**2)
    outer_gain = shape.value[:, None] * shape.value[None, :]
    return same * outer_gain, same * shape.slope[:, None] * shape.slope[None, :], same * drift


def covariance(points: Points, white: Array, shape: SignalShape, scatter: NoiseScatter) -> Array:
    """Return the covariance (n, n) of measured points about the mean specimen's curve."""
    matrix = np.diag(white**2 + (SOLVER_SHARE * _largest(points, shape.value)) ** 2)
    own = np.flatnonzero(points.repeated)
    if len(own):
        part = points.where(points.repeated)
        gain, shift, drift = _specimen_parts(part, SignalShape(shape.value[own], shape.slope[own], shape.motion[own]))
        matrix[np.ix_(own, own)] += scatter.gain**2 * gain + scatter.shift**2 * shift + scatter.drift**2 * drift
    for i, item in enumerate(points.series):
        mine = np.flatnonzero(points.owner == i)
        if item.channel not in CURVES and len(mine):
            matrix[np.ix_(mine, mine)] += _field_scatter(points, mine, white[mine], shape.motion[mine])
    for channel in (EDGE, STRAIN):
        mine = np.flatnonzero(points.of(channel))
        slope = shape.slope[mine]
        matrix[np.ix_(mine, mine)] += scatter.shift**2 * slope[:, None] * slope[None, :]
    return matrix


def _field_scatter(points: Points, own: IntArray, white: Array, motion: Array) -> Array:
    """Return the smooth error of one full-field quantity that was measured once."""
    size = points.side[own] * np.hypot(FIELD_SHARE * np.abs(motion), FIELD_FLOOR * white)
    return np.asarray(size[:, None] * size[None, :] * closeness(points, own))


def closeness(points: Points, own: IntArray, *, share: float = 1.0) -> Array:
    """Return the correlation (k, k) of a smooth error at the points `own` (k,); `share` of the usual lengths."""
    apart = _scaled(points.displacement[own], share * DRIFT_LENGTH)
    for place in (points.warp0[own], points.weft0[own]):
        if np.all(np.isfinite(place)):
            apart = apart + _scaled(place, share * PLACE_LENGTH)
    return np.asarray(np.exp(-0.5 * apart))


def _scaled(values: Array, share: float) -> Array:
    """Return squared differences (n, n) in correlation lengths."""
    length = max(share * float(np.ptp(values)), 1e-9)
    return np.asarray(((values[:, None] - values[None, :]) / length) ** 2)


def _largest(points: Points, value: Array) -> Array:
    """Return the largest value (n,) of each point's series."""
    found = np.zeros(len(points))
    for i in range(len(points.series)):
        own = points.owner == i
        found[own] = np.abs(value[own]).max(initial=0.0)
    return found
