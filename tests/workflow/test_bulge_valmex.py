"""The shipped bulge: the error that compare tells is that of a run, read from its files by other means."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

import etextile as et
from loadcases.shipped import measured_folder


CENTRE = (-2.58, -3.77)
PUBLISHED = 1.856
"""Mean absolute error of dx, dy and dz added (mm) of an orthotropic shell predicting the specimen left out, mean."""


@pytest.mark.slow
def test_compare_tells_the_error_that_a_run_has(tmp_path: Path) -> None:
    found = et.compare("bulge_valmex", "valmex_bulge", tmp_path / "compared").data
    run = et.run(et.load("bulge_valmex", {"outputs.maps": []}), tmp_path / "run")
    assert run.exit_code == 0
    count = run.report["solver"]["nodes"]
    flat = run.results.grid.reference[:count, :2]
    errors = []
    for row in found["gap"]:
        table = np.genfromtxt(measured_folder("valmex_bulge") / row["specimen"], delimiter=",", names=True)
        left = []
        for step, pressure in enumerate(run.results.displacement_mm):
            seen = table[np.isclose(table["pressure_bar"], pressure)]
            x, y = seen["warp0_mm"] - CENTRE[0], seen["weft0_mm"] - CENTRE[1]
            motion = run.results.array("displacement", step)[:count]
            at = np.nan_to_num(LinearNDInterpolator(flat, motion)(np.abs(x), np.abs(y)))
            computed = at * np.stack([np.sign(x), np.sign(y), np.ones(len(x))], axis=1)
            names = (("warp_mm", "warp0_mm"), ("weft_mm", "weft0_mm"))
            measured = [*(seen[now] - seen[start] for now, start in names), seen["height_mm"]]
            left.append(np.abs(computed - np.stack(measured, axis=1)).sum(axis=1))
        errors.append(float(np.concatenate(left).mean()))
        assert row["sum_of_mean_absolute_mm"] == pytest.approx(errors[-1], rel=0.01)
    assert np.mean(errors) < PUBLISHED
    assert {item["specimen"] for item in found["registration"]} == {row["specimen"] for row in found["gap"]}


def test_the_axes_are_as_the_notes_say() -> None:
    """In the plane all specimens move less along x of their arrays, which is the weft of the turned specimen."""
    for name, turned in (("specimen_0.csv", False), ("specimen_1.csv", True), ("specimen_3.csv", False)):
        table = np.genfromtxt(measured_folder("valmex_bulge") / name, delimiter=",", names=True)
        last = table[table["pressure_bar"] == table["pressure_bar"].max()]
        along = [float(np.ptp(last[f"{axis}_mm"] - last[f"{axis}0_mm"])) for axis in ("warp", "weft")]
        x, y = along[::-1] if turned else along
        assert 0.78 < x / y < 0.88
