"""Validity audit: which internal variables leave the range they were identified in, and when.

An effect is likeliest where the model is used beyond what it was identified for. The audit says from which displacement
on each internal variable of the base run is outside of its range, beside the onset of the gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.observe import PEAKS, Record
from etextile.diagnose.predict.parameters import BaseParameters
from etextile.types import Array


COUPON_RATE = 1.67e-3
"""Strain rate of the coupons, 1/s (Beex et al., section 2)."""


@dataclass(frozen=True)
class AuditRow:
    """One internal variable: its identified range, the load at which it leaves it (None: never), its values."""

    variable: str
    unit: str
    limit: float | None
    leaves: float | None
    at_onset: float | None
    at_end: float
    remark: str


def audit(record: Record, base: BaseParameters, onset: float | None) -> tuple[AuditRow, ...]:
    """Return the audit of a base run, the variables that are outside first at the onset in front.

    What a run does not keep (the line force of a round clamp, a rate over pressure) is left out.
    """
    limits: dict[str, tuple[float | None, str, str]] = {
        "warp_strain": (base.ranges[0][1], "", "warp coupons end there"),
        "weft_strain": (base.ranges[1][1], "", "weft coupons end there"),
        "diagonal_strain": (base.ranges[2][1], "", "bias coupons end there"),
        "clamp_line_force": (None, "N/mm", "what the clamps hold was not measured"),
        "shear_angle": (
            _shear_limit(base.ranges[2][1]),
            "deg",
            "largest shear of the bias coupons, pure trellis shear",
        ),
        "strain_rate": (COUPON_RATE, "1/s", "rate of the coupons"),
    }
    rows = []
    for column, name in enumerate(PEAKS):
        limit, unit, remark = limits[name]
        values = record.peaks[:, column]
        if not values.any() and name in ("clamp_line_force", "strain_rate"):
            continue
        leaves = None if limit is None else _crossing(record.displacement, values, limit)
        at_onset = None if onset is None else float(np.interp(onset, record.displacement, values))
        rows.append(AuditRow(name, unit, limit, leaves, at_onset, float(values[-1]), remark))
    return tuple(sorted(rows, key=lambda row: (row.leaves is None, row.leaves or 0.0)))


def _shear_limit(strain: float) -> float:
    """Return the shear angle (deg) at which trellis shear stretches a coupon at 45 deg by `strain`.

    (1 + strain)^2 = 1 + sin(gamma).
    """
    return float(np.degrees(np.arcsin(min(1.0, (1.0 + strain) ** 2 - 1.0))))


def _crossing(displacement: Array, values: Array, limit: float) -> float | None:
    """Return where values first pass the limit, interpolated."""
    above = np.flatnonzero(values > limit)
    if not len(above):
        return None
    i = int(above[0])
    if i == 0:
        return float(displacement[0])
    share = (limit - values[i - 1]) / (values[i] - values[i - 1])
    return float(displacement[i - 1] + share * (displacement[i] - displacement[i - 1]))
