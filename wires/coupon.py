"""What a criterion says of loops in a fabric that is stretched evenly along the warp: the paper's tensile coupons."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from wires.damage import FailureResult
from wires.failure import judge_of
from wires.layout import lay_out


SPACING_MM, LOOP_MM = 20.0, 4.0


def stretched(
    strain: Array,
    criterion: str,
    *,
    parameters: Mapping[str, float] | None = None,
    slack: float = 0.02,
    crimp: float = 0.02,
) -> FailureResult:
    """Return the judgement of one loop per fabric strain (n,), each stretched from zero to it in one step.

    The wire is taut after its slack and crimp, with the strain (1 + e) / (1 + excess) - 1. The loops are those of the
    calibration, so that its doubt cancels. `parameters` as in `wires.failure.judge_of`; raises BadInput for those that
    are not allowed.
    """
    final = np.asarray(strain, dtype=float)
    span = np.stack([np.zeros_like(final), final])
    layout = lay_out(
        length_mm=SPACING_MM * len(final),
        width_mm=10.0,
        wire_spacing_mm=10.0,
        loop_spacing_mm=SPACING_MM,
        loop_length_mm=LOOP_MM,
        loop_slack=slack,
        loop_offset_mm=0.5 * SPACING_MM * (len(final) - 1),
    )
    start = np.append(layout.start_mm[0], layout.loop_entry_mm)
    middle = 0.5 * (start + np.append(layout.loop_exit_mm, layout.end_mm[0]))
    history = WireHistory(
        displacement_mm=np.array([0.0, 1.0]),
        span_strain=span,
        wire_strain=np.maximum((1.0 + span) / (1.0 + slack) - 1.0, 0.0),
        element_wire=np.zeros(len(middle), dtype=np.int64),
        element_warp_mm=middle,
        element_strain=np.maximum((1.0 + _woven(span)) / (1.0 + crimp) - 1.0, 0.0),
        layout=layout,
    )
    return judge_of(criterion, parameters).calibrated_here.judge(history)


def _woven(span: Array) -> Array:
    """Return the strain (2, n + 1) of the weave around loops: of both neighbours the greater."""
    edge = np.zeros((len(span), 1))
    return np.maximum(np.hstack([edge, span]), np.hstack([span, edge]))
