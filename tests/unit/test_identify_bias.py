"""Bias coupons without curves of warp and weft: what identify leaves, and that the lattice does the work of the law."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.app.cli import main
from etextile.identify.shear_force import shear_angle
from etextile.studies.identify.bias import BiasIdentification
from loadcases.fabric import load_fabric


def write(folder: Path, name: str, *, length: float, width: float) -> None:
    """Write a coupon whose shear moment per area is 0.4 gamma^1.5 N/mm, to 40 degrees and back."""
    travel = np.linspace(0.0, 0.22 * (length - width), 80)
    travel = travel[shear_angle(travel, (length, width)) < np.radians(40.0)]
    angle = np.maximum(shear_angle(travel, (length, width)), 0.0)
    both = (2.0 * length - 3.0 * width) * 0.4 * angle**1.5 + width * 0.4 * (0.5 * angle) ** 1.5
    force = both / ((length / width - 1.0) * (np.cos(angle / 2.0) - np.sin(angle / 2.0)))
    rows = [*zip(travel, force, strict=True), (0.9 * travel[-1], 0.2 * force[-1])]
    text = "displacement_mm,force_N\n" + "".join(f"{u:.6g},{f:.6g}\n" for u, f in rows)
    (folder / name).write_text(text, encoding="utf-8")


def folder(path: Path, *sizes: tuple[str, float, float]) -> Path:
    lines = ["title: dry glass", "channels:", "  tensile:", "    columns: [displacement_mm, force_N]", "    bias:"]
    for name, length, width in sizes:
        write(path, name, length=length, width=width)
        lines.append(f"      - {{file: {name}, width: {width} mm, thickness: 0.4 mm, gauge_length: {length} mm}}")
    (path / "measured.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_two_sizes_foretell_each_other_and_yarns_are_said_to_be_assumed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    measured = folder(tmp_path, ("small.csv", 200.0, 100.0), ("large.csv", 300.0, 150.0))
    assert main(["identify", str(measured), "-o", str(tmp_path / "glass.yaml")]) == 0
    told = capsys.readouterr().out
    assert "near inextensible" in told
    assert "foretold by the law of the other sizes" in told
    fabric = load_fabric(str(tmp_path / "glass.yaml"))
    assert fabric.thickness == pytest.approx(0.4)
    assert fabric.warp.estimated
    assert not fabric.diagonal.estimated
    table = np.genfromtxt(tmp_path / "glass_shear.csv", delimiter=",", names=True)
    angle = np.radians(table["shear_angle_deg"][20:])
    assert table["moment_N_per_mm"][20:] == pytest.approx(0.4 * angle**1.5, rel=0.02)
    assert (tmp_path / "glass_shear.png").is_file()


def test_one_size_says_that_nothing_is_known_of_another(tmp_path: Path) -> None:
    found = et.identify(folder(tmp_path, ("small.csv", 200.0, 100.0)))
    assert isinstance(found, BiasIdentification)
    assert found.foretold == ()
    assert found.missed < 0.02
