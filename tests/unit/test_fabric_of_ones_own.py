"""A fabric of one's own: densities and thickness suffice for identify; a bare fabric takes wires of any stiffness."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.identify.coupon import pull
from etextile.identify.curves import TensileCurve
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.identify import identify_curves
from loadcases.build import build
from loadcases.fabric import FAMILIES, load_base, load_fabric
from loadcases.reader import load_case


WEAVE = "schema_version: 1\ntitle: mine\nthickness: 0.3 mm\nwarp_density: 20 1/cm\nweft_density: 18 1/cm\n"


@pytest.fixture
def weave(tmp_path: Path) -> Path:
    path = tmp_path / "weave.yaml"
    path.write_text(WEAVE, encoding="utf-8")
    return path


def test_cell_and_truss_area_follow_from_densities_and_thickness(weave: Path) -> None:
    fabric = load_base(weave)
    along, across = 1.0 / 1.8, 1.0 / 2.0
    assert fabric.cell == pytest.approx((along, across))
    material = fabric.truss_area * (along + across + 2.0 * np.hypot(along, across))
    assert material == pytest.approx(along * across * 0.3)


def test_without_laws_a_fabric_carries_the_stress_of_the_default_and_is_not_run(weave: Path) -> None:
    """The fabric's stress is the truss's times its area over the cross-section it stands for."""
    own, lent = load_base(weave), load_fabric("estimated_mid")
    for family in FAMILIES:
        one, two = (getattr(fabric, family).H.value / fabric.area_ratios[family] for fabric in (own, lent))
        assert one == pytest.approx(two, rel=1e-5)
        assert getattr(own, family).estimated
    with pytest.raises(BadInput, match="identify finds it"):
        load_fabric(weave)


@pytest.mark.parametrize("truss_area", [None, 0.01, 0.2])
def test_the_fabric_is_the_same_whatever_the_truss_area(tmp_path: Path, truss_area: float | None) -> None:
    path = tmp_path / "weave.yaml"
    path.write_text(WEAVE + (f"truss_area: {truss_area}\n" if truss_area else ""), encoding="utf-8")
    strain, stress = pull(PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.12, area_ratio=3.62)
    found = identify_curves({"warp": [TensileCurve.of("a", strain, stress)]}, title="mine", fabric=path)
    law, ratio = found.fabric.warp, found.fabric.area_ratios["warp"]
    fitted = PowerLaw(law.E.value, law.sigma_y0.value, law.H.value, law.n.value, law.e0)
    probe = np.array([0.03, 0.06, 0.12])
    expected = np.interp(probe, strain[:101], stress[:101])
    np.testing.assert_allclose(fitted.loading_curve(probe) / ratio, expected, rtol=0.02)
    assert "laws from estimated_mid" in found.base


HEATING = {"wires.filaments": 19, "wires.filament_diameter": "0.1 mm"}


def test_heating_wires_are_stiffer_than_the_coupon_and_allowed_on_a_bare_fabric() -> None:
    with pytest.raises(BadInput, match="coupons_contain_wires to false"):
        build(load_case("punch", overrides=overrides(HEATING)).case)
    built = build(load_case("punch", overrides=overrides({**HEATING, "wires.coupons_contain_wires": "false"})).case)
    assert built.share is None
    laws = [part for part in built.model.contributions if getattr(part, "name", "") == "lattice"][0].laws  # noqa: RUF015
    assert built.fabric.warp.H.value == laws[0].H


def overrides(values: dict[str, object]) -> list[str]:
    return [f"{key}={value}" for key, value in values.items()]
