"""Two designs are told apart by the keys in which they differ, their wires by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.studies.ensemble.designs import _partners
from etextile.studies.ensemble.differs import differences, words
from loadcases.build_wires import wire_layout
from loadcases.fabric import load_fabric
from loadcases.reader import load_case
from wires.layout import WireLayout


def layout_of(name: str, *overrides: str) -> WireLayout:
    case = load_case(name, overrides=overrides).case
    found = wire_layout(case, load_fabric(case.fabric.set))
    assert found is not None
    return found


def test_only_what_changes_an_answer_is_a_difference() -> None:
    first = load_case("punch").case
    second = load_case("punch", overrides=["wires.loops.slack='5 %'", "motion.total=30", "title=other"]).case
    found = {item["key"]: (item["A"], item["B"]) for item in differences(first, second)}
    assert found.pop("wires.loops.slack") == (0.02, 0.05)
    assert found.pop("motion.total") == (52.5, 30.0)
    assert not found
    assert differences(first, first) == []


def test_items_of_a_list_go_by_their_name() -> None:
    plain = load_case("punch").case
    more = load_case("punch", overrides=["effects=[{id: clamp_slip, limit: 9}]"]).case
    texts = [words(item) for item in differences(plain, more)]
    assert any(text.startswith("effects.clamp_slip.") and text.endswith("9 in B") for text in texts), texts
    without = load_case("punch", overrides=["wires=null"]).case
    assert {item["key"].partition(".")[0] for item in differences(plain, without)} == {"wires"}


def test_wires_of_a_drawing_are_compared_by_name_those_of_a_comb_by_place() -> None:
    drawn = layout_of("knee_pad")
    order = np.arange(drawn.n_wires)[::-1]
    turned = replace(drawn, names=tuple(drawn.names[number] for number in order))
    assert _partners(drawn, turned) == list(zip(range(drawn.n_wires), order.tolist(), strict=True))
    dense, sparse = layout_of("punch"), layout_of("punch", "wires.every_warp_yarns=130")
    pairs = _partners(dense, sparse)
    assert [sparse.names[other] for _, other in pairs] == ["0", "1", "2", "3", "4"]
    np.testing.assert_allclose([dense.weft_mm[a] - sparse.weft_mm[b] for a, b in pairs], 0.0, atol=1e-9)
