"""All measured points of all channels as one vector, thinned to what they can tell.

Every stage of the diagnosis works on one vector of values and one covariance. A dense curve is thinned by averaging
differences to the simulation over bins (never the curve itself, whose curvature would bias the average), so a thousand
readings cost no more than thirty and keep their information.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.diagnose.data.bent import MomentCurvature
from etextile.diagnose.data.inflated import DisplacementField, JointMoment, PressureHeight
from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.pulled import ClampForce
from etextile.diagnose.data.punched import PunchForce
from etextile.types import Array, BoolArray, IntArray
from etextile.vocabulary import BEND, CHANNELS, CLAMP, CURVES, EDGE, FIELD, FORCE, HEIGHT, MOMENT, PULL, SLIP, STRAIN


# Bins over displacement and over position, per series.
CURVE_BINS, FIELD_BINS, PLACE_BINS = 30, 12, 7
# The same of fields that cameras see, hundreds of places at a time, and the loads up to which a run stops at each.
MOTION_BINS, MOTION_PLACES, MOST_STATIONS = 8, 4, 60
# A specimen has given way when its smoothed force falls by this share of its peak and stays below.
DROP = 0.10


@dataclass(frozen=True)
class Series:
    """One quantity of one channel on one specimen: `unit` of its values, `label` for people.

    `preload`: force at which the displacement of a pulled clamp was set to zero.
    """

    channel: str
    quantity: str
    unit: str
    specimen: int
    label: str
    preload: float = 0.0


@dataclass(frozen=True)
class Points:
    """Measured points as one vector.

    `owner` (n,) numbers `series`; displacement (or pressure, in `unit`), warp0, weft0 (n,) say where (NaN where it has
    no meaning); value (n,); `stated` (n,): stated standard deviation of the instrument, NaN when none was stated.
    """

    series: tuple[Series, ...]
    owner: IntArray
    displacement: Array
    warp0: Array
    weft0: Array
    value: Array
    stated: Array
    cuts: tuple[str, ...] = ()
    unit: str = "mm"

    def __len__(self) -> int:
        return len(self.value)

    @property
    def side(self) -> Array:
        """Sign (n,) of what is alike on both free edges: their weft coordinates move against each other."""
        weft = np.array([item.channel == EDGE and item.quantity == "weft" for item in self.series], dtype=bool)
        return np.where(weft[self.owner] & (self.weft0 < 0.0), -1.0, 1.0)

    def of(self, channel: str) -> BoolArray:
        """Return the mask (n,) of a channel."""
        return self._among((channel,))

    @property
    def curves(self) -> BoolArray:
        """The mask (n,) of curves of one value over the load."""
        return self._among(CURVES)

    @property
    def repeated(self) -> BoolArray:
        """The mask (n,) of channels with one file per specimen, between which specimens scatter."""
        return self._among((*CURVES, FIELD))

    def is_quantity(self, name: str) -> BoolArray:
        """Return the mask (n,) of a quantity, whatever its channel."""
        return np.isin(self.owner, [i for i, item in enumerate(self.series) if item.quantity == name])

    @property
    def specimen(self) -> IntArray:
        """Number (n,) of the specimen of each point, one for all quantities that were read of it."""
        keys = [(item.channel, item.specimen) for item in self.series]
        return np.array([keys.index(key) for key in keys], dtype=np.int64)[self.owner]

    @property
    def stations(self) -> tuple[float, ...]:
        """Loads at which it was measured, where they are few and what is measured bends sharply over them."""
        loads = np.unique(np.round(self.displacement[self.displacement > 0.0], 9))
        return tuple(loads.tolist()) if self.unit == "bar" and len(loads) <= MOST_STATIONS else ()

    def _among(self, channels: Sequence[str]) -> BoolArray:
        return np.isin(self.owner, [i for i, item in enumerate(self.series) if item.channel in channels])

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels, in their usual order."""
        present = {item.channel for item in self.series}
        return tuple(name for name in CHANNELS if name in present)

    def where(self, mask: BoolArray) -> Points:
        """Return the points of a mask; the series stay as they are."""
        return replace(
            self, owner=self.owner[mask], displacement=self.displacement[mask], warp0=self.warp0[mask],
            weft0=self.weft0[mask], value=self.value[mask], stated=self.stated[mask],
        )  # fmt: skip


@dataclass(frozen=True)
class Thinning:
    """Linear map from raw points to bins: `bin_of` (n,) numbers the bins, `count` (m,) raw points in each."""

    bin_of: IntArray
    count: Array

    def average(self, values: Array) -> Array:
        """Return bin averages (m, ...) of values (n, ...)."""
        if values.ndim == 1:
            return np.bincount(self.bin_of, values, minlength=len(self.count)) / self.count
        return np.stack([self.average(column) for column in values.T], axis=1)


