"""What explanations say of a test that is not yet measured, or that is measured now: mean and what it leaves open.

An explanation brings its effects at the likeliest parameters and, one run each, the directions in which the first
measurements leave these open. So a further test costs a few runs per explanation, whatever the size of the library.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.decide.rank import Contender
from etextile.diagnose.infer.fit import Evidence
from etextile.diagnose.predict.run_tables import Candidate, specs_at
from etextile.diagnose.predict.simulate import EffectSpec
from etextile.diagnose.predict.table import EffectTable
from etextile.types import Array


OPEN = 0.01
"""Share of a parameter's range below which a posterior deviation is not worth a run."""


@dataclass(frozen=True)
class Explanation:
    """Effects that may act, with their probability; `specs` at the likeliest parameters, `moved` one deviation off.

    In `moved` one principal direction of the posterior each.
    """

    contender: Contender
    probability: float
    specs: tuple[EffectSpec, ...]
    moved: tuple[tuple[EffectSpec, ...], ...]

    @property
    def ids(self) -> tuple[str, ...]:
        """Effects of the explanation."""
        return self.contender.ids

    @property
    def label(self) -> str:
        """Name in tables."""
        return self.contender.label

    def requests(self, without: Sequence[str] = ()) -> list[tuple[EffectSpec, ...]]:
        """Return the effects to be run, likeliest first; those of `without` cannot act in the test."""
        return [tuple(item for item in one if item.id not in without) for one in (self.specs, *self.moved)]


def explanation(
    contender: Contender, probability: float, tables: Mapping[str, EffectTable], candidates: Sequence[Candidate]
) -> Explanation:  # fmt: skip
    """Return a hypothesis ready to be run in another test."""
    chosen = [tables[name] for name in contender.ids]
    bounds = np.concatenate([table.bounds for table in chosen])
    points = [np.clip(contender.evidence.best + step, *bounds.T) for step in directions(contender.evidence, bounds)]
    best, *moved = (specs_at(chosen, candidates, point) for point in (contender.evidence.best, *points))
    return Explanation(contender, probability, best, tuple(moved))


def directions(evidence: Evidence, bounds: Array) -> list[Array]:
    """Return the principal axes of the posterior (d,), one standard deviation each, away from the nearer bound."""
    centre = evidence.mean
    apart = (evidence.points - centre) * np.sqrt(evidence.weights / evidence.weights.sum())[:, None]
    values, vectors = np.linalg.eigh(apart.T @ apart)
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        step = np.sqrt(max(float(value), 0.0)) * vector
        if np.abs(step / np.ptp(bounds, axis=1)).max() < OPEN:
            continue
        ahead, behind = (np.clip(evidence.best + sign * step, *bounds.T) - evidence.best for sign in (1.0, -1.0))
        found.append(step if np.abs(ahead).sum() >= np.abs(behind).sum() else -step)
    return found


@dataclass(frozen=True)
class Foretold:
    """What an explanation says of a test: mean (n,) and covariance (n, n) of what is measured, noise included.

    `completed`: its run found an equilibrium as far as is measured.
    """

    label: str
    probability: float
    mean: Array
    covariance: Array
    completed: bool = True

    @property
    def deviation(self) -> Array:
        """Standard deviation (n,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))
