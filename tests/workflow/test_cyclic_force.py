"""Records that go there and back: read with their turning points, and what unloading tells of yield parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.diagnose.data.cyclic import read_cyclic_force, turns_of
from etextile.errors import BadInput
from etextile.studies.calibrate.cycles import Cycle, along_path, run_cycle
from loadcases.fabric import load_fabric


STRIP = {"fabric.coarsening": 39, "motion.total": 12, "motion.steps": 12, "wires": None, "outputs.maps": []}
PATH = (6.0, 3.0, 12.0, 4.0)
TRUTH = {"E": 1.25, "sigma_y0": 20.0, "H": 0.85}
"""Factors on the warp's law behind the record."""
NOISE = 2.0
HEAD = "displacement_mm,force_N\n"
UP = "".join(f"{0.5 * i},{i}\n" for i in range(12))
MISTAKES = {
    "only loads": (UP, "never goes back"),
    "short": ("0,0\n1,1\n2,2\n1,0\n", "at least 10"),
    "late": ("".join(f"{5 + 0.5 * i},{i}\n" for i in range(10)) + "6,1\n5,0\n", "count from where the force begins"),
    "below zero": (UP + "".join(f"{5 - i},{9 - i}\n" for i in range(9)), "count from where the force begins"),
}


def places(path: tuple[float, ...], step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the way travelled (n,) and the displacement (n,) of readings along a path."""
    turns = np.array([0.0, *path])
    ends = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    way = np.arange(0.0, ends[-1] + 1e-9, step)
    return way, np.interp(way, ends, turns)


@pytest.mark.parametrize(("rows", "message"), MISTAKES.values(), ids=MISTAKES)
def test_wrong_records_are_named(rows: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text(HEAD + rows)
    with pytest.raises(BadInput, match=message):
        read_cyclic_force(tmp_path / "r.csv")


def test_turning_points_are_found_in_a_record_that_jitters() -> None:
    way, displacement = places(PATH, 0.01)
    jitter = displacement + np.random.default_rng(1).normal(0.0, 0.002, len(way))
    turns, branch = turns_of(np.maximum(jitter, 0.0), 0.02)
    np.testing.assert_allclose(turns, PATH, atol=0.02)
    ends = np.cumsum(np.abs(np.diff([0.0, *PATH])))
    assert np.mean(branch == np.searchsorted(ends, way - 1e-9)) > 0.99


def test_a_reading_knows_how_far_its_motion_has_come(tmp_path: Path) -> None:
    way, displacement = places(PATH, 0.25)
    (tmp_path / "r.csv").write_text(HEAD + "".join(f"{d:.4f},{d:.4f}\n" for d in displacement))
    found = read_cyclic_force(tmp_path / "r.csv")
    assert found.path == PATH
    np.testing.assert_allclose(found.travelled, way, atol=1e-9)


def test_forces_are_read_branch_by_branch() -> None:
    """At a turn the force has a corner, which no curve may cut."""
    cycle = Cycle(np.arange(0.0, 9.0, 0.5), np.abs(4.0 - np.arange(0.0, 9.0, 0.5)))
    way = np.linspace(0.0, 8.0, 33)
    np.testing.assert_allclose(along_path(cycle, (4.0, 0.0), way), np.abs(4.0 - way), atol=1e-12)
    assert np.isnan(along_path(None, (4.0, 0.0), way)).all()


def test_a_joint_and_a_pressure_have_no_such_record(tmp_path: Path) -> None:
    way, displacement = places(PATH, 0.5)
    (tmp_path / "r.csv").write_text(
        HEAD + "".join(f"{d:.4f},{w:.4f}\n" for d, w in zip(displacement, way, strict=True))
    )
    (tmp_path / "measured.yaml").write_text("title: c\nchannels:\n  cyclic_force: {files: [r.csv]}\n")
    with pytest.raises(BadInput, match="needs a punch or a pulled clamp"):
        et.compare("burst_7cm2", tmp_path, tmp_path / "out")


@pytest.mark.slow
def test_unloading_narrows_what_loading_leaves_open(tmp_path: Path) -> None:
    """A strip of another lattice, other laws: modulus, yield stress and hardening in their intervals, and narrower."""
    loaded = et.load("tension_warp", STRIP)
    fabric = load_fabric(loaded.case.fabric.set)
    warp = {name: getattr(fabric.warp, name) for name in TRUTH}
    laws = {name: item.model_copy(update={"value": TRUTH[name] * item.value}) for name, item in warp.items()}
    hidden = fabric.model_copy(update={"warp": fabric.warp.model_copy(update=laws)})
    piece = loaded.case.fabric.model_copy(update={"coarsening": 30.0})
    cycle = run_cycle(loaded.case.model_copy(update={"fabric": piece}), hidden, PATH)
    assert cycle is not None
    way, displacement = places(PATH, 0.25)
    force = along_path(cycle, PATH, way) + np.random.default_rng(7).normal(0.0, NOISE, len(way))
    keys = [f"fabric.warp.{name}" for name in TRUTH]
    found = {}
    for channel in ("cyclic_force", "clamp_force"):
        folder = tmp_path / channel
        folder.mkdir()
        # the loading alone has as many readings of it as the whole record
        chosen = slice(None) if channel == "cyclic_force" else (way <= 6.0) | ((way > 12.0) & (way <= 18.0))
        rows = "".join(f"{d:.4f},{f:.5f}\n" for d, f in zip(displacement[chosen], force[chosen], strict=True))
        (folder / "r.csv").write_text(HEAD + rows)
        text = f"title: c\nchannels:\n  {channel}: {{files: [r.csv], noise: {NOISE:g} N}}\n"
        (folder / "measured.yaml").write_text(text)
        done = et.calibrate(loaded, folder, free=keys, output=folder / "f.yaml", prior=False, held_out=False)
        found[channel] = done.data["parameters"]
    for name, factor in TRUTH.items():
        row = found["cyclic_force"][f"fabric.warp.{name}"]
        assert row["identified"]
        assert row["low"] < factor * warp[name].value < row["high"]
        before = found["clamp_force"][f"fabric.warp.{name}"]
        width = np.log(row["high"] / row["low"])
        assert not before["identified"] or width < 0.8 * np.log(before["high"] / before["low"]), name
    assert found["cyclic_force"]["fabric.warp.E"]["high"] < 1.3 * found["cyclic_force"]["fabric.warp.E"]["low"]
