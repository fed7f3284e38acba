"""Classes: which effects the measured channels could not tell from one that was found, whatever the data say.

Two effects are of one class when the change that one makes can be imitated by the other, anywhere in its range, to
within what noise, specimen scatter, fabric parameters, the lattice and the unknown form of a law hide. This is worked
out from the simulated changes; no card lists it.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from etextile.diagnose.decide.rank import VISIBLE, Contender
from etextile.diagnose.infer.fit import FORM
from etextile.diagnose.infer.gauss import Whitener
from etextile.diagnose.infer.lattice_doubt import facing
from etextile.diagnose.infer.whitened import MEAN_LOOSE, Workbench
from etextile.diagnose.predict.table import EffectTable
from etextile.types import Array


Classes = tuple[tuple[str, ...], ...]
"""One class per effect of a hypothesis, the effect itself first; of an effect that is told from all others it alone."""
AXIS_POINTS = {1: 161, 2: 41}
"""Values per parameter at which an imitation is looked for, by the number of parameters."""
ZOOMS, ZOOM = 3, 0.1
"""How often it is looked for again around the best, and how far on either side as a share of the range before."""


def classes_of(item: Contender, bench: Workbench, tables: Mapping[str, EffectTable], form: Array) -> Classes:
    """Return the class of every effect of a hypothesis at its likeliest parameters, the effect itself first."""
    return tuple(
        class_of(table.id, table.curve(at), bench, tables, form, without=item.ids) for table, at in item.parts(tables)
    )


def class_of(
    name: str,
    curve: Array,
    bench: Workbench,
    tables: Mapping[str, EffectTable],
    form: Array,
    *,
    without: Sequence[str] = (),
) -> tuple[str, ...]:
    """Return an effect and all others that could stand in for its change (n,), the closest first.

    `form` (n, m): smooth unit factors of an effect's form; `without`: effects that are there already.
    """
    others = [other for other in tables if other != name and other not in without]
    far = {other: distance(curve, bench, tables[name], tables[other], form) for other in others}
    return (name, *sorted((other for other in others if far[other] < VISIBLE), key=far.__getitem__))


def distance(curve: Array, bench: Workbench, own: EffectTable, other: EffectTable, form: Array) -> float:
    """Return the least distance, in standard deviations, of a change (n,) to those that another effect can make.

    min over parameters of |L^-1 (d - d')| with L L^T = C + F F^T; C: covariance of the difference as both effects face
    it (fabric parameters within their covariance, lattice, scatter, noise); F: the change times its smooth factors.
    """
    factors = FORM * form * curve[:, None]
    whiten = Whitener.of(_faced(bench, (own, other)) + factors @ factors.T)
    target, basis, closest = whiten(curve), whiten(other.basis), float("inf")
    whole = np.asarray(other.bounds)
    low, high = whole[:, 0], whole[:, 1]
    for _ in range(ZOOMS):
        points = _lattice(low, high)
        amplitudes, valid = other.coefficients(points)
        left = np.linalg.norm(target - amplitudes @ basis.T, axis=1)
        left[~valid] = np.inf
        index = int(np.argmin(left))
        closest = min(closest, float(left[index]))
        reach = ZOOM * (high - low)
        low, high = np.maximum(points[index] - reach, whole[:, 0]), np.minimum(points[index] + reach, whole[:, 1])
    return closest


def _faced(bench: Workbench, tables: Sequence[EffectTable]) -> Array:
    """Return the mean covariance (n, n) that a hypothesis of these effects faces, from that of the base."""
    faced, found = facing(bench, tables), bench.mean_covariance
    found = found if faced.doubt is None else found + faced.doubt
    return np.asarray(found if faced.loose is None else found + MEAN_LOOSE**2 * faced.loose)


def _lattice(low: Array, high: Array) -> Array:
    """Return evenly spaced points (b, d) between two corners (d,)."""
    count = AXIS_POINTS[len(low)]
    return np.array(list(itertools.product(*np.linspace(low, high, count).T)))
