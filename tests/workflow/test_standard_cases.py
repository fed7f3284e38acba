"""Standard tests as shipped cases: what a laboratory reads from each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import etextile as et
from etextile.text.run import report_text


NO_MAPS = {"outputs.maps": []}


def report(name: str, folder: Path, **changes: object) -> dict[str, Any]:
    overrides = {key.replace("__", "."): value for key, value in changes.items()}
    return et.run(et.load(name, {**NO_MAPS, **overrides}), folder / name).report


@pytest.mark.slow
def test_a_cantilever_returns_the_stiffness_that_was_put_in(tmp_path: Path) -> None:
    """Peirce's rule, made for a heavy elastica, is within 2 % of the bending stiffness at 41.5 deg."""
    found = report("cantilever_d1388", tmp_path, fabric__coarsening=30)
    assert found["weight"]["at_standard_angle"]["peirce_stiffness_Nmm"] == pytest.approx(0.5, rel=0.02)
    assert found["trust"]["ok"]
    assert "rupture" in found
    assert found["rupture"]["first"] is None
    said = " ".join(report_text(found).split())
    assert "bending length 60 mm" in said
    assert "draw-in" not in said


def test_a_clamp_that_gives_way_is_still_the_edge_a_strip_hangs_from(tmp_path: Path) -> None:
    effects = [{"id": "bending_stiffness", "D": 0.5}, {"id": "clamp_compliance", "compliance": 0.05}]
    found = report("cantilever_d1388", tmp_path, fabric__coarsening=80, motion__steps=2, effects=effects)["weight"]
    assert found["overhang_mm"] == pytest.approx(120.0)
    assert 0.0 < found["drop_mm"][0] < found["drop_mm"][1] < 120.0


def test_a_burst_says_pressure_and_distension_with_what_is_not_known_of_the_yarns(tmp_path: Path) -> None:
    found = report("burst_50cm2", tmp_path, fabric__coarsening=30, motion__steps=14)
    rupture, block = found["rupture"], found["pressure"]
    first = rupture["first"]
    assert first["family"] == "weft"
    assert rupture["low"]["pressure_bar"] < first["pressure_bar"] < rupture["high"]["pressure_bar"]
    assert first["displacement_mm"] == pytest.approx(
        np.interp(first["pressure_bar"], block["pressure_bar"], block["height_mm"]), rel=1e-6
    )
    assert any("what follows is no prediction" in note for note in found["notes"])
    said = " ".join(report_text(found).split())
    pressure, height = first["pressure_bar"], first["displacement_mm"]
    assert f"bursting strength {pressure:.3g} bar" in said
    assert f"bursting distension {height:.3g} mm" in said
    assert "force, N" not in said
    assert "estimated_high" in said
    page = (tmp_path / "burst_50cm2" / "report.html").read_text(encoding="utf-8")
    assert "Bursting strength" in page
    assert "Height over pressure" in page
    assert "Greatest force" not in page
    assert found["trust"]["ok"]


def test_rupture_is_read_between_the_steps_and_depends_on_the_fabric(tmp_path: Path) -> None:
    found = report("ball_burst_d6797", tmp_path, fabric__coarsening=16, motion__steps=9)
    first, strain = found["rupture"]["first"], found["strain"]["weft_max"]
    displacement = found["punch"]["displacement_mm"]
    assert np.interp(first["displacement_mm"], displacement, strain) == pytest.approx(0.25, rel=1e-6)
    assert found["rupture"]["passed"]
    other = report("ball_burst_d6797", tmp_path / "nylon", fabric__set="nylon_woven", motion__total=4, motion__steps=4)
    assert "rupture" not in other
