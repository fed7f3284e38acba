"""Whether noise explains what a hypothesis leaves, and what gives way when it does not.

The evidence compares hypotheses with each other; it does not say whether the best of them could have made the data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.decide.localise import scan
from etextile.diagnose.decide.rank import Contender
from etextile.diagnose.infer.fit import FORM, Evidence
from etextile.diagnose.infer.gauss import Whitener
from etextile.diagnose.infer.whitened import Workbench, scale
from etextile.diagnose.predict.table import EffectTable, each_with_its_own, superposed
from etextile.types import Array


# Chance below which what is left after the best effect counts as not explained by noise.
REST_LEVEL = 0.002
# Log score up to which an adequate hypothesis may be behind a leader that it rules out.
BEHIND = 10.0


@dataclass(frozen=True)
class Settled:
    """A contender after its own runs, the workbench with what these leave open, and the p-value of its rest.

    `simulated` False: its run on the finest lattice found no equilibrium.
    """

    contender: Contender
    bench: Workbench
    rest_p: float
    simulated: bool = True

    @property
    def ids(self) -> tuple[str, ...]:
        """Effects of the hypothesis."""
        return self.contender.ids

    @property
    def adequate(self) -> bool:
        """Whether noise explains what is left."""
        return self.rest_p >= REST_LEVEL


def falsified(settled: Sequence[Settled]) -> list[tuple[str, ...]]:
    """Return the leading hypotheses that are ruled out because a rival explains what they leave.

    A leader whose rest noise does not explain gives way to an adequate rival that is not far behind (`BEHIND`); not to
    one that only adds an effect to it, for which the evidence did not ask.
    """
    found: list[tuple[str, ...]] = []
    for leader in sorted(settled, key=lambda item: -item.contender.score):
        least = leader.contender.score - BEHIND
        rivals = [item for item in settled if item.adequate and item.contender.score > least]
        if leader.adequate or all(set(leader.ids) <= set(item.ids) for item in rivals):
            break
        found.append(leader.ids)
    return found


def rest_p_value(bench: Workbench, item: Contender, tables: Sequence[EffectTable], form: Array, *, seed: int) -> float:
    """Return the chance that noise alone leaves what the hypothesis leaves, by the same scan as for the gap."""
    mean = superposed(tables, item.evidence.best) + (0.0 if item.offset is None else item.offset)
    curves = [table.curve(own) for table, own in each_with_its_own(tables, item.evidence.best)]
    columns = [_tangents(item.evidence, tables), *(FORM * curve[:, None] * form for curve in curves)]
    freedom = np.concatenate(columns, axis=1)
    spread = freedom @ freedom.T
    whiteners = [Whitener.of(bench.covariance(s.scatter) + spread) for s in bench.scatters]
    weights = np.array([s.weight for s in bench.scatters])
    return scan(bench.points, bench.residual - mean, whiteners, weights, size=scale(bench), seed=seed).p_value


def _tangents(evidence: Evidence, tables: Sequence[EffectTable]) -> Array:
    """Return the posterior's principal changes (n, d): what the parameters may still take up."""
    centre = evidence.mean
    spread = (evidence.points - centre) * np.sqrt(evidence.weights)[:, None]
    values, vectors = np.linalg.eigh(spread.T @ spread)
    columns = []
    base = superposed(tables, centre)
    for value, vector in zip(values, vectors.T, strict=True):
        step = np.sqrt(max(value, 0.0)) * vector
        columns.append(2.0 * (superposed(tables, centre + step) - base))
    return np.stack(columns, axis=1)
