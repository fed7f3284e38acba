"""Life under repeated loading: rainflow against the example of the standard, laws and chances against arithmetic."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import norm

from etextile.errors import BadInput
from etextile.results.wire_history import WireHistory
from loadcases.judging import life_spec
from loadcases.reader import load_case
from wires.damage import FailureResult
from wires.failure import judge_of
from wires.fatigue import CoffinManson, Cycles, StrainTable, swings
from wires.layout import WireLayout, lay_out
from wires.life import LifeSpec, life_of


LAW = CoffinManson(0.2, -0.5, "own tests")


def layout() -> WireLayout:
    """One wire of 60 mm with loops of 4 mm at -20, 0 and 20 mm."""
    return lay_out(
        length_mm=60, width_mm=6, wire_spacing_mm=6.0, loop_spacing_mm=20.0, loop_length_mm=4.0, loop_slack=0
    )


def history(motion: list[float], *loops: tuple[float, float, float]) -> WireHistory:
    strain = np.array(loops)
    return WireHistory(
        displacement_mm=np.array(motion),
        span_strain=strain,
        wire_strain=strain,
        element_wire=np.zeros(4, dtype=np.int64),
        element_warp_mm=np.array([-26.0, -10.0, 10.0, 26.0]),
        element_strain=np.zeros((len(motion), 4)),
        layout=layout(),
    )


def judged(found: WireHistory) -> FailureResult:
    return judge_of("wire_strain").judge(found)


def test_the_example_of_the_standard_is_counted_as_there() -> None:
    """ASTM E1049, figure 6: -2, 1, -3, 5, -1, 3, -4, 4, -2 gives these ranges and counts."""
    found = swings(np.array([-2.0, 1, -3, 5, -1, 3, -4, 4, -2]))
    counts: dict[float, float] = {}
    for size, count in zip(found.ranges, found.counts, strict=True):
        counts[size] = counts.get(size, 0.0) + count
    assert counts == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    assert found.largest == (9.0, 0.5)


@pytest.mark.parametrize("series", [[0.0, 0.02], [0.0, 0.0, 0.02], [0.02, 0.0], [0.0, 0.01, 0.01, 0.02]])
def test_one_way_is_half_a_cycle_whatever_the_number_of_points(series: list[float]) -> None:
    found = swings(np.array(series))
    assert (found.ranges.tolist(), found.counts.tolist()) == ([0.02], [0.5])
    assert swings(np.zeros(5)).largest == (0.0, 0.0)


def test_coffin_and_manson_with_the_user_s_coefficients() -> None:
    assert LAW.cycles(np.array([0.04])) == pytest.approx(0.5 * (0.02 / 0.2) ** -2.0)
    assert np.isinf(LAW.cycles(np.zeros(1))).all()


def test_a_table_is_straight_on_logarithms_within_and_beyond() -> None:
    law = StrainTable((0.01, 0.1), (1e5, 1e3), "own tests")
    assert law.cycles(np.array([0.01, 0.1])) == pytest.approx([1e5, 1e3])
    assert law.cycles(np.array([math.sqrt(0.001)])) == pytest.approx([1e4])
    assert law.cycles(np.array([0.001, 1.0])) == pytest.approx([1e7, 10.0])
    assert np.isinf(law.cycles(np.zeros(1))).all()


def test_the_first_loading_is_told_apart_from_the_cycle_that_follows() -> None:
    """Strains 0.05 at the first turn, 0.03 back, 0.05 again: range 0.02 about 0.04, and one cycle of the motion."""
    found = history([0, 9, 5, 9.0], (0, 0, 0), (0.05, 0.02, 0), (0.03, 0.02, 0), (0.05, 0.02, 0))
    lives = life_of(found, judged(found), LifeSpec(LAW))
    assert lives.strain_range == pytest.approx([0.02, 0.0, 0.0])
    assert lives.strain_mean[0] == pytest.approx(0.04)
    assert lives.first_plastic_strain == pytest.approx([0.049, 0.019, 0.0])
    assert lives.cycles_to_failure == pytest.approx([0.5 * (0.01 / 0.2) ** -2.0, np.inf, np.inf])


def test_miner_adds_up_cycles_of_several_sizes() -> None:
    """Two cycles of the motion, strains swinging by 0.02 and 0.04: life 2 / (1/N(0.02) + 1/N(0.04))."""
    found = history([0, 9, 5, 9, 4, 9.0], *((size, 0.0, 0.0) for size in (0.0, 0.05, 0.03, 0.05, 0.01, 0.05)))
    n = LAW.cycles(np.array([0.02, 0.04]))
    lives = life_of(found, judged(found), LifeSpec(LAW))
    assert Cycles.of(found).count == 2.0
    assert lives.cycles_to_failure[0] == pytest.approx(2.0 / (1.0 / n[0] + 1.0 / n[1]))


def test_a_path_without_a_turn_is_closed_by_the_way_back() -> None:
    found = history([0, 9.0], (0, 0, 0), (0.05, 0.02, 0.0))
    lives = life_of(found, judged(found), LifeSpec(LAW))
    assert lives.strain_range == pytest.approx([0.05, 0.02, 0.0])
    assert lives.cycles_to_failure[:2] == pytest.approx(LAW.cycles(np.array([0.05, 0.02])))
    assert life_of(found, judged(found), None).block is None


def test_chance_of_a_life_below_the_required_one_by_the_normal_of_its_logarithm() -> None:
    """Small strains, so that nothing breaks at first: 1 - prod Phi(ln(N / n) / s) over the loops."""
    found = history([0, 9, 5, 9.0], (0, 0, 0), (0.02, 0.015, 0.0), (0.0, 0.0, 0.0), (0.02, 0.015, 0.0))
    block = life_of(found, judged(found), LifeSpec(LAW, scatter=0.4, required=150.0)).block
    assert block is not None
    n = 0.5 * (np.array([0.02, 0.015]) / 2.0 / 0.2) ** -2.0
    expected = 1.0 - np.prod(norm.cdf(np.log(n / 150.0) / 0.4))
    assert block["p_parts"]["worn"] == pytest.approx(expected)
    assert block["p_parts"]["first_loading"] < 1e-3
    assert block["p_below_required"] == pytest.approx(expected, abs=1e-3)
    assert block["shortest_cycles"] == pytest.approx(200.0)
    assert block["critical_loop"]["loop"] == 0


def test_what_breaks_in_the_first_loading_never_lasts() -> None:
    found = history([0, 9, 5, 9.0], (0, 0, 0), (0.3, 0.0, 0.0), (0.299, 0.0, 0.0), (0.3, 0.0, 0.0))
    block = life_of(found, judged(found), LifeSpec(LAW, required=10.0)).block
    assert block is not None
    assert block["p_parts"]["worn"] < 1e-3
    assert block["p_below_required"] > 0.99


def spec(cyclic: str) -> LifeSpec | None:
    return life_spec(load_case("punch", overrides=[f"failure.cyclic={cyclic}"]).case)


def test_a_case_gives_law_required_cycles_and_what_was_agreed() -> None:
    found = spec("{table: {strain_range: [1 %, 0.1], cycles: [1e5, 1e3]}, source: a, agreed: {required_cycles: 2e4}}")
    assert found is not None
    assert found.law == StrainTable((0.01, 0.1), (1e5, 1e3), "a")
    assert (found.required, found.scatter) == (2e4, None)
    assert found.terms["required cycles"] == "20000"
    assert found.terms["conditioning"] == "not given"
    assert spec("null") is None


@pytest.mark.parametrize(
    ("cyclic", "said"),
    [
        ("{exponent: -0.5, source: a}", "failure.cyclic.coefficient: no strain-life law"),
        ("{exponent: -0.5, coefficient: 1, source: a, table: {strain_range: [1, 2], cycles: [2, 1]}}", "two laws"),
        ("{source: a, table: {strain_range: [2, 1], cycles: [2, 1]}}", "failure.cyclic.table.strain_range: must rise"),
        ("{source: a, table: {strain_range: [1, 2], cycles: [1, 2]}}", "failure.cyclic.table.cycles: must fall"),
        ("{source: a, table: {strain_range: [1, 2], cycles: [3, 2, 1]}}", "2 strain ranges but 3 numbers of cycles"),
        ("{exponent: -0.5, coefficient: 1, source: a, required_cycles: 5, agreed: {required_cycles: 6}}", "5 cycles"),
    ],
)
def test_a_law_that_is_none_is_refused(cyclic: str, said: str) -> None:
    with pytest.raises(BadInput, match=r"failure\.cyclic") as caught:
        spec(cyclic)
    assert said in str(caught.value)
