r"""The free smooth discrepancy: a competitor without a mechanism, so that no effect wins for want of another.

On every quantity a Gaussian process of unknown size and length may be missing, covariance A^2 s(u) s(u')
exp(-|u - u'|^2 / 2 l^2) with s the size of the signal. Its evidence is averaged over sizes and lengths; a free curve
that has to be chosen from many fits worse than an effect that predicted it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from etextile.diagnose.data.points import Points
from etextile.diagnose.infer.fit import Evidence, ScatterSample, judge
from etextile.diagnose.infer.gauss import log_sum, smooth_modes
from etextile.types import Array
from etextile.vocabulary import CURVES


# Sizes as a share of the signal; correlation lengths as a share of the displacement range; of positions, of the edge.
SIZES = (0.0, 0.01, 0.03, 0.09, 0.27)
LENGTHS = (0.12, 0.35)
PLACES = 0.5


def form_modes(points: Points) -> Array:
    """Return smooth unit factors (n, m), per channel over displacement, by which an effect's change may differ."""
    span = max(float(np.ptp(points.displacement)), 1e-9)
    apart = (points.displacement[:, None] - points.displacement[None, :]) / (0.4 * span)
    columns = []
    for channel in points.channels:
        own = points.of(channel)
        kernel = np.where(own[:, None] & own[None, :], np.exp(-0.5 * apart**2), 0.0)
        columns.append(smooth_modes(kernel, share=0.97, most=4))
    return np.concatenate(columns, axis=1)


def free_modes(points: Points, size: Array, length: float) -> dict[str, Array]:
    """Return columns (n, k) of a discrepancy of unit relative size per group of channels: curves, and fields."""
    span = max(float(np.ptp(points.displacement)), 1e-9)
    apart = ((points.displacement[:, None] - points.displacement[None, :]) / (length * span)) ** 2
    for place in (points.warp0, points.weft0):
        finite = np.isfinite(place)
        if finite.any():
            value = np.where(finite, place, 0.0)
            reach = max(float(np.ptp(value[finite])), 1e-9)
            apart = apart + ((value[:, None] - value[None, :]) / (PLACES * reach)) ** 2
    groups: dict[str, list[Array]] = {}
    for channel, quantity in sorted({(item.channel, item.quantity) for item in points.series}):
        numbers = [i for i, s in enumerate(points.series) if (s.channel, s.quantity) == (channel, quantity)]
        own = np.isin(points.owner, numbers)
        kernel = np.where(own[:, None] & own[None, :], np.exp(-0.5 * apart), 0.0)
        modes = smooth_modes(size[:, None] * kernel * size[None, :], share=0.99, most=14)
        groups.setdefault("curves" if channel in CURVES else "fields", []).append(modes)
    return {name: np.concatenate(parts, axis=1) for name, parts in groups.items()}


def rests(points: Points, size: Array) -> tuple[Array, ...]:
    """Return columns (n, k) of rests of all sizes and lengths, alike in all channels, that effects may leave."""
    groups = [free_modes(points, size, length) for length in LENGTHS]
    return tuple(np.concatenate([a * modes for modes in item.values()], axis=1) for item in groups for a in SIZES if a)


def judge_free(samples: Sequence[ScatterSample], points: Points, size: Array, form: Array) -> tuple[Evidence, Array]:
    """Return the evidence of a free discrepancy and the likeliest columns (n, k) behind it."""
    found: list[tuple[float, Array]] = []
    for length in LENGTHS:
        groups = free_modes(points, size, length)
        for sizes in itertools.product(SIZES, repeat=len(groups)):
            if any(sizes):
                columns = np.concatenate(
                    [a * modes for a, modes in zip(sizes, groups.values(), strict=True) if a], axis=1
                )
                found.append((judge(samples, (), form, extra=columns).log_evidence, columns))
    values = np.array([value for value, _ in found])
    best = int(np.argmax(values))
    total = float(log_sum(values)) - np.log(len(values))
    return Evidence((), total, np.zeros(0), float(values[best]), np.zeros((1, 0)), np.ones(1), free=True), found[best][
        1
    ]
