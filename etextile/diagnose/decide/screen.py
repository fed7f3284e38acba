"""Screen: how strongly each effect answers the difference, which look alike, and which these channels cannot show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.decide.rank import VISIBLE, visible
from etextile.diagnose.infer.fit import Evidence, ScatterSample
from etextile.diagnose.predict.table import EffectTable
from etextile.types import Array


ALIKE = 0.95


@dataclass(frozen=True)
class Screening:
    """Signed score z of every visible effect; groups that look alike after the base parameters are projected out; the
    effects that cannot be seen.
    """

    scores: dict[str, float]
    groups: tuple[tuple[str, ...], ...]
    unseen: tuple[str, ...]

    def partners(self, name: str) -> tuple[str, ...]:
        """Return the effects that look like `name`."""
        return tuple(other for group in self.groups if name in group for other in group if other != name)


def screen(sample: ScatterSample, tables: Mapping[str, EffectTable], fits: Mapping[str, Evidence]) -> Screening:
    """Score each effect at its best fit: z = d^T C^-1 r / sqrt(d^T C^-1 d), C including the base parameters.

    Two effects look alike when the cosine of their whitened changes exceeds 0.95.
    """
    size = visible(tables, sample)
    seen = [name for name in tables if size[name] >= VISIBLE]
    curves = {name: sample.whiten(_direction(tables[name], fits.get(name))) for name in seen}
    units = {name: curve / max(float(np.linalg.norm(curve)), 1e-12) for name, curve in curves.items()}
    scores = {name: float(unit @ sample.residual) for name, unit in units.items()}
    return Screening(scores, _groups(units), tuple(name for name in tables if name not in seen))


def _direction(table: EffectTable, fit: Evidence | None) -> Array:
    """Return the change at the best fit, or the largest one of the table when the fit is nothing."""
    if fit is not None and np.isfinite(fit.log_best):
        curve = table.curve(fit.best)
        if np.any(curve != 0.0):
            return curve
    curves = table.basis @ table.amplitudes[:, table.valid]
    return np.asarray(curves[:, int(np.argmax(np.abs(curves).sum(axis=0)))])


def _groups(units: Mapping[str, Array]) -> tuple[tuple[str, ...], ...]:
    """Return connected sets of at least two effects that look alike."""
    names = list(units)
    parent = {name: name for name in names}

    def root(name: str) -> str:
        while parent[name] != name:
            name = parent[name]
        return name

    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            if abs(float(units[first] @ units[second])) > ALIKE:
                parent[root(second)] = root(first)
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(root(name), []).append(name)
    return tuple(tuple(group) for group in groups.values() if len(group) > 1)
