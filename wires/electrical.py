"""The entries of the report about resistance and nets, from the history of a run and its damage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from wires.circuit import Circuit, CircuitResult, circuit_result, linear_ohm_per_m, loss_of_circuit
from wires.damage import FailureResult
from wires.dependence import EventProbability
from wires.resistance import (
    Conductors,
    Net,
    NetResult,
    loss_of_net,
    net_results,
    opening_mm,
    resistance_ratio,
)


def electrical_report(
    history: WireHistory,
    damage: FailureResult,
    *,
    crimp: float | Array,
    nets: Sequence[Net] = (),
    circuits: Sequence[Circuit] = (),
    ohm_per_mm: Array | None = None,
) -> dict[str, Any]:
    """Return the keys `resistance` and `nets` of the report; R/R0 of an open wire is infinite (null there).

    ohm_per_mm (W,) of unstretched wire gives the linear electrical
    resistance of the tracks (EN 16812, ohm per metre of track), before and after.
    """
    conductors = Conductors.of(history, crimp=crimp)
    ratio = resistance_ratio(history, damage, conductors)
    return {
        "resistance": {
            "displacement_mm": history.displacement_mm,
            "ratio": [ratio[:, wire] for wire in range(ratio.shape[1])],
            "loop_opens_mm": opening_mm(damage),
            **_linear(history, conductors, ohm_per_mm, ratio),
        },
        "nets": [
            *(_net_row(result) for result in net_results(history, damage, conductors, nets)),
            *(_circuit_row(result) for result in _circuit_results(history, damage, conductors, circuits, ohm_per_mm)),
        ],
    }


def net_losses(
    history: WireHistory, damage: FailureResult, *, nets: Sequence[Net], circuits: Sequence[Circuit]
) -> list[EventProbability]:
    """Return the loss of each net in the order of the report, for samples of an ensemble."""
    return [
        *(loss_of_net(damage, net) for net in nets),
        *(loss_of_circuit(history, damage, circuit) for circuit in circuits),
    ]


def net_names(*, nets: Sequence[Net], circuits: Sequence[Circuit]) -> list[dict[str, Any]]:
    """Return what nets are, in the order of the report: their names, and the wires and loops or parts they connect."""
    return [*map(_net_name, nets), *map(_circuit_name, circuits)]


def _net_name(net: Net) -> dict[str, Any]:
    return {"name": net.name, "wire": net.wire, "from_loop": net.from_loop, "to_loop": net.to_loop}


def _circuit_name(circuit: Circuit) -> dict[str, Any]:
    return {"name": circuit.name, "wires": list(circuit.wires), "parts": list(circuit.parts)}


def _net_row(result: NetResult) -> dict[str, Any]:
    return {
        **_net_name(result.net),
        "state": "connected" if result.lost_at_mm is None else "lost",
        "lost_at_mm": result.lost_at_mm,
        "loss_probability": result.loss.value,
        "low": result.loss.low,
        "high": result.loss.high,
        "resistance_ratio": result.resistance_ratio,
    }


def _linear(history: WireHistory, conductors: Conductors, ohm_per_mm: Array | None, ratio: Array) -> dict[str, Any]:
    """Return the linear electrical resistance of each wire, ohm per metre, as made and at the end."""
    if ohm_per_mm is None:
        return {}
    before = linear_ohm_per_m(history.layout, conductors, history, ohm_per_mm)
    return {"linear_before_ohm_per_m": before, "linear_after_ohm_per_m": before * ratio[-1]}


def _circuit_results(
    history: WireHistory,
    damage: FailureResult,
    conductors: Conductors,
    circuits: Sequence[Circuit],
    ohm_per_mm: Array | None,
) -> list[CircuitResult]:
    """Return what became of the nets by name; none without resistivity."""
    if ohm_per_mm is None:
        return []
    return [circuit_result(history, damage, conductors, circuit, ohm_per_mm=ohm_per_mm) for circuit in circuits]


def _circuit_row(result: CircuitResult) -> dict[str, Any]:
    return {
        **_circuit_name(result.circuit),
        "state": "connected" if result.lost_at_mm is None else "lost",
        "lost_at_mm": result.lost_at_mm,
        "loss_probability": result.loss.value,
        "low": result.loss.low,
        "high": result.loss.high,
        "resistance_before_ohm": result.before_ohm,
        "resistance_after_ohm": result.after_ohm,
        "resistance_ratio": result.after_ohm / result.before_ohm if result.before_ohm > 0.0 else 1.0,
    }
