"""Loading, unloading, preload, slack and the start of failure, found in one tensile curve.

What is fitted is the primary loading (strain beyond all earlier strain) up to the start of failure, and the unloading
from its end. Reloading and everything after a failure are left out and said so. The datum of strain is not decided
here: only how far it could be off is (`slack_limit`, `preload`), the fit uses it where the law demands it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.identify.curves import MIN_POINTS, TensileCurve
from etextile.types import Array, BoolArray, IntArray


# A fall of strain by less than this share of the peak (more when the strain is noisy) is jitter, else an unloading.
JITTER, MAX_JITTER = 1e-3, 0.01
# A fall of stress by this share of the peak is an unloading (strain falls) or a failure (strain rises).
FALL = 0.05
MIN_UNLOADING = 4
# Softening before the peak of a failing specimen: the tangent drops below this share of the one before.
SOFT_TANGENT = 0.7
SOFT_SPAN = 0.15


@dataclass(frozen=True)
class Segments:
    """Parts of one curve: engineering strain and fabric engineering stress (MPa), in time order.

    `strain`, `stress` (n,): loading. `unloading_strain`, `unloading_stress` (m,): the unloading from the largest
    strain, from its turning point on; m = 0 when there is none. `noise`: standard deviation of the stress from point to
    point, MPa. `preload`: stress at the first point when it stands out of the noise, MPa. `slack_limit`: strain up to
    which the stress does not stand out of the noise. `notes`: what was left out and why.
    """

    file: str
    strain: Array
    stress: Array
    unloading_strain: Array
    unloading_stress: Array
    noise: float
    preload: float
    slack_limit: float
    failed: bool
    notes: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the specimen: the file's stem."""
        return Path(self.file).stem

    @property
    def unloads(self) -> bool:
        """Tell whether there is an unloading to find the modulus in."""
        return len(self.unloading_strain) >= MIN_UNLOADING


def split(curve: TensileCurve) -> Segments:
    """Split a curve into its parts; raises BadInput (file and line) where strain falls without an unloading."""
    falls = _falls(curve)
    primary = _primary(curve.strain, falls)
    noise = point_noise(curve.stress[primary])
    order = np.flatnonzero(primary)
    end, broken = _failure(curve.strain[order], curve.stress[order], noise)
    failed = broken < len(order)
    loading = order[: end + 1]
    rising = len(np.unique(curve.strain[loading]))
    if rising < MIN_POINTS:
        points = "1 point" if rising == 1 else f"{rising} points"
        message = f"strain rises over only {points} of loading, at least {MIN_POINTS} are needed; rows in time order?"
        raise BadInput.of(message, file=curve.file, line=int(curve.lines[loading[-1]]))
    notes = list(curve.notes)
    if failed:
        notes.append(f"cut at strain {curve.strain[loading[-1]]:.4f}: start of failure")
    sound = [fall for fall in falls if not failed or fall[0] < order[broken]]
    unloading = _last_unloading(curve, sound)
    if len(sound) > 1:
        notes.append(f"{len(sound)} unloadings: the one from the largest strain is used, reloading is left out")
    strain, stress = curve.strain[loading], curve.stress[loading]
    preload, slack = _start(strain, stress, noise)
    return Segments(
        curve.file, strain, stress, curve.strain[unloading], curve.stress[unloading], noise, preload, slack,
        failed, tuple(notes),
    )  # fmt: skip


def _falls(curve: TensileCurve) -> list[tuple[int, int]]:
    """Return (first, last) point of every unloading: strain falls for several points and stress with it."""
    falls = []
    peak = float(curve.strain.max())
    jitter = min(max(JITTER * peak, 10.0 * point_noise(curve.strain)), MAX_JITTER * peak)
    for first, seen, last in _reversals(curve.strain, jitter):
        drop = curve.stress[max(first - 1, 0) : first + 1].max() - curve.stress[last]
        if last - first < 3 or drop < FALL * curve.stress.max():
            message = f"strain falls from {curve.strain[first]:.6g} to {curve.strain[seen]:.6g} outside of an unloading"
            remedy = "rows must be in time order, strain rising while loading"
            raise BadInput.of(f"{message}: {remedy}", file=curve.file, line=int(curve.lines[seen]))
        falls.append((first, last))
    return falls


