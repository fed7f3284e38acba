"""Wires stand where one per 65 warp yarns puts them, and loops where a case says, in every portion of the specimen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from loadcases.reader import load_case
from wires.layout import Portion, WireLayout, lay_out


SPACING = 65 / 11


def punch_layout(
    portion: Portion = "whole",
    *,
    size: tuple[float, float] = (100.0, 100.0),
    first_offset_mm: float = 0.0,
    loop_offset_mm: float = 0.0,
    loop_length_mm: float = 4.0,
) -> WireLayout:
    return lay_out(
        length_mm=size[0],
        width_mm=size[1],
        portion=portion,
        wire_spacing_mm=SPACING,
        first_offset_mm=first_offset_mm,
        loop_spacing_mm=20.0,
        loop_length_mm=loop_length_mm,
        loop_slack=0.02,
        loop_offset_mm=loop_offset_mm,
    )


def test_a_100_mm_specimen_has_17_wires_of_5_loops() -> None:
    layout = punch_layout()
    assert layout.n_wires == 17
    assert np.diff(layout.weft_mm) == pytest.approx(5.909, abs=1e-3)
    assert layout.weft_mm[8] == 0.0
    assert np.bincount(layout.loop_wire).tolist() == [5] * 17
    assert layout.loop_warp_mm[:5].tolist() == [-40, -20, 0, 20, 40]


def test_loops_span_their_length_and_carry_their_slack() -> None:
    layout = punch_layout(loop_length_mm=6.0)
    assert layout.loop_span_mm == pytest.approx(6.0)
    assert (layout.loop_exit_mm + layout.loop_entry_mm) / 2 == pytest.approx(layout.loop_warp_mm)
    assert layout.loop_rest_mm == pytest.approx(6.12)


@pytest.mark.parametrize("portion", ["half", "quarter"])
def test_a_portion_with_its_mirror_images_is_the_whole(portion: Portion) -> None:
    whole, part = punch_layout(), punch_layout(portion)
    assert part.wire_copies.sum() == whole.n_wires
    copies = part.loop_copies * part.wire_copies[part.loop_wire]
    assert copies.sum() == whole.n_loops
    # Modelled cross-section and mirror images give the copper of the whole specimen.
    mirrored = 2 if portion == "quarter" else 1
    assert mirrored * part.share.sum() == pytest.approx(whole.share.sum())


def test_the_wire_on_the_symmetry_plane_carries_half_its_area() -> None:
    assert punch_layout("quarter").share.tolist() == [0.5] + [1.0] * 8
    assert punch_layout("half").share.tolist() == [1.0] * 17
    assert punch_layout("quarter", first_offset_mm=SPACING / 2).share.tolist() == [1.0] * 8


def test_a_halved_loop_keeps_its_full_exit_and_entry() -> None:
    layout = punch_layout("quarter")
    assert layout.loop_halved.tolist() == [True, False, False] * 9
    assert layout.loop_exit_mm[0] == -2.0
    assert layout.loop_entry_mm[0] == 2.0
    assert layout.start_mm.tolist() == [0.0] * 9


def test_numbers_run_from_minus_to_plus() -> None:
    layout = punch_layout()
    assert (np.diff(layout.weft_mm) > 0).all()
    assert layout.loop_index[:6].tolist() == [0, 1, 2, 3, 4, 0]
    assert punch_layout("quarter").loop_index[:6].tolist() == [0, 1, 2, 0, 1, 2]


def test_a_wire_at_the_very_edge_is_left_out() -> None:
    just_wide_enough, just_too_narrow = 2 * SPACING + 2 / 11 + 1e-6, 2 * SPACING + 2 / 11 - 1e-6
    assert punch_layout(size=(100, just_wide_enough)).n_wires == 3
    assert punch_layout(size=(100, just_too_narrow)).n_wires == 1


@pytest.mark.parametrize(("length", "loops"), [(48.0, 3), (47.9, 1), (8.0, 1), (7.9, 0)])
def test_a_loop_too_near_to_the_clamp_is_left_out(length: float, loops: int) -> None:
    assert punch_layout(size=(length, 5.0)).n_loops == loops


def test_wires_may_have_no_loops() -> None:
    layout = lay_out(
        length_mm=100, width_mm=100, wire_spacing_mm=SPACING, loop_spacing_mm=None, loop_length_mm=4, loop_slack=0.02
    )
    assert (layout.n_wires, layout.n_loops) == (17, 0)


def test_offsets_move_wires_and_loops() -> None:
    layout = punch_layout(first_offset_mm=1.0, loop_offset_mm=-3.0)
    assert np.isclose(layout.weft_mm, 1.0).any()
    assert layout.loop_warp_mm[:4].tolist() == [-43, -23, -3, 17]


def test_whole_spacings_of_offset_change_nothing() -> None:
    shifted, straight = punch_layout(first_offset_mm=3 * SPACING, loop_offset_mm=-40.0), punch_layout()
    assert shifted.weft_mm == pytest.approx(straight.weft_mm, abs=1e-9)
    assert shifted.loop_warp_mm == pytest.approx(straight.loop_warp_mm)


def test_symmetry_planes_are_told_when_they_mirror_what_is_not_there() -> None:
    assert punch_layout("quarter").symmetric
    assert punch_layout("quarter", first_offset_mm=SPACING / 2, loop_offset_mm=10.0).symmetric
    assert not punch_layout("quarter", first_offset_mm=1.0).symmetric
    assert punch_layout("half", first_offset_mm=1.0).symmetric
    assert not punch_layout("half", loop_offset_mm=5.0).symmetric
    assert punch_layout("whole", first_offset_mm=1.0, loop_offset_mm=5.0).symmetric


def test_a_loop_cut_beside_its_centre_is_refused() -> None:
    with pytest.raises(BadInput, match=r"wires.loops.offset.*1 mm is cut"):
        punch_layout("half", loop_offset_mm=1.0)
    assert punch_layout("half", loop_offset_mm=2.0).n_loops


def test_all_impossible_sizes_are_named_at_once() -> None:
    with pytest.raises(BadInput) as caught:
        lay_out(
            length_mm=100, width_mm=-1, wire_spacing_mm=0, loop_spacing_mm=4, loop_length_mm=4, loop_slack=float("nan")
        )
    keys = [problem.key for problem in caught.value.problems]
    assert keys == ["fabric.size", "wires.every_warp_yarns", "wires.loops.slack", "wires.loops.length"]


def test_wires_in_a_piece_cut_at_an_angle_are_refused_where_the_case_says_so(tmp_path: Path) -> None:
    path = tmp_path / "turned.yaml"
    lines = ["schema_version: 1", "title: turned", "extends: punch", "fabric:", "  portion: whole", "  warp_angle: 30"]
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(BadInput, match=r"turned.yaml:6:15: fabric.warp_angle: wires need the warp along x"):
        load_case(path)
    assert load_case(path, overrides=["wires=null"]).case.wires is None


def test_slack_can_differ_from_loop_to_loop() -> None:
    layout = punch_layout()
    slack = np.linspace(0, 0.1, layout.n_loops)
    assert layout.with_loop_slack(slack).loop_rest_mm == pytest.approx(4.0 * (1 + slack))
    assert layout.with_loop_slack(0.5).loop_rest_mm == pytest.approx(6.0)
    with pytest.raises(BadInput, match=r"wires.loops.slack"):
        layout.with_loop_slack(-0.1)
