"""Fabric and wire material files: what is read, and what is told about wrong ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from etextile.errors import BadInput
from loadcases import catalogue
from loadcases.fabric import dump_fabric, load_fabric
from loadcases.wire_material import load_wire_material


FABRIC = (catalogue.FOLDERS["fabric"] / "estimated_mid.yaml").read_text(encoding="utf-8")
WIRE = (catalogue.FOLDERS["wire material"] / "copper_soft.yaml").read_text(encoding="utf-8")


def refusal(load: Callable[[Path], object], folder: Path, text: str) -> str:
    path = folder / "file.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as refused:
        load(path)
    assert len(refused.value.problems) == 1, refused.value
    problem = refused.value.problems[0]
    assert problem.line is not None
    return f"{problem.key}: {problem.message}"


def replaced(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


@pytest.mark.parametrize(
    ("name", "family", "law", "strain", "stress"),
    [
        ("estimated_mid", "warp", (3000, 0.2, 9960, 1.5), 0.12, 40),
        ("estimated_mid", "weft", (4500, 0.2, 4230, 1.1), 0.12, 31),
        ("estimated_low", "warp", (2000, 0.2, 6500, 1.4), 0.12, 30),
        ("estimated_low", "weft", (3000, 0.2, 3500, 1.05), 0.12, 25),
        ("estimated_high", "warp", (5000, 0.2, 18000, 1.8), 0.12, 46),
        ("estimated_high", "weft", (7000, 0.2, 4200, 1.15), 0.12, 33),
    ],
)
def test_shipped_laws_pass_near_their_anchor(
    name: str, family: str, law: tuple[float, ...], strain: float, stress: float
) -> None:
    """The fabric stress sigma A0 exp(-eps_p) / A_n of the loading curve at the anchor strain (model, section 3)."""
    fabric = load_fabric(name)
    item = getattr(fabric, family)
    assert (item.E.value, item.sigma_y0.value, item.H.value, item.n.value) == law
    young, sigma_y0, hardening, exponent = law
    plastic = hencky = math.log1p(strain)
    for _ in range(200):  # eps_p = eps - sigma(eps_p) / E, a contraction
        sigma = sigma_y0 * plastic / (plastic + item.e0) + hardening * plastic**exponent
        plastic = 0.5 * (plastic + hencky - sigma / young)
    nominal = fabric.cell[1 if family == "warp" else 0] * fabric.thickness
    assert sigma * math.exp(-plastic) * fabric.truss_area / nominal == pytest.approx(stress, rel=0.06)


def test_the_cell_has_the_angle_and_the_densities_of_the_paper() -> None:
    fabric = load_fabric("estimated_mid")
    assert math.degrees(math.atan2(fabric.cell[1], fabric.cell[0])) == pytest.approx(29.4, abs=0.1)
    assert (fabric.warp_density, fabric.weft_density) == (11.0, 8.9)
    assert 65 / fabric.warp_density == pytest.approx(5.91, abs=0.005)


def test_numbers_with_deviation_and_covariance_survive(tmp_path: Path) -> None:
    text = replaced(FABRIC, "E: 3000", "E: {value: 3 GPa, std: 90 MPa}")
    text = replaced(text, "warp:\n", "warp:\n  covariance: {parameters: [E, H], matrix: [[8100, 5], [5, 4]]}\n")
    path = tmp_path / "file.yaml"
    path.write_text(text, encoding="utf-8")
    fabric = load_fabric(path)
    assert (fabric.warp.E.value, fabric.warp.E.std) == (3000.0, 90.0)
    assert fabric.warp.covariance is not None
    path.write_text(dump_fabric(fabric), encoding="utf-8")
    assert load_fabric(path) == fabric


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("E: 3000", "E: -3000", "warp.E: out of range (got -3000), must be at least 0.001 MPa and at most 1e+07 MPa"),
        ("E: 3000", "E: 3000 mm", "warp.E: the unit does not fit (got '3000 mm'), expected a stress in MPa, plain or "),
        ("E: 3000", "E: {valeu: 3}", "warp.E: unknown key 'valeu' in it, allowed are value, std, source, estimated, "),
        ("E: 3000", "E: {std: 3}", "warp.E: the number is missing"),
        ("E: 3000", "E: {value: 3, std: -1}", "warp.E: negative standard deviation (got -1), must be at least 0"),
        ("truss_area: 0.0155", "truss_area: 0.0155 mm", "truss_area: the unit does not fit"),
        ("warp_density: 11.0", "warp_density: 0", "warp_density: out of range (got 0), must be at least 0.001 1/mm"),
        ("[0.0, 0.12]", "[0.2, 0.1]", "warp.strain_range: the range does not rise (got [0.2, 0.1]), must be 0 <= from"),
        ("warp:\n", "warp:\n  covariance: {parameters: [E], matrix: [[1, 2]]}\n", "warp.covariance: the matrix is not"),
        ("warp:\n", "warp:\n  covariance: {parameters: [E], matrix: [[-1]]}\n", "warp.covariance: a variance is negat"),
        (
            "warp:\n",
            "warp:\n  covariance: {parameters: [E, H], matrix: [[1, 2], [3, 1]]}\n",
            "warp.covariance: the matrix is not symmetric",
        ),
    ],
)
def test_mistakes_in_fabric_files(old: str, new: str, message: str, tmp_path: Path) -> None:
    text = replaced(FABRIC, old, new)
    assert refusal(load_fabric, tmp_path, text).startswith(message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "{value: 79, source:",
            "{value: 79, note:",
            "sigma_y0: unknown key 'note' in it, allowed are value, std, sourc",
        ),
        (
            "H: {value: 600, estimated: true}",
            "H: 600",
            "H: no clear origin (got 600), give either source: text or esti",
        ),
        ("estimated: true", "estimated: false", "H: no clear origin (got 600)"),
        (
            "estimated: true",
            "estimated: perhaps",
            "H: wrong origin (got {'value': 600, 'estimated': 'perhaps'}), write",
        ),
        ("estimated: true", "estimated: true, source: a book", "H: no clear origin (got 600)"),
    ],
)
def test_mistakes_in_wire_files(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert refusal(load_wire_material, tmp_path, replaced(WIRE, old, new)).startswith(message)


@pytest.mark.parametrize("name", catalogue.names("wire material"))
def test_copper_reaches_its_strength_at_break(name: str) -> None:
    """Engineering stress (sigma_y0 + H eps^n) exp(-eps): the ultimate strengths 238 and 514 MPa (model, section 6)."""
    strength = {"copper_soft": (238.0, 0.09), "copper_drawn": (514.0, 0.015)}[name]
    wire = load_wire_material(name)
    stress = (wire.sigma_y0.value + wire.H.value * strength[1] ** wire.n.value) * math.exp(-strength[1])
    assert stress == pytest.approx(strength[0], rel=0.01)
    assert 70e3 <= wire.E.value <= 120e3
