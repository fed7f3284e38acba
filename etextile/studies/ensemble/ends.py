"""What becomes of the garment and of its nets at the end of the motion, over all samples.

A probability has two intervals. `low` and `high` are those of the samples (`etextile.ensemble.statistics`), which more
samples narrow. `calibration_low` and `calibration_high` are what the coupons leave unknown, as `low` and `high` of a
run: in every sample the 2.5 and 97.5 % points of the doubt about the calibration (`wires.dependence`), which is one for
all of them, so that points of the mean are means of the points.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from etextile.ensemble.statistics import probability
from etextile.ensemble.store import DONE, Sample
from etextile.types import Array, BoolArray
from loadcases.nets import circuits_of, numbered_nets
from loadcases.schema import Case
from wires.electrical import net_names


def of_garment(samples: Sequence[Sample]) -> dict[str, dict[str, float]]:
    """Return what the coupons leave unknown of the chances that any wire is lost, by the names of the specimen."""
    ends = np.stack([sample.any_at_end for sample in samples])
    ended = _ended(samples)
    return {
        name: _calibration(ends[:, row], ended)
        for row, name in enumerate(("any_failure", "any_open"))
    }  # fmt: skip


def of_nets(case: Case, samples: Sequence[Sample]) -> list[dict[str, Any]]:
    """Return the nets of a case as `nets` of a run names them, each with the probability that it is lost."""
    names = net_names(nets=numbered_nets(case), circuits=circuits_of(case))
    ends = np.stack([sample.nets_at_end for sample in samples])
    return [{**name, **_loss(ends[:, row], _ended(samples))} for row, name in enumerate(names)]


def _loss(ends: Array, ended: BoolArray) -> dict[str, float]:
    """Return the mean of events (N, 3) with both intervals; runs that broke off lose the net for certain, or not."""
    found = probability(ends[:, 0], np.where(ended, ends[:, 0], 1.0))
    value, low, high = (float(part) for part in (found.value, found.low, found.high))
    return {"loss_probability": value, "low": low, "high": high, **_calibration(ends, ended)}


def _calibration(ends: Array, ended: BoolArray) -> dict[str, float]:
    """Return the ends of events (N, 3) by what the coupons leave unknown."""
    high = np.where(ended, ends[:, 2], 1.0)
    return {"calibration_low": float(ends[:, 1].mean()), "calibration_high": float(high.mean())}


def _ended(samples: Sequence[Sample]) -> BoolArray:
    return np.array([sample.status == DONE for sample in samples])