def gather(measured: Measurements) -> Points:
    """Return all numeric channels of a test as points; each specimen is cut at its own force drop."""
    parts: list[Points] = []
    cuts = list(measured.notes)
    for number, curve in enumerate(measured.punch_force):
        end = force_drop(curve)
        if end < len(curve.force):
            cuts.append(f"{_stem(curve.file)} is cut at {curve.displacement[end - 1]:.1f} mm, where its force drops")
        parts.append(_force_points(curve, number, end))
    if measured.free_edge is not None:
        edge = measured.free_edge
        values = {"warp": edge.warp, "weft": edge.weft, "height": edge.height}
        # the sign of the weft coordinate says which of the two free edges it is
        side = np.where(edge.weft >= 0.0, np.inf, -np.inf)
        parts += _field(EDGE, values, edge.displacement, warp0=edge.warp0, weft0=side, unit="mm", noise=edge.noise)
    if measured.strain_field is not None:
        field = measured.strain_field
        values = {"strain_warp": field.strain_warp, "strain_weft": field.strain_weft}
        parts += _field(
            STRAIN, values, field.displacement, warp0=field.warp0, weft0=field.weft0, unit="", noise=field.noise
        )
    if measured.clamp_line is not None:
        clamp = measured.clamp_line
        nowhere = np.full(len(clamp.slip), np.nan)
        parts += _field(
            CLAMP, {"slip": clamp.slip}, clamp.displacement, warp0=nowhere, weft0=clamp.weft0, unit="mm",
            noise=clamp.noise,
        )  # fmt: skip
    if measured.mark_slip is not None:
        marks = measured.mark_slip
        parts += _field(
            SLIP, {"slip": marks.slip}, marks.angle, warp0=marks.warp0, weft0=marks.weft0, unit="mm", noise=marks.noise
        )
    for number, pull in enumerate(measured.clamp_force):
        parts.append(_curve_points(PULL, "force", "N", pull, number, pull.displacement, pull.force, pull.preload))
    for number, inflated in enumerate(measured.pressure_height):
        parts.append(_curve_points(HEIGHT, "height", "mm", inflated, number, inflated.pressure, inflated.height))
    for number, bent in enumerate(measured.joint_moment):
        parts.append(_curve_points(MOMENT, "moment", "N mm", bent, number, bent.angle, bent.moment))
    for number, rolled in enumerate(measured.moment_curvature):
        parts.append(_curve_points(BEND, "moment", "N m/m", rolled, number, rolled.curvature, rolled.moment))
    for number, seen in enumerate(measured.displacement_field):
        parts += _motion_points(seen, number, measured.centre)
    return replace(_joined(parts, tuple(cuts)), unit=load_unit(measured))


def load_unit(measured: Measurements) -> str:
    """Return the unit of what everything was measured over: mm of travel, bar, deg of a joint, 1/m of curvature."""
    if measured.pressure_height:
        return "bar"
    if measured.joint_moment or measured.mark_slip is not None:
        return "deg"
    if measured.moment_curvature:
        return "1/m"
    return measured.displacement_field[0].unit if measured.displacement_field else "mm"


def force_drop(curve: PunchForce) -> int:
    """Return how many points of a force curve come before the specimen gives way (all when it does not).

    The force, smoothed over five points, has to stay below 90 % of its largest value to the end of the record.
    """
    force = curve.force
    if len(force) < 10:
        return len(force)
    kernel = np.ones(5) / 5.0
    smooth = np.convolve(np.pad(force, 2, mode="edge"), kernel, mode="valid")
    peak = int(np.argmax(smooth))
    after = smooth[peak:]
    if after.min() > (1.0 - DROP) * smooth[peak] or after[-1] > (1.0 - DROP) * smooth[peak]:
        return len(force)
    return max(peak - 1, 5)


def thin(points: Points) -> Thinning:
    """Return bins over displacement and position such that no series keeps more points than it can tell apart."""
    number = np.zeros(len(points), dtype=np.int64)
    next_bin = 0
    for i, item in enumerate(points.series):
        own = np.flatnonzero(points.owner == i)
        if not len(own):
            continue
        bins, places = (CURVE_BINS, 1) if item.channel in CURVES else (FIELD_BINS, PLACE_BINS)
        if item.channel == FIELD:
            bins, places = MOTION_BINS, MOTION_PLACES
        key = _bins(points.displacement[own], bins)
        for place in (points.warp0[own], points.weft0[own]):
            if np.all(np.isfinite(place)):
                key = key * (places + 1) + _bins(place, places)
            elif np.any(np.isinf(place)):
                key = key * 2 + (place > 0.0)
        _, inverse = np.unique(key, return_inverse=True)
        number[own] = next_bin + inverse
        next_bin += int(inverse.max()) + 1
    return Thinning(number, np.bincount(number, minlength=next_bin).astype(float))


