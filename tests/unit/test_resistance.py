"""Resistance of wires, open circuits and nets: against the arithmetic of a wire drawn by hand."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from loadcases.build import plan
from loadcases.reader import load_case
from wires.damage import FailureResult
from wires.electrical import electrical_report
from wires.failure import evaluate
from wires.layout import WireLayout, lay_out
from wires.resistance import Conductors, Net, net_results, opening_mm, resistance_ratio


CRIMP = 0.01


def layout(slack: float = 0.0) -> WireLayout:
    """One wire of 60 mm with loops of 4 mm at -20, 0 and 20 mm."""
    return lay_out(
        length_mm=60, width_mm=6, wire_spacing_mm=6.0, loop_spacing_mm=20.0, loop_length_mm=4.0, loop_slack=slack
    )


def history(loops: Array, elements: Array, *, slack: float = 0.0) -> WireHistory:
    """History of wire strains (S, 3) in the loops and (S, 4) in the woven-in stretches between them."""
    return WireHistory(
        displacement_mm=np.arange(float(len(loops))),
        span_strain=(1.0 + loops) * (1.0 + slack) - 1.0,
        wire_strain=loops,
        element_wire=np.zeros(4, dtype=np.int64),
        element_warp_mm=np.array([-26.0, -10.0, 10.0, 26.0]),
        element_strain=elements,
        layout=layout(slack),
    )


def judged(found: WireHistory, **parameters: float) -> FailureResult:
    return evaluate(found, "wire_strain", parameters={"filaments": 7.0, "scatter": 0.0, **parameters})


def ratio_at_end(found: WireHistory, damage: FailureResult) -> float:
    return float(resistance_ratio(found, damage, Conductors.of(found, crimp=CRIMP))[-1, 0])


def steps(*rows: tuple[float, float, float]) -> Array:
    return np.array([(0.0, 0.0, 0.0), *rows])


def test_lengths_as_mounted_add_up_to_the_wire() -> None:
    found = Conductors.of(history(steps((0.0, 0.0, 0.0)), np.zeros((2, 4)), slack=0.02), crimp=CRIMP)
    assert found.loop_mm == pytest.approx(4.0 * 1.02)
    assert found.element_mm == pytest.approx(np.array([8.0, 16.0, 16.0, 8.0]) * 1.01)


def test_an_evenly_stretched_wire_follows_the_law_of_constant_volume() -> None:
    found = history(steps((0.05, 0.05, 0.05)), np.concatenate([np.zeros((1, 4)), np.full((1, 4), 0.05)]))
    assert ratio_at_end(found, judged(found)) == pytest.approx(1.05**2)


def test_broken_filaments_add_resistance_over_the_length_of_their_loop() -> None:
    """R/R0 = 1 + (c/L) k/(N - k) for k of N filaments broken over a length c of a wire of length L."""
    found = history(steps((0.0, 1e-9, 0.0)), np.zeros((2, 4)))
    damage = judged(found, onset=1e-10, scale=1e-9 / np.log(7 / 4), shape=1.0)  # 3 of 7 broken
    whole = 12.0 + 48.0 * (1.0 + CRIMP)
    assert ratio_at_end(found, damage) == pytest.approx(1.0 + 4.0 / whole * 3.0 / 4.0, rel=1e-6)


def test_resistance_does_not_come_back_and_is_infinite_once_a_loop_is_open() -> None:
    found = history(steps((0.06, 0.06, 0.06), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 0.0, 0.0)), np.zeros((5, 4)))
    ratio = resistance_ratio(found, judged(found), Conductors.of(found, crimp=CRIMP))[:, 0]
    assert ratio[0] == 1.0
    assert ratio[2] == ratio[1] > 1.0
    assert np.isinf(ratio[3:]).all()


def test_a_net_is_lost_with_the_first_of_its_own_loops() -> None:
    found = history(steps((0.0, 0.0, 0.04), (0.0, 0.0, 0.5), (0.5, 0.0, 0.5)), np.zeros((4, 4)))
    damage = judged(found)
    nets = [Net("left", 0, 0, 1), Net("right", 0, 2, 1), Net("middle", 0, 1, 1)]
    left, right, middle = net_results(found, damage, Conductors.of(found, crimp=CRIMP), nets)
    opened = opening_mm(damage)
    assert right.lost_at_mm == pytest.approx(opened[2])
    assert 1.0 < opened[2] < 2.0 < opened[0] < 3.0
    assert left.lost_at_mm == pytest.approx(opened[0])
    assert (middle.lost_at_mm, middle.loss.value, middle.resistance_ratio) == (None, 0.0, 1.0)
    assert np.isinf(right.resistance_ratio)
    assert right.loss.value == pytest.approx(1.0)


def test_the_report_tells_lost_nets() -> None:
    found = history(steps((0.0, 0.0, 0.5)), np.zeros((2, 4)))
    report = electrical_report(found, judged(found), crimp=CRIMP, nets=[Net("lamp", 0, 1, 2)])
    assert (report["nets"][0]["state"], report["nets"][0]["name"]) == ("lost", "lamp")
    assert report["resistance"]["ratio"][0][0] == 1.0


def test_a_repeated_case_says_that_the_fabric_was_identified_for_loading_alone() -> None:
    once, again = (load_case("elbow", overrides=more).case for more in ([], ["motion.path=[40, 0, 40]"]))
    assert not any("monotonic" in note for note in plan(once)["notes"])
    assert any("identified for monotonic loading" in note for note in plan(again)["notes"])
