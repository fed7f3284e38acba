"""How much slack each loop needs: the inverse of judging loops, from the strain of the fabric under them alone.

A loop straightens before its wire stretches, so with the greatest span strain e a slack s leaves (1 + e) / (1 + s) - 1
in the wire (with a rigid component of share c of the span (1 + e - c) / (1 + s - c) - 1). The wires hardly change the
fabric's strain, so one simulation serves for every slack. The wire is taken as perfectly bonded: where it slides, the
weave beside a loop shares its slack, and the sizes found here are too small (see `wires.slip`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.types import Array
from wires.failure import CRITERIA, resolve
from wires.history import WireHistory


BISECTIONS = 40
LARGEST = 0.5
"""Slack beyond which no loop is made: half as long again as the fabric it spans."""


@dataclass(frozen=True)
class LoopSizes:
    """Slack (L,) each loop needs, NaN where no slack up to the largest is enough; probability now and with it (L,)."""

    target: float
    slack: Array
    probability_now: Array
    probability: Array

    @property
    def everywhere(self) -> float:
        """Least slack that serves all loops; NaN when there is none."""
        return float(self.slack.max(initial=0.0))


def with_slack(history: WireHistory, slack: Array) -> WireHistory:
    """Return the history of loops with other slacks (L,) under the same fabric strain, perfectly bonded."""
    layout = history.layout.with_loop_slack(slack)
    rigid = layout.loop_rigid_mm / layout.loop_span_mm
    strain = (1.0 + history.span_strain - rigid) / (1.0 + layout.loop_slack - rigid) - 1.0
    return replace(history, wire_strain=np.maximum(strain, 0.0), layout=layout)


def size_loops(
    history: WireHistory,
    target: float,
    *,
    criterion: str = "wire_strain",
    parameters: Mapping[str, float] | None = None,
    largest: float = LARGEST,
) -> LoopSizes:
    """Return the least slack of each loop with a failure probability of at most `target`, by bisection.

    Raises BadInput for a criterion that does not credit a loop with its slack.
    """
    if not 0.0 < target < 1.0:
        raise BadInput.of(f"must lie between 0 and 1 (got {target:g})", key="target")
    judge, values = CRITERIA[criterion], resolve(criterion, parameters or {})

    def probability(slack: Array) -> Array:
        return judge.evaluate(with_slack(history, slack), values).failure_probability

    count = history.layout.n_loops
    low, high = np.zeros(count), np.full(count, largest)
    at_none, at_most = probability(low), probability(high)
    if (at_most >= at_none)[at_none > target].any() and np.array_equal(at_most, at_none):
        raise BadInput.of(
            f"the criterion {criterion!r} does not ask for the slack of loops, take wire_strain or filament_bundle",
            key="failure.criterion",
        )
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        enough = probability(middle) <= target
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    slack = np.where(at_none <= target, 0.0, np.where(at_most <= target, high, np.nan))
    return LoopSizes(
        target, slack, probability(history.layout.loop_slack), probability(np.nan_to_num(slack, nan=largest))
    )
