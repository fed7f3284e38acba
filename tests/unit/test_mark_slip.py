"""Slip of marks on a worn piece: read with its mistakes named, followed on the moving skin, predicted from a record."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.contact.joints import limb
from etextile.diagnose.data.marks import MarkSlip
from etextile.diagnose.data.measured import Measurements, WireStates, read_mark_slip, read_wires
from etextile.diagnose.data.observe import PEAKS, Record, observe
from etextile.diagnose.data.points import gather
from etextile.errors import BadInput
from etextile.motion.flexion import Flexion
from etextile.studies.diagnose.channels import of_channels


HEAD = "angle_deg,warp0_mm,weft0_mm,slip_mm\n"
MISTAKES = {
    "rad": ("0.1,0,0,0\n0.5,0,0,1\n0.9,0,0,2\n1.2,0,0,3\n1.5,0,0,4\n", "convert to deg"),
    "way back": ("10,0,0,0\n20,0,0,1\n30,0,0,2\n20,5,0,3\n10,5,0,4\n", "ordered by angle"),
    "twice": ("10,0,0,0\n10,0,0,1\n30,0,0,2\n40,0,0,3\n50,0,0,4\n", "measured twice at angle 10"),
    "below": ("-10,0,0,0\n10,0,0,1\n30,0,0,2\n40,0,0,3\n50,0,0,4\n", "straight limb"),
    "um": ("10,0,0,0\n20,0,0,1\n30,0,0,2\n40,0,0,3\n50,0,0,4000\n", "convert to mm"),
}


@pytest.mark.parametrize(("rows", "message"), MISTAKES.values(), ids=MISTAKES)
def test_wrong_records_are_named(rows: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "marks.csv"
    path.write_text(HEAD + rows)
    with pytest.raises(BadInput, match=message):
        read_mark_slip(path)


def test_wires_of_a_worn_piece_are_seen_at_angles(tmp_path: Path) -> None:
    path = tmp_path / "wires.csv"
    path.write_text("angle_deg,wire,warp0_mm,state\n30,2,0,intact\n60,2,0,open\n")
    found = read_wires(path)
    assert (found.unit, found.displacement.tolist()) == ("deg", [30.0, 60.0])


def test_a_point_of_the_skin_keeps_its_place_along_the_limb() -> None:
    motion = Flexion(limb("elbow", skin_length=200.0))
    angle = np.radians([0.0, 20.0, 70.0, 120.0, -60.0])
    places = np.stack([np.linspace(-90.0, 110.0, 5), 40.0 * np.sin(angle), 40.0 * np.cos(angle)], axis=1)
    begun = motion.along(places, 0.0)
    np.testing.assert_allclose(begun, places[:, 0], atol=1e-9)
    for flexion in (15.0, 60.0, 110.0):
        moved = motion.carried(places, 0.0, flexion)
        np.testing.assert_allclose(motion.along(moved, flexion), begun, atol=1e-8)


def record() -> Record:
    """A half sleeve whose fabric slips by angle * (x + 2 y) / 1000, and takes 3 N mm per deg."""
    x, y, angle = np.linspace(-100.0, 100.0, 5), np.linspace(0.0, 90.0, 4), np.linspace(0.0, 60.0, 7)
    slip = angle[:, None, None] * (x[None, :, None] + 2.0 * y) / 1000.0
    positions = np.zeros((7, 5, 4, 3))
    return Record(x, y, (False, True), angle, 3.0 * angle, positions, np.zeros((7, len(PEAKS))), slip=slip)


def test_marks_on_both_sides_of_the_plane_of_flexion_slip_alike() -> None:
    angle, warp0, weft0 = np.array([10.0, 25.0, 60.0, 60.0]), np.array([-50.0, 0.0, 30.0, 30.0]), np.array(
        [0.0, -20.0, 45.0, -45.0]
    )  # fmt: skip
    marks = MarkSlip("marks.csv", angle, warp0, weft0, np.zeros(4), 0.2)
    points = gather(Measurements("", "", mark_slip=marks))
    assert (points.unit, points.channels) == ("deg", ("mark_slip",))
    np.testing.assert_allclose(observe(record(), points), angle * (warp0 + 2.0 * np.abs(weft0)) / 1000.0, atol=1e-12)


def test_channels_that_a_worn_piece_does_not_have_are_refused() -> None:
    case = et.load("elbow_sleeve").case
    few = np.array([10.0, 20.0, 30.0])
    marks = MarkSlip("marks.csv", few, np.array([0.0, 500.0, 0.0]), np.zeros(3), np.zeros(3))
    wires = WireStates("wires.csv", few, np.array([1, 2, 99]), np.zeros(3), np.zeros(3, dtype=int))
    said = [item.message for item in of_channels(case, Measurements("", "", mark_slip=marks, wires=wires))]
    assert any("lies outside of the specimen" in text for text in said)
    assert any("no such wire" in text for text in said)
    assert any("first column is in mm, the motion of the case in deg" in text for text in said)
    flat = [item.message for item in of_channels(et.load("punch").case, Measurements("", "", mark_slip=marks))]
    assert any("slip on the skin needs a worn piece" in text for text in flat)
