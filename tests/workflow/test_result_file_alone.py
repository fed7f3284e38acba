"""A result file is enough: maps and comparisons need nothing else of the machine that ran the case."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import trimesh

import etextile as et
from etextile.app.cli import main
from loadcases.fabric import dump_fabric, load_fabric


MESH_CASE = """
schema_version: 1
title: a mesh far away
extends: punch
fabric: {set: fabric.yaml, portion: whole, coarsening: 60}
body: {type: mesh, file: ball.stl, grid_spacing: 1.5}
motion: {total: 12, steps: 4}
outputs: {maps: []}
"""


@pytest.mark.slow
def test_a_result_file_alone_is_drawn_and_compared_far_from_its_mesh_and_fabric(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Mesh, fabric file and case are gone; what is left is the result file in another folder."""
    trimesh.creation.icosphere(radius=15, subdivisions=2).export(tmp_path / "ball.stl")
    (tmp_path / "fabric.yaml").write_text(dump_fabric(load_fabric("estimated_mid")), encoding="utf-8")
    (tmp_path / "case.yaml").write_text(MESH_CASE, encoding="utf-8")
    et.run(et.load(tmp_path / "case.yaml"), tmp_path / "out")
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.copy(tmp_path / "out" / "results.vtkhdf", alone)
    for path in (tmp_path / "out", *tmp_path.glob("*.yaml"), tmp_path / "ball.stl"):
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    seen = tmp_path / "seen"
    seen.mkdir()
    (seen / "wires.csv").write_text("displacement_mm,wire,warp0_mm,state\n12,0,0,intact\n")
    (seen / "measured.yaml").write_text("title: seen\nchannels: {wires: {file: wires.csv}}\n")
    assert main(["report", str(alone), "--measured", str(seen)]) == 0
    assert "1 of 1 places agree" in capsys.readouterr().out
    assert main(["map", str(alone), "--field", "weft_strain"]) == 0
    assert main(["report", str(alone)]) == 2
    assert "its result file came alone" in capsys.readouterr().err
