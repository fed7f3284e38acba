"""The panels that pictures of a diagnosis are drawn from: one per quantity, full fields at the place of their gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.points import Points
from etextile.diagnose.decide.where import GapPlace
from etextile.types import Array, IntArray
from etextile.vocabulary import CURVES
from viz.diagnosis_plots import Panel, Readings, Simulated


MOST_PANELS = 9
PER_CENT = 100.0
"""Strains are drawn in per cent."""
NAMES = {
    ("punch_force", "force"): "punch force",
    ("clamp_force", "force"): "force of the clamp",
    ("pressure_height", "height"): "height",
    ("moment_curvature", "moment"): "bending moment per width",
    ("displacement_field", "warp"): "motion along the warp",
    ("displacement_field", "weft"): "motion along the weft",
    ("displacement_field", "height"): "height",
    ("free_edge", "warp"): "edge along the warp",
    ("free_edge", "weft"): "edge along the weft",
    ("free_edge", "height"): "height of the edge",
    ("strain_field", "strain_warp"): "warp strain",
    ("strain_field", "strain_weft"): "weft strain",
    ("clamp_line", "slip"): "slip at the clamp",
    ("joint_moment", "moment"): "moment of the joint",
    ("mark_slip", "slip"): "slip along the skin",
}


@dataclass(frozen=True)
class Predicted:
    """Prediction (N,) at the raw points with its standard deviation (N,)."""

    value: Array
    deviation: Array


@dataclass(frozen=True)
class ComparedCurves:
    """What is drawn at the raw points (N,): predictions before and after, deviation of measured minus simulated.

    `held_out` (N,): prediction with the effect as fitted up to `split` (mm), drawn beyond it.
    """

    before: Predicted
    noise: Array
    after: Predicted | None = None
    held_out: Array | None = None
    split: float | None = None


def panels(raw: Points, compared: ComparedCurves, *, places: Sequence[GapPlace] = ()) -> tuple[Panel, ...]:
    """Return the panels of all quantities, those with a gap first, the force always in front."""
    found = []
    for key in _quantities(raw):
        numbers = [i for i, item in enumerate(raw.series) if (item.channel, item.quantity) == key]
        own = np.flatnonzero(np.isin(raw.owner, numbers))
        spot, words = own, ""
        if key[0] not in CURVES:
            spot, words = _place_of_gap(raw, own, (raw.value - compared.before.value) / compared.noise)
        place = next((item for item in places if (item.channel, item.quantity) == key), None)
        strength = abs(place.z) if place is not None else 0.0
        title = f"{NAMES.get(key, ' '.join(key))}{words}"
        found.append((key[0] not in CURVES, -strength, _panel(raw, spot, compared, title=title, place=place)))
    order = sorted(range(len(found)), key=lambda i: found[i][:2])
    return tuple(found[i][2] for i in order[:MOST_PANELS])


def _quantities(raw: Points) -> list[tuple[str, str]]:
    return list(dict.fromkeys((item.channel, item.quantity) for item in raw.series))


def _place_of_gap(raw: Points, own: IntArray, z: Array) -> tuple[IntArray, str]:
    """Return the points (k,) at the material point whose difference is largest, and where that is."""
    key = np.stack([np.nan_to_num(raw.warp0[own], posinf=1e6, neginf=-1e6),
                    np.nan_to_num(raw.weft0[own], posinf=1e6, neginf=-1e6)], axis=1)  # fmt: skip
    spots, number = np.unique(np.round(key, 6), axis=0, return_inverse=True)
    number = number.ravel()
    finite = np.where(np.isfinite(z[own]), z[own], 0.0)
    size = np.bincount(number, finite**2, minlength=len(spots))
    best = int(np.argmax(size))
    chosen = own[number == best]
    parts = []
    for name, value in (("x", raw.warp0[chosen[0]]), ("y", raw.weft0[chosen[0]])):
        if np.isfinite(value):
            parts.append(f"{name} = {value:.3g}")
    return chosen, f" at {', '.join(parts)} mm" if parts else ""


def _panel(raw: Points, spot: IntArray, compared: ComparedCurves, *, title: str, place: GapPlace | None) -> Panel:
    series = raw.series[int(raw.owner[spot[0]])]
    factor = 1.0 if series.unit else PER_CENT
    before, after = compared.before, compared.after
    readings = []
    for owner in np.unique(raw.owner[spot]):
        mine = spot[raw.owner[spot] == owner]
        mine = mine[np.argsort(raw.displacement[mine], kind="stable")]
        value = factor * raw.value[mine]
        rest = None if after is None else value - factor * after.value[mine]
        readings.append(Readings(raw.displacement[mine], value, value - factor * before.value[mine], rest))
    beyond = None
    if compared.held_out is not None and compared.split is not None:
        late = spot[raw.displacement[spot] > compared.split]
        exact = Predicted(compared.held_out, np.zeros(len(raw)))
        beyond = _curve(raw, late, exact, factor=factor) if len(late) else None
    return Panel(
        channel=series.channel,
        title=title,
        unit=series.unit or "%",
        readings=tuple(readings),
        before=_curve(raw, spot, before, factor=factor),
        noise=_curve(raw, spot, Predicted(before.value, compared.noise), factor=factor).deviation,
        after=None if after is None else _curve(raw, spot, after, factor=factor),
        held_out=beyond,
        onset=None if place is None else (place.onset.at, place.onset.low, place.onset.high),
        split=compared.split,
        load_unit=raw.unit,
    )


def _curve(raw: Points, spot: IntArray, predicted: Predicted, *, factor: float) -> Simulated:
    """Return a prediction as one curve over the displacements of all specimens, where it is defined."""
    chosen = spot[np.isfinite(predicted.value[spot])]
    at, first = np.unique(np.round(raw.displacement[chosen], 9), return_index=True)
    kept = chosen[first]
    return Simulated(at, factor * predicted.value[kept], factor * predicted.deviation[kept])
