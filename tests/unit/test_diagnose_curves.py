"""Panels of curves: the force first, full fields at the place of their gap, strains in per cent."""

from __future__ import annotations

import numpy as np

from etextile.diagnose.data.measured import Measurements, StrainField
from etextile.diagnose.data.points import Points, gather
from etextile.diagnose.data.punched import PunchForce
from etextile.studies.diagnose.curves import ComparedCurves, Predicted, panels
from viz.diagnosis_plots import Panel


TRAVEL = np.arange(5.0, 45.0, 5.0)


def measured() -> Points:
    """Two specimens of force and a strain field whose warp strain is 2 % too large at x = 20 mm."""
    u, x = (axis.ravel() for axis in np.meshgrid(TRAVEL, [0.0, 20.0, 40.0], indexing="ij"))
    odd = np.where(x == 20.0, 0.02, 0.0)
    field = StrainField("", u, x, 0.0 * x, odd, 0.0 * x, 0.003)
    fine = np.linspace(1.0, 40.0, 40)
    curves = tuple(PunchForce(f"{name}.csv", fine, fine + shift, 1.0) for name, shift in (("a", 0.0), ("b", 1.0)))
    return gather(Measurements("", "", curves, strain_field=field))


def drawn() -> dict[str, Panel]:
    raw = measured()
    base = np.where(raw.of("punch_force"), raw.displacement, 0.0)
    before = Predicted(base, np.full(len(raw), 0.001))
    shown = ComparedCurves(before, np.where(raw.of("punch_force"), 1.0, 0.003), before, base, 30.0)
    return {panel.title: panel for panel in panels(raw, shown)}


def test_the_force_comes_first_with_all_its_specimens() -> None:
    title, panel = next(iter(drawn().items()))
    assert title == "punch force"
    assert len(panel.readings) == 2
    np.testing.assert_allclose(panel.readings[1].left_before, 1.0)
    assert len(panel.before.displacement) == 40
    assert panel.held_out.displacement.min() > 30.0


def test_a_field_is_shown_where_it_is_off_in_per_cent() -> None:
    panel = drawn()["warp strain at x = 20, y = 0 mm"]
    assert panel.unit == "%"
    np.testing.assert_allclose(panel.readings[0].value, 2.0)
    np.testing.assert_allclose(panel.noise, 0.3)
    np.testing.assert_array_equal(panel.before.displacement, TRAVEL)


def test_curves_end_where_the_simulation_does() -> None:
    raw = measured()
    base = np.where(raw.displacement > 30.0, np.nan, 1.0)
    shown = panels(raw, ComparedCurves(Predicted(base, np.zeros(len(raw))), np.ones(len(raw))))
    assert max(float(panel.before.displacement.max()) for panel in shown) == 30.0
