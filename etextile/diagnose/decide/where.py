"""Where the gap is, in words: per channel its size, its window, its onset with an interval."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from etextile.diagnose.data.points import Points
from etextile.diagnose.decide.gap import gap_percent
from etextile.diagnose.decide.localise import Onset, Scan, Window, in_window, onset
from etextile.diagnose.infer.whitened import Workbench
from etextile.types import Array, BoolArray, IntArray
from etextile.units import load_text
from etextile.vocabulary import CURVES


NAMES = {
    "punch_force": "force", "clamp_force": "force", "pressure_height": "height", "joint_moment": "moment",
    "moment_curvature": "bending moment",
    "free_edge": "free edge", "strain_field": "strain field", "clamp_line": "clamp line",
    "displacement_field": "motion", "mark_slip": "slip on the skin",
}  # fmt: skip


@dataclass(frozen=True)
class GapPlace:
    """Gap of one quantity: onset (in the unit of the load, 95 % interval), size over its window, a sentence.

    `gap_percent`: root mean square difference over the window in per cent of the measured one (of the motion since
    rest), with the sign of the difference; the sentence gives the mean difference in per cent of the simulated force.
    """

    channel: str
    quantity: str
    onset: Onset
    window: Window
    z: float
    gap_percent: float
    sentence: str


def places(bench: Workbench, scan: Scan) -> tuple[GapPlace, ...]:
    """Return the quantities whose scan passes the critical value, strongest first; one per channel and quantity.

    A gap that only shows along the change that an effect makes is where the scan comes nearest to that value.
    """
    covariance = bench.mean_covariance
    clear = [(window, z) for window, z in scan.best if abs(z) > scan.critical]
    if not clear and scan.detected:
        clear = [max(scan.best, key=lambda item: abs(item[1]))]
    found = [_place(bench, window, z, covariance) for window, z in clear]
    return tuple(sorted(found, key=lambda place: -abs(place.z)))


def agreeing(bench: Workbench, found: tuple[GapPlace, ...]) -> tuple[str, ...]:
    """Return the channels without a gap."""
    return tuple(channel for channel in bench.points.channels if channel not in {place.channel for place in found})


def _place(bench: Workbench, window: Window, z: float, covariance: Array) -> GapPlace:
    points = bench.points
    item = points.series[window.series]
    own = in_window(points, Window(window.series, -np.inf, np.inf))
    inside = in_window(points, window)
    at = onset_of(bench, np.flatnonzero(own), bench.residual, covariance)
    relative = float(
        np.sum(bench.residual[inside] * bench.shape.motion[inside]) / np.sum(bench.shape.motion[inside] ** 2)
    )
    share = gap_percent(bench.residual[inside], bench.residual[inside] + bench.shape.motion[inside])
    name = NAMES.get(item.channel, item.channel)
    if item.channel in CURVES:
        low, high = (load_text(end, points.unit) for end in (at.low, at.high))
        sentence = f"{name} {100 * relative:+.0f} % from {load_text(at.at, points.unit)} {points.unit} [{low}, {high}]"
    else:
        sentence = _field_sentence(
            points, bench.residual, inside, window, name=f"{name} {_words(item.quantity)}", unit=item.unit
        )
    return GapPlace(item.channel, item.quantity, at, window, z, float(np.copysign(share, relative)), sentence)


def onset_of(bench: Workbench, own: IntArray, difference: Array, covariance: Array) -> Onset:
    """Return where a difference (n,) begins in the points `own` (k,) of one quantity."""
    size = np.maximum(np.abs(bench.shape.motion[own]), 0.02 * np.abs(bench.shape.motion[own]).max())
    size = size * bench.points.side[own]
    return onset(bench.points.displacement[own], difference[own], covariance[np.ix_(own, own)], scale=size)


def _words(quantity: str) -> str:
    return quantity.replace("_", " ").replace("strain warp", "warp strain").replace("strain weft", "weft strain")


def _field_sentence(points: Points, residual: Array, inside: BoolArray, window: Window, *, name: str, unit: str) -> str:
    """Return size, window and position along the specimen of a full-field difference."""
    along = points.warp0 if np.all(np.isfinite(points.warp0[inside])) else points.weft0
    place = along[inside]
    edges = np.quantile(place, [0.0, 1 / 3, 2 / 3, 1.0])
    means = []
    for low, high in pairwise(edges):
        third = (place >= low) & (place <= high)
        means.append(float(residual[inside][third].mean()))
    which = int(np.argmax(np.abs(means)))
    value = f"{means[which]:+.2f} {unit}" if unit else f"{means[which]:+.4f}"
    low, high = edges[which], edges[which + 1]
    loads = "-".join(load_text(end, points.unit, whole=True) for end in (window.low, window.high))
    return f"{name} {value} at {loads} {points.unit}, {low:.0f} to {high:.0f} mm along the specimen"


def headline(found: tuple[GapPlace, ...], agree: tuple[str, ...], *, tension: str = "") -> str:
    """Return one sentence on where the gap is."""
    seen: dict[str, str] = {}
    for place in found:
        seen.setdefault(place.channel, place.sentence)
    parts = list(seen.values())
    names = [NAMES.get(channel, channel) for channel in agree]
    if names:
        parts.append(f"{' and '.join(names)} {'agrees' if len(names) == 1 else 'agree'}")
    if tension:
        parts.append(tension)
    text = "; ".join(parts)
    return text[:1].upper() + text[1:] if text else "no channel to compare"
