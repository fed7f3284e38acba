"""Channels of other tests than the punch: a pulled clamp, height over pressure, motion of points on a cut piece."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.nylon_data import load_nylon

from etextile.diagnose.data.inflated import DisplacementField, PressureHeight
from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.noise import NoiseScatter, SignalShape, covariance
from etextile.diagnose.data.observe import PEAKS, Record, observe
from etextile.diagnose.data.points import gather, thin
from etextile.diagnose.data.pulled import ClampForce, read_clamp_force
from etextile.diagnose.predict.run_tables import Levels
from etextile.diagnose.predict.simulate import Request
from etextile.errors import BadInput
from etextile.studies.cases import load
from etextile.studies.diagnose.channels import of_load
from etextile.studies.diagnose.setting import POSITIONS, assemble, check
from loadcases.measurements import load_measurements
from loadcases.reader import load_case


def record(load: np.ndarray, *, angle: float = 0.0) -> Record:
    """A cut piece whose nodes move by load (0.1 X, -0.2 Y) and rise by load^2; its force is load^2."""
    rng = np.random.default_rng(3)
    flat = np.concatenate([[[-50.0, -50.0], [-50.0, 50.0], [50.0, -50.0], [50.0, 50.0]], rng.uniform(-50, 50, (60, 2))])
    motion = np.stack([0.1 * flat[:, 0], -0.2 * flat[:, 1], np.zeros(64)], axis=1)
    positions = np.pad(flat, ((0, 0), (0, 1)))[None] + load[:, None, None] * motion
    positions[..., 2] += load[:, None] ** 2
    peaks = np.zeros((len(load), len(PEAKS)))
    return Record(*flat.T, (False, False), load, load**2, positions[:, :, None], peaks, True, angle)


def test_a_strip_with_a_preload_counts_from_where_its_force_is_that() -> None:
    """With F = u^2 and a preload of 0.25 the displacement of 1 stands for u = 1.5."""
    travel = np.linspace(0.0, 2.0, 21)
    points = gather(Measurements("", "", clamp_force=(ClampForce("a.csv", travel, travel, None, 0.25),)))
    assert (points.unit, points.channels) == ("mm", ("clamp_force",))
    found = observe(record(np.linspace(0.0, 3.0, 601)), points)
    assert found == pytest.approx((travel + 0.5) ** 2, abs=1e-4)
    assert np.isnan(observe(record(np.linspace(0.0, 2.2, 601)), points)[-1])


def test_motion_of_a_turned_cut_piece_is_told_along_its_yarns() -> None:
    """The warp lies along Y of the piece: what moves along Y moves along the warp."""
    places = np.array([[10.0, 20.0], [-30.0, 5.0]])
    fields = DisplacementField("a.csv", "bar", np.ones(2), *places.T, *(places + 1.0).T, np.zeros(2))
    points = gather(Measurements("", "", displacement_field=(fields,)))
    found = observe(record(np.linspace(0.0, 1.0, 11), angle=90.0), points).reshape(3, 2)
    # a point at warp a, weft b lies at X = -b, Y = a
    assert found == pytest.approx(np.stack([-0.2 * places[:, 0], 0.1 * places[:, 1], np.ones(2)]))


def test_the_centre_of_the_coordinates_is_taken_off() -> None:
    places = np.array([[12.0, 25.0], [-28.0, 10.0]])
    fields = DisplacementField("a.csv", "bar", np.ones(2), *places.T, *places.T, np.zeros(2))
    points = gather(Measurements("", "", displacement_field=(fields,), centre=(2.0, 5.0)))
    assert points.warp0[:2] == pytest.approx([10.0, -30.0])


def test_heights_of_three_specimens_scatter_together_within_each() -> None:
    pressure = np.linspace(0.1, 2.0, 10)
    curves = tuple(PressureHeight(f"{i}.csv", pressure, 20.0 * pressure ** (1 / 3)) for i in range(3))
    points = gather(Measurements("", "", pressure_height=curves))
    shape = SignalShape(points.value, np.ones(30), points.value)
    found = covariance(points, np.full(30, 0.1), shape, NoiseScatter(0.05, 0.0, 0.0))
    assert found[0, 9] == pytest.approx(0.05**2 * points.value[0] * points.value[9])
    assert found[0, 10] == 0.0


def test_a_field_of_hundreds_of_points_is_thinned_to_what_it_can_tell() -> None:
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-90, 90, 20), np.linspace(-90, 90, 20)))
    fields = tuple(
        DisplacementField(
            f"{i}.csv", "bar", np.repeat(np.arange(1.0, 11.0), 400), *np.tile([x, y, x, y], 10), np.ones(4000)
        )
        for i in range(3)
    )
    points = gather(Measurements("", "", displacement_field=fields))
    bins = thin(points)
    assert len(points) == 36000
    assert len(bins.count) == 3 * 3 * 8 * 16
    assert bins.count.sum() == len(points)


def test_a_run_stops_at_the_pressures_that_were_measured_and_between_for_half_steps() -> None:
    curve = PressureHeight("a.csv", np.array([0.1, 0.5, 2.0]), np.ones(3))
    levels = Levels.for_points(10.0, gather(Measurements("", "", pressure_height=(curve,))))
    law = (1.0, 0.0, 1.0, 1.0)
    assert levels.request((law,) * 3).stations == (0.1, 0.5, 2.0)
    assert levels.request((law,) * 3, finer=2).stations == pytest.approx((0.05, 0.1, 0.3, 0.5, 1.25, 2.0))
    assert Request((law,) * 3, (), 1.0, 2.0, 3).key("a") != levels.request((law,) * 3).key("a")


def test_a_strip_at_an_angle_and_a_bulge_can_be_diagnosed() -> None:
    strip = load_case("nylon_30")
    travel = np.linspace(0.0, 3.0, 10)
    pulled = Measurements("", "", clamp_force=(ClampForce("a.csv", travel, travel),))
    check(strip.case, pulled, POSITIONS)
    with pytest.raises(BadInput, match="pressure"):
        check(strip.case, Measurements("", "", pressure_height=(PressureHeight("b.csv", travel, travel),)), POSITIONS)
    assert not list(of_load(load_case("bulge_valmex").case, Measurements("", "")))
    assert [item.key for item in of_load(load_case("punch").case, pulled)] == ["motion.target"]


def test_the_simulator_of_the_diagnosis_pulls_the_strip_of_the_case() -> None:
    """A short strip of the nylon at 30 degrees, on its own laws, carries what was measured within some 25 per cent."""
    strip = load("nylon_30", ["fabric.coarsening=5", "fabric.size=[40, 5]"])
    travel = np.linspace(0.0, 1.4, 10)
    task = assemble(strip, Measurements("", "", clamp_force=(ClampForce("", travel, travel),)), name_effects=False)
    run = task.simulator(Levels.for_points(5.0, gather(task.measured)).request(task.setting.case_laws))
    assert (run.completed, run.rectangular, run.angle) == (True, False, 30.0)
    assert run.positions.shape == (13, len(run.x), 1, 3)
    measured = np.interp(0.035, *(load_nylon(30).strain, load_nylon(30).stress))
    assert np.interp(1.4, run.displacement, run.force) / (5.0 * 0.067) == pytest.approx(measured, rel=0.25)


def test_the_files_say_how_many_strips_were_pulled(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("displacement_mm,force_N\n0,6\n1,24\n2,48\n3,72\n4,96\n", encoding="utf-8")
    text = "title: t\nchannels:\n  clamp_force: {files: [a.csv], strips: 12, noise: 1.2 N}\n"
    (tmp_path / "measured.yaml").write_text(text, encoding="utf-8")
    (curve,) = load_measurements(tmp_path).clamp_force
    assert (curve.force.tolist(), curve.preload) == ([0.5, 2.0, 4.0, 6.0, 8.0], 0.5)
    assert curve.noise == pytest.approx(0.1)
    assert curve.line(0) == 2
    (tmp_path / "b.csv").write_text("displacement_mm,force_N\n0,6\n1,24\n0.5,48\n3,72\n4,96\n", encoding="utf-8")
    with pytest.raises(BadInput, match="does not rise"):
        read_clamp_force(tmp_path / "b.csv")
