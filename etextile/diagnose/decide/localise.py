r"""Where simulation and measurement part: a calibrated scan over windows, and the onset by a hinge.

Scan: for every series and every window of displacement, z = v^T C^-1 r / sqrt(v^T C^-1 v) asks whether the difference
r has the pattern v (a constant or relative change in the window, or the change an effect of the library would make).
The largest |z| over all of them is compared with its distribution under noise alone, which is simulated from C; so the
chance to find anything in a test without a gap is 5 % over all channels together.

Hinge: r = b s(u) max(u - u0, 0)^p + noise on one series; u0 has a flat prior, b is integrated out. A gap that starts
with a kink and then saturates, grows in proportion, or starts smoothly has p = 1/2, 1, 2; s is one or the size of the
signal. The data weigh these shapes: one fixed shape would shift the onset of all others by many millimetres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.points import Points
from etextile.diagnose.infer.gauss import Whitener, log_sum
from etextile.types import Array, BoolArray


LEVEL = 0.05
WINDOWS = 8
DRAWS = 4000
POWERS = (0.5, 1.0, 2.0)


@dataclass(frozen=True)
class Window:
    """A pattern of the scan: series number, displacements from and to (mm); series -1 for a pattern of all channels."""

    series: int
    low: float
    high: float


@dataclass(frozen=True)
class Scan:
    """Result of the scan: largest |z| of all patterns and its p-value; the best window of every series with its z.

    `critical`: |z| that noise alone passes in 5 % of tests.
    """

    largest: float
    p_value: float
    critical: float
    best: tuple[tuple[Window, float], ...]

    @property
    def detected(self) -> bool:
        """Whether there is a gap that noise does not explain."""
        return self.p_value < LEVEL


@dataclass(frozen=True)
class Onset:
    """Displacement (mm) from which on a series departs, with its 95 % interval."""

    at: float
    low: float
    high: float


def scan(
    points: Points, residual: Array, whiteners: Sequence[Whitener], weights: Array, *, size: Array,
    patterns: Array | None = None, seed: int = 0, draws: int = DRAWS,
) -> Scan:  # fmt: skip
    """Scan the difference (n,) for patterns that noise does not show.

    `whiteners`, `weights`: samples of the covariance; `size` (n,): scale of a relative change; `patterns` (n, k):
    further directions, such as the changes of all effects.
    """
    windows, vectors = _windows(points, size)
    if patterns is not None and patterns.shape[1]:
        vectors = np.concatenate([vectors, patterns], axis=1)
        windows += [Window(-1, float(points.displacement.min()), float(points.displacement.max()))] * patterns.shape[1]
    mean = _mean_whitener(whiteners, weights)
    white = mean(vectors)
    norm = np.linalg.norm(white, axis=0)
    usable = norm > 1e-9 * norm.max(initial=1.0)
    unit = white[:, usable] / norm[usable]
    z = unit.T @ mean(residual)
    null = _null(unit, mean, whiteners, weights, draws=draws, seed=seed)
    largest = float(np.abs(z).max(initial=0.0))
    p_value = (1.0 + float(np.count_nonzero(null >= largest))) / (1.0 + len(null))
    kept = [window for window, use in zip(windows, usable, strict=True) if use]
    return Scan(largest, p_value, float(np.quantile(null, 1.0 - LEVEL)), _best(points, kept, z))


def _windows(points: Points, size: Array) -> tuple[list[Window], Array]:
    """Return windows and their patterns (n, k): relative changes, over all stretches of an eighth of the range each.

    Specimens of one quantity share their windows: what is common to them is the gap.
    """
    kinds: dict[tuple[str, str], list[int]] = {}
    for i, item in enumerate(points.series):
        kinds.setdefault((item.channel, item.quantity), []).append(i)
    windows, vectors = [], []
    for numbers in kinds.values():
        own = np.isin(points.owner, numbers)
        if not own.any():
            continue
        low, high = float(points.displacement[own].min()), float(points.displacement[own].max())
        edges = np.linspace(low, high, WINDOWS + 1)
        for a in range(WINDOWS):
            for b in range(a + 1, WINDOWS + 1):
                inside = own & (points.displacement >= edges[a]) & (points.displacement <= edges[b])
                if inside.any():
                    windows.append(Window(numbers[0], float(edges[a]), float(edges[b])))
                    vectors.append(np.where(inside, size, 0.0))
    return windows, np.stack(vectors, axis=1)


def _mean_whitener(whiteners: Sequence[Whitener], weights: Array) -> Whitener:
    if len(whiteners) == 1:
        return whiteners[0]
    total = sum(weight * item.factor @ item.factor.T for weight, item in zip(weights, whiteners, strict=True))
    return Whitener.of(np.asarray(total) / float(np.sum(weights)))


def _null(
    unit: Array, mean: Whitener, whiteners: Sequence[Whitener], weights: Array, *, draws: int, seed: int
) -> Array:
    """Return the largest |z| (draws,) of noise alone, drawn from the samples of the covariance."""
    rng = np.random.default_rng(seed)
    counts = np.maximum(1, np.round(draws * weights / weights.sum()).astype(int))
    found = []
    for count, item in zip(counts, whiteners, strict=True):
        pattern = unit.T @ mean(item.factor)
        found.append(np.abs(pattern @ rng.standard_normal((unit.shape[0], count))).max(axis=0))
    return np.concatenate(found)


def _best(points: Points, windows: Sequence[Window], z: Array) -> tuple[tuple[Window, float], ...]:
    best: dict[int, tuple[Window, float]] = {}
    for window, value in zip(windows, z, strict=True):
        if window.series >= 0 and abs(value) > abs(best.get(window.series, (window, 0.0))[1]):
            best[window.series] = (window, float(value))
    return tuple(best[key] for key in sorted(best))


def onset(displacement: Array, residual: Array, covariance: Array, *, scale: Array | None = None) -> Onset:
    """Return the hinge of a difference (n,) with covariance (n, n); `scale` (n,): size of the signal, for its shapes.

    Profile over u0 on a grid of 200 points, b integrated out under a prior whose width cancels the norm of the hinge v,
    so the likelihood of u0 is exp(z^2 / 2), z = v^T C^-1 r / sqrt(v^T C^-1 v), summed over the shapes.
    """
    white = Whitener.of(covariance)
    start, end = float(displacement.min()), float(displacement.max())
    grid = np.linspace(start, end - 0.02 * (end - start), 200)
    reach = np.maximum(displacement[:, None] - grid[None, :], 0.0)
    sizes = [np.ones(len(displacement))] if scale is None else [np.ones(len(displacement)), scale]
    target = white(residual)
    rows = [_hinge_fit(white(size[:, None] * reach**power), target) for size in sizes for power in POWERS]
    log_p = log_sum(np.stack(rows), axis=0)
    mass = np.exp(log_p - log_sum(log_p))
    cumulated = np.cumsum(mass) - 0.5 * mass
    low, at, high = np.interp([0.025, 0.5, 0.975], cumulated / mass.sum(), grid)
    return Onset(float(at), float(low), float(high))


def _hinge_fit(vectors: Array, target: Array) -> Array:
    """Return z^2 / 2 (k,) of whitened hinges (n, k)."""
    norm = np.linalg.norm(vectors, axis=0)
    usable = norm > 1e-12 * norm.max()
    z = vectors.T @ target / np.where(usable, norm, 1.0)
    return np.where(usable, 0.5 * z**2, -np.inf)


def in_window(points: Points, window: Window) -> BoolArray:
    """Return the points (n,) of a window: all specimens of its quantity."""
    item = points.series[window.series]
    same = [
        i for i, other in enumerate(points.series) if (other.channel, other.quantity) == (item.channel, item.quantity)
    ]
    inside = (points.displacement >= window.low - 1e-9) & (points.displacement <= window.high + 1e-9)
    return np.asarray(np.isin(points.owner, same) & inside)
