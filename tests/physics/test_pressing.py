"""How a body presses, and how deep flat pieces of lattice cut into it: closed forms of a sphere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.contact.sphere import Sphere
from etextile.studies.run.pressing import pressed
from loadcases.lattice_error import known_error


def cap(radius: float, count: int, half: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return a grid of nodes on top of a sphere around the origin, its cells, and the true area under it."""
    flat = np.linspace(-half, half, count)
    x, y = np.meshgrid(flat, flat, indexing="ij")
    points = np.stack([x, y, np.sqrt(radius**2 - x**2 - y**2)], axis=-1).reshape(-1, 3)
    number = np.arange(count * count).reshape(count, count)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    fine = np.linspace(-half, half, 2001)
    middle = 0.5 * (fine[1:] + fine[:-1])
    u, v = np.meshgrid(middle, middle, indexing="ij")
    area = float((radius / np.sqrt(radius**2 - u**2 - v**2)).sum() * (fine[1] - fine[0]) ** 2)
    return points, quads, area


def test_an_even_pressure_on_a_sphere_is_found_again_over_the_stretched_area() -> None:
    """Nodal forces 0.04 MPa times the area of each node's quarter cells, turned along the normal, give 40 kPa."""
    points, quads, area = cap(15.0, 41, 8.0)
    corners = points[quads]
    cells = 0.5 * np.linalg.norm(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)
    own = np.bincount(quads.ravel(), np.repeat(0.25 * cells, 4), minlength=len(points))
    force = 0.04 * own[:, None] * points / 15.0
    found = pressed(points, force, Sphere(15.0).distance, quads=quads, left_out=np.zeros(len(quads), dtype=bool))
    assert found.mean == pytest.approx(40.0, rel=1e-9)
    assert found.largest == pytest.approx(40.0, rel=1e-9)
    assert found.area.sum() == pytest.approx(area, rel=1e-3)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[float, et.Run]:
    """The punch to 20 mm on two lattices."""
    folder = tmp_path_factory.mktemp("pressing")
    at = {"motion.total": 20, "motion.steps": 8, "outputs.maps": []}
    return {c: et.run(et.load("punch", {**at, "fabric.coarsening": c}), folder / str(c)) for c in (39, 19.5)}


def test_pressure_times_projected_area_is_the_force_of_the_punch(runs: dict[float, et.Run]) -> None:
    """For a frictionless sphere F = p pi a^2 with A = 2 pi R (R - sqrt(R^2 - a^2)); the pressure is nearly even."""
    report = runs[19.5].report
    contact, force = report["contact"], report["punch"]["force_N"][-1]
    area = contact["area_mm2"]
    height = area / (2.0 * np.pi * 15.0)
    projected = np.pi * (15.0**2 - (15.0 - height) ** 2)
    assert 1e-3 * contact["pressure_kPa_mean"] * projected == pytest.approx(force, rel=0.15)
    assert contact["pressure_kPa_max"] >= contact["pressure_kPa_mean"]
    assert any("kPa" in note for note in report["notes"])


def test_chords_cut_by_their_sagitta_and_a_coarse_lattice_is_not_trusted(runs: dict[float, et.Run]) -> None:
    """The diagonal of a stretched cell, length h, cuts h^2 / (8 R) deep: four times as deep on twice the cell."""
    coarse, fine = (runs[c].report["contact"] for c in (39, 19.5))
    h = np.hypot(50.0 / 9, 50.0 / 16)
    assert fine["lattice_cut_mm"] == pytest.approx(h**2 / (8 * 15.0), rel=0.35)
    assert coarse["lattice_cut_mm"] / fine["lattice_cut_mm"] == pytest.approx(4.0, rel=0.35)
    assert fine["lattice_cut_share"] == pytest.approx(fine["lattice_cut_mm"] / 15.0, rel=1e-6)
    for report in (runs[39].report, runs[19.5].report):
        named = any("lattice cut" in check["name"] for check in report["trust"]["limits"])
        assert named == (report["contact"]["lattice_cut_share"] > 0.1)


def test_the_measured_lattice_error_belongs_to_the_shipped_mechanics_alone(tmp_path: Path) -> None:
    """As shipped, and with another criterion, it is stated; on another lattice or path it is not."""
    cases = {
        "as shipped": et.load("punch"),
        "judged": et.load("punch", {"failure.onset": 0.06}),
        "moved": et.load("punch", {"motion.total": 20}),
        "finer": et.load("punch", {"fabric.coarsening": 13}),
    }
    known = {name: known_error(case.case, case.path) for name, case in cases.items()}
    assert known["moved"] is None
    assert known["finer"] is None
    assert known["as shipped"] == known["judged"]
    assert known["judged"] is not None
    assert known["judged"].force_error == pytest.approx(1.8 * known["judged"].force_change, rel=1e-3)