def thinned(points: Points, bins: Thinning) -> Points:
    """Return the bins as points: averages of place and value; stated noise falls with the root of the count."""
    first = np.zeros(len(bins.count), dtype=np.int64)
    first[bins.bin_of[::-1]] = np.arange(len(points))[::-1]
    return replace(
        points,
        owner=points.owner[first],
        displacement=bins.average(points.displacement),
        warp0=_average_place(points.warp0, bins, first),
        weft0=_average_place(points.weft0, bins, first),
        value=bins.average(points.value),
        stated=bins.average(points.stated) / np.sqrt(bins.count),
    )


def _average_place(place: Array, bins: Thinning, first: IntArray) -> Array:
    """Average coordinates; NaN and infinite ones (no coordinate, a side) are taken over."""
    finite = np.isfinite(place)
    return np.where(finite[first], bins.average(np.where(finite, place, 0.0)), place[first])


def _bins(values: Array, count: int) -> IntArray:
    """Number distinct values, or equal stretches of their range when there are more than `count`."""
    distinct, inverse = np.unique(np.round(values, 9), return_inverse=True)
    if len(distinct) <= count:
        return inverse.astype(np.int64)
    low, high = distinct[0], distinct[-1]
    return np.asarray(np.minimum(((values - low) / (high - low) * count).astype(np.int64), count - 1))


def _stem(file: str) -> str:
    return file.replace("\\", "/").rsplit("/", 1)[-1].rsplit(".", 1)[0]


def _force_points(curve: PunchForce, number: int, end: int) -> Points:
    nowhere = np.full(end, np.nan)
    noise = np.full(end, np.nan if curve.noise is None else curve.noise)
    series = (Series(FORCE, "force", "N", number, _stem(curve.file)),)
    return Points(
        series, np.zeros(end, dtype=np.int64), curve.displacement[:end], nowhere, nowhere, curve.force[:end], noise
    )


def _curve_points(
    channel: str, quantity: str, unit: str, item: ClampForce | PressureHeight | JointMoment | MomentCurvature,
    number: int, load: Array, value: Array, preload: float = 0.0,
) -> Points:  # fmt: skip
    """Return a curve of one specimen as points."""
    nowhere = np.full(len(load), np.nan)
    noise = np.full(len(load), np.nan if item.noise is None else item.noise)
    series = (Series(channel, quantity, unit, number, _stem(item.file), preload),)
    return Points(series, np.zeros(len(load), dtype=np.int64), load, nowhere, nowhere, value, noise)


def _motion_points(item: DisplacementField, number: int, centre: tuple[float, float]) -> list[Points]:
    """Return the three components of a field of one specimen as points, places counted from the piece's centre."""
    count, (warp0, weft0) = len(item.load), (item.places - np.array(centre)).T
    noise = np.full(count, np.nan if item.noise is None else item.noise)
    return [
        Points(
            (Series(FIELD, name, "mm", number, _stem(item.file)),), np.zeros(count, dtype=np.int64), item.load, warp0,
            weft0, value, noise,
        )
        for name, value in zip(("warp", "weft", "height"), item.motion.T, strict=True)
    ]  # fmt: skip


def _field(
    channel: str, values: dict[str, Array], displacement: Array, *, warp0: Array, weft0: Array, unit: str,
    noise: float | None,
) -> list[Points]:  # fmt: skip
    count = len(displacement)
    stated = np.full(count, np.nan if noise is None else noise)
    return [
        Points(
            (Series(channel, name, unit, 0, channel),), np.zeros(count, dtype=np.int64), displacement, warp0, weft0,
            value, stated,
        )
        for name, value in values.items()
    ]  # fmt: skip


def _joined(parts: Sequence[Points], cuts: tuple[str, ...]) -> Points:
    series = tuple(part.series[0] for part in parts)

    def all_of(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts]) if parts else np.zeros(0)

    owner = [np.full(len(part), i, dtype=np.int64) for i, part in enumerate(parts)]
    return Points(
        series, np.concatenate(owner) if parts else np.zeros(0, dtype=np.int64), all_of("displacement"),
        all_of("warp0"), all_of("weft0"), all_of("value"), all_of("stated"), cuts,
    )  # fmt: skip
