"""The entries of the report about resistance, nets and cyclic life, from the history of a run and its damage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from wires.damage import FailureResult
from wires.fatigue import CoffinManson, cyclic_life
from wires.history import WireHistory
from wires.resistance import Conductors, Net, NetResult, net_results, opening_mm, resistance_ratio


def electrical_report(
    history: WireHistory,
    damage: FailureResult,
    *,
    crimp: float,
    nets: Sequence[Net] = (),
    cyclic: CoffinManson | None = None,
) -> dict[str, Any]:
    """Return the keys `resistance`, `nets` and `cyclic` of the report; R/R0 of an open wire is infinite (null there).

    `cyclic` is null unless the case gives coefficients.
    """
    conductors = Conductors.of(history, crimp=crimp)
    ratio = resistance_ratio(history, damage, conductors)
    return {
        "resistance": {
            "displacement_mm": history.displacement_mm,
            "ratio": [ratio[:, wire] for wire in range(ratio.shape[1])],
            "loop_opens_mm": opening_mm(damage),
        },
        "nets": [_net_row(result) for result in net_results(history, damage, conductors, nets)],
        "cyclic": None if cyclic is None else cyclic_life(history, cyclic),
    }


def _net_row(result: NetResult) -> dict[str, Any]:
    net = result.net
    return {
        "name": net.name,
        "wire": net.wire,
        "from_loop": net.from_loop,
        "to_loop": net.to_loop,
        "state": "connected" if result.lost_at_mm is None else "lost",
        "lost_at_mm": result.lost_at_mm,
        "loss_probability": result.loss.value,
        "low": result.loss.low,
        "high": result.loss.high,
        "resistance_ratio": result.resistance_ratio,
    }