def _reversals(strain: Array, threshold: float) -> list[tuple[int, int, int]]:
    """Return every fall by more than `threshold`: its highest point, the first point below, its lowest point.

    Turning points are compared, not neighbours: a file of thousands of points falls by tiny steps.
    """
    found: list[tuple[int, int, int]] = []
    high = low = seen = 0
    falling = False
    for i, value in enumerate(strain.tolist()):
        if falling:
            if value <= strain[low]:
                low = i
            elif value > strain[low] + threshold:
                found.append((high, seen, low))
                falling, high = False, i
        elif value >= strain[high]:
            high = i
        elif value < strain[high] - threshold:
            falling, seen, low = True, i, i
    return [*found, (high, seen, low)] if falling else found


def _primary(strain: Array, falls: list[tuple[int, int]]) -> BoolArray:
    """Mark the points of primary loading: outside of unloadings and beyond the strain reached before them."""
    keep = np.ones(len(strain), dtype=np.bool_)
    for first, last in falls:
        keep[first + 1 : last + 1] = False
        back = np.flatnonzero(strain[last:] > strain[: first + 1].max())
        keep[last : last + (int(back[0]) if len(back) else len(strain))] = False
    return keep


def point_noise(values: Array) -> float:
    """Return the standard deviation of values (n,) from point to point, about any smooth curve.

    Third differences cancel a smooth curve and have the variance 20 sd^2; their median makes the estimate robust.
    """
    if len(values) < 8:
        return 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 3))) / np.sqrt(20.0))


def _running_median(values: Array, width: int) -> Array:
    """Return the median over a window of `width` points, narrower at the ends."""
    half = min(width // 2, max((len(values) - 1) // 2, 0))
    padded = np.pad(values, half, mode="reflect") if half else values
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1), axis=1))


def _failure(strain: Array, stress: Array, noise: float) -> tuple[int, int]:
    """Return the last point before the start of failure and the first after it (n when there is none).

    Failure: the stress falls by 5 % of its peak (or 5 times the noise) while the strain goes on rising. Its start:
    where the tangent has dropped below 0.7 of the one before, at most 15 % of the strain back from the peak.
    """
    smooth = _running_median(stress, 5)
    top = np.maximum.accumulate(smooth)
    rises = np.r_[True, smooth[1:] > top[:-1]]
    at = np.maximum.accumulate(np.where(rises, np.arange(len(smooth)), 0))
    limit = max(FALL * float(smooth.max()), 5.0 * noise)
    fallen = (top - smooth > limit) & (strain > strain[at] + 0.002 * strain.max()) & (top > 0.2 * smooth.max())
    if not fallen.any():
        return len(strain) - 1, len(strain)
    broken = int(np.flatnonzero(fallen)[0])
    peak = int(at[broken])
    before = (strain <= (1.0 - SOFT_SPAN) * strain[peak]) & (strain >= (1.0 - 3.0 * SOFT_SPAN) * strain[peak])
    if np.count_nonzero(before) < 3:
        return peak, broken
    tangent = float(np.polyfit(strain[before], stress[before], 1)[0])
    last = int(np.flatnonzero(before)[-1])
    end = peak
    while end > last + 3 and _tangent(strain, smooth, end) < SOFT_TANGENT * tangent:
        end -= 1
    return end, broken


def _tangent(strain: Array, stress: Array, end: int) -> float:
    """Return the slope over the last four points up to `end`."""
    rise = strain[end] - strain[end - 3]
    return float((stress[end] - stress[end - 3]) / rise) if rise > 0.0 else 0.0


def _last_unloading(curve: TensileCurve, falls: list[tuple[int, int]]) -> IntArray:
    """Return the points of the unloading from the largest strain, from the turning point on."""
    if not falls:
        return np.empty(0, dtype=np.int64)
    first, last = max(falls, key=lambda fall: float(curve.strain[fall[0]]))
    return np.arange(first, last + 1)


def _start(strain: Array, stress: Array, noise: float) -> tuple[float, float]:
    """Return the preload (MPa, 0 if within the noise) and the strain up to which the stress is within the noise."""
    threshold = max(4.0 * noise, 2e-3 * float(stress.max()))
    head = stress[:3]
    preload = float(head[0]) if float(np.median(head)) > threshold and head[0] > threshold else 0.0
    quiet = np.flatnonzero(_running_median(stress, 3) > threshold)
    slack = float(strain[quiet[0]]) if len(quiet) else float(strain[-1])
    return preload, max(slack, 0.0)
