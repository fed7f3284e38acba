"""Loading, unloading, preload, slack and the start of failure, found in one tensile curve.

What is fitted is the primary loading (strain beyond all earlier strain) up to the start of failure, and the unloading
from its end. Pauses, reloading and everything after a failure are left out and said so. The datum of strain is not
decided here: only how far it could be off is (`slack_limit`, `preload`), the fit uses it where the law demands it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.identify.curves import MIN_POINTS, CouponSize, TensileCurve
from etextile.importers.records import (
    MIN_FALL,
    PAUSE,
    jitter_of,
    point_noise,
    primary,
    reversals,
    running_median,
    single_note,
    single_readings,
    stands_still,
    where_broken,
)
from etextile.types import Array, BoolArray, IntArray


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
    which the stress does not stand out of the noise. `notes`: what was left out and why. `left_out`: reasons in a few
    words, each with the lines of the file it holds for. `size`, `on_specimen`: as of the curve.
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
    left_out: tuple[tuple[str, IntArray], ...] = ()
    size: CouponSize | None = None
    on_specimen: bool = False

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
    every = curve.lines
    curve, single = _without_single(curve)
    curve, came_apart = _before_break(curve)
    falls = _falls(curve)
    rows = np.flatnonzero(primary(curve.strain, falls))
    noise = point_noise(curve.stress[rows])
    failure = _failure(curve.strain[rows], curve.stress[rows], noise)
    end, broken, paused = failure.end, failure.broken, failure.paused
    if came_apart and broken == len(rows):
        end = _onset(curve.strain[rows], running_median(curve.stress[rows], 5), len(rows) - 1)
    failed = bool(came_apart) or broken < len(rows)
    loading = rows[: end + 1][~paused[: end + 1]]
    rising = len(np.unique(curve.strain[loading]))
    if rising < MIN_POINTS:
        points = "1 point" if rising == 1 else f"{rising} points"
        message = f"strain rises over only {points} of loading, at least {MIN_POINTS} are needed; rows in time order?"
        raise BadInput.of(message, file=curve.file, line=int(curve.lines[loading[-1]]))
    notes = list(curve.notes)
    if paused.any():
        first = int(np.argmax(paused))
        notes.append(
            f"paused at strain {curve.strain[rows[first]]:.4f}: {int(paused.sum())} points of relaxed stress left out"
        )
    if failed:
        notes.append(f"cut at strain {curve.strain[loading[-1]]:.4f}: start of failure")
        notes.extend([came_apart] if came_apart else [])
    sound = [fall for fall in falls if broken == len(rows) or fall[0] < rows[broken]]
    unloading = _last_unloading(curve, sound)
    if len(sound) > 1:
        notes.append(f"{len(sound)} unloadings: the one from the largest strain is used, reloading is left out")
    strain, stress = curve.strain[loading], curve.stress[loading]
    preload, slack = _start(strain, stress, noise)
    return Segments(
        curve.file, strain, stress, curve.strain[unloading], curve.stress[unloading], noise, preload, slack,
        failed, tuple(notes),
        _left_out(
            every, curve.lines, single=single, kept=np.r_[loading, unloading], relaxed=rows[paused],
            failure=int(loading[-1]) if failed else None,
        ),
        curve.size, curve.on_specimen,
    )  # fmt: skip


def _left_out(
    every: IntArray, whole: IntArray, *, single: IntArray, kept: IntArray, relaxed: IntArray, failure: int | None
) -> tuple[tuple[str, IntArray], ...]:
    """Return why the rows outside of loading and unloading are not used, with their lines.

    `every`: lines of the file, `single`: those of single readings far off; `whole`: the others before the specimen came
    apart, to which the other rows count.
    """
    off = tuple(("a single reading far from its neighbours", single) for _ in single[:1])
    every = np.setdiff1d(every, single)
    reason = np.full(len(every), "unloading and reloading", dtype=object)
    if failure is not None:
        reason[failure + 1 :] = "from the start of failure on"
    reason[relaxed] = "relaxed while the crosshead stood still"
    reason[len(whole) :] = "after the specimen broke"
    reason[kept] = ""
    return off + tuple((why, every[reason == why]) for why in dict.fromkeys(reason.tolist()) if why)


def _without_single(curve: TensileCurve) -> tuple[TensileCurve, IntArray]:
    """Return the curve without single readings far from both neighbours, which agree, and the lines of those."""
    far = single_readings(curve.strain, curve.stress)
    if not far.any():
        return curve, curve.lines[:0]
    lines = curve.lines[far]
    kept = replace(
        curve, strain=curve.strain[~far], stress=curve.stress[~far], lines=curve.lines[~far],
        notes=(*curve.notes, single_note(lines)),
    )  # fmt: skip
    return kept, lines


def _before_break(curve: TensileCurve) -> tuple[TensileCurve, str]:
    """Return the curve up to its peak when the specimen came apart there, and a sentence about it.

    What follows, the crosshead's way home included, tells nothing of the fabric.
    """
    row = where_broken(curve.strain, curve.stress, back=0.01 * float(np.ptp(curve.strain)))
    if row is None:
        return curve, ""
    peak = int(np.argmax(curve.stress))
    left = len(curve.strain) - peak - 1
    note = (
        f"the specimen broke at strain {curve.strain[peak]:.4f}: {left} rows from line {curve.lines[row]} on left out"
    )
    head = slice(0, peak + 1)
    return replace(curve, strain=curve.strain[head], stress=curve.stress[head], lines=curve.lines[head]), note


def _falls(curve: TensileCurve) -> list[tuple[int, int]]:
    """Return (first, last) point of every unloading: strain falls for several points and stress with it."""
    falls = []
    for first, seen, last in reversals(curve.strain, jitter_of(curve.strain)):
        drop = curve.stress[max(first - 1, 0) : first + 1].max() - curve.stress[last]
        if last - first < MIN_FALL or drop < FALL * curve.stress.max():
            message = f"strain falls from {curve.strain[first]:.6g} to {curve.strain[seen]:.6g} outside of an unloading"
            remedy = "rows must be in time order, strain rising while loading"
            raise BadInput.of(f"{message}: {remedy}", file=curve.file, line=int(curve.lines[seen]))
        falls.append((first, last))
    return falls


@dataclass(frozen=True)
class _Failure:
    """Last point before the start of failure, first point after it (n when there is none), points (n,) of pauses."""

    end: int
    broken: int
    paused: BoolArray


def _failure(strain: Array, stress: Array, noise: float) -> _Failure:
    """Return where a specimen fails, and the points at which it was held instead.

    Failure: the stress falls by 5 % of its peak (or 5 times the noise) while the strain goes on rising, and does not
    exceed its earlier peak again; where it does, or the strain does not go on, the crosshead stood still and the stress
    relaxed. While the strain stands still less of a fall tells a pause.
    """
    smooth = running_median(stress, 5)
    top = np.maximum.accumulate(smooth)
    rises = np.r_[True, smooth[1:] > top[:-1]]
    at = np.maximum.accumulate(np.where(rises, np.arange(len(smooth)), 0))
    limit, least = max(FALL * float(smooth.max()), 5.0 * noise), max(3.0 * noise, PAUSE * float(smooth.max()))
    low = (top - smooth > limit) & (top > 0.2 * smooth.max())
    later = np.maximum.accumulate(smooth[::-1])[::-1]
    still = stands_still(strain, stress)
    dips = np.unique(at[(low & (later > top)) | (still & (top - smooth > least))])
    paused = np.isin(at, dips) & (top - np.maximum(smooth, stress) > max(2.0 * noise, PAUSE * float(smooth.max())))
    fallen = low & (later <= top) & ~still
    if not fallen.any():
        return _Failure(len(strain) - 1, len(strain), paused)
    broken = int(np.flatnonzero(fallen)[0])
    return _Failure(_onset(strain, smooth, int(at[broken])), broken, paused)


def _onset(strain: Array, smooth: Array, peak: int) -> int:
    """Return where softening before the peak begins: the tangent drops below 0.7 of the one before.

    At most 15 % of the strain back from the peak.
    """
    before = (strain <= (1.0 - SOFT_SPAN) * strain[peak]) & (strain >= (1.0 - 3.0 * SOFT_SPAN) * strain[peak])
    before &= np.arange(len(strain)) <= peak
    if np.count_nonzero(before) < 3:
        return peak
    tangent = float(np.polyfit(strain[before], smooth[before], 1)[0])
    last = int(np.flatnonzero(before)[-1])
    end = peak
    while end > last + 3 and _tangent(strain, smooth, end) < SOFT_TANGENT * tangent:
        end -= 1
    return end


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
    """Return the preload (MPa, 0 if within the noise) and the strain up to which the stress is within the noise.

    The strain is searched backwards from the top: a bump in the slack part is no begin of loading.
    """
    threshold = max(4.0 * noise, 2e-3 * float(stress.max()))
    head = stress[:3]
    preload = float(head[0]) if float(np.median(head)) > threshold and head[0] > threshold else 0.0
    quiet = np.flatnonzero(running_median(stress, 3) <= threshold)
    slack = float(strain[min(int(quiet[-1]) + 1, len(strain) - 1)]) if len(quiet) else float(strain[0])
    return preload, max(slack, 0.0)
