"""The shipped bulge: the error that compare tells is that of a run, read from its files by other means."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

import etextile as et
from loadcases.shipped import measured_folder


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
            x, y = seen["warp0_mm"], seen["weft0_mm"]
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


def test_the_axes_and_the_centre_are_as_the_notes_say() -> None:
    """All specimens move less along the first axis; heights have no slope within 3 mm of the centre."""
    for name in ("specimen_0.csv", "specimen_1.csv", "specimen_3.csv"):
        table = np.genfromtxt(measured_folder("valmex_bulge") / name, delimiter=",", names=True)
        last = table[table["pressure_bar"] == table["pressure_bar"].max()]
        x, y = (float(np.ptp(last[f"{axis}_mm"] - last[f"{axis}0_mm"])) for axis in ("warp", "weft"))
        assert 0.78 < x / y < 0.88
        near = last[np.hypot(last["warp0_mm"], last["weft0_mm"]) < 60.0]
        square = near["warp0_mm"] ** 2 + near["weft0_mm"] ** 2
        terms = np.stack([np.ones(len(near)), near["warp0_mm"], near["weft0_mm"], square], axis=1)
        _, slope_x, slope_y, bend = np.linalg.lstsq(terms, near["height_mm"], rcond=None)[0]
        assert np.hypot(slope_x, slope_y) / (2.0 * abs(bend)) < 3.0
