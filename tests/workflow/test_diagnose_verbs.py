"""The verbs compare and diagnose from files to files, on a specimen whose mechanics is a formula.

The formula stands in the place of the simulator: force and edge follow power laws of the displacement, the clamp takes
the force up to a limit. So the surfaces are tested in seconds; the simulator itself has its own tests.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from etextile.app import diagnose_proof, diagnose_run
from etextile.app.cli import main
from etextile.app.diagnose_proof import Proven
from etextile.app.diagnose_simulator import CaseSimulator
from etextile.diagnose.observe import PEAKS, Record, observe
from etextile.diagnose.simulate import EffectSpec, Request
from loadcases.patch import read_patch


HALF = 50.0
COUPON = 9960.0
KEYS = {
    "verdict", "effects", "ambiguous_with", "where", "gap", "candidates", "next_measurement", "patch", "simulations",
    "wall_s",
}  # fmt: skip
AMONG = ("clamp_slip", "punch_friction", "rate_dependence")


def specimen(travel: np.ndarray, *, cell: float, stress: float = 1.0, effects: dict[str, dict[str, float]]) -> Record:
    """Return what the formula says over travel (S,) on a lattice with cells of `cell` mm."""
    count = max(4, round(HALF / cell))
    x = np.linspace(0.0, HALF, count + 1)
    share = travel / 40.0
    force = 1700.0 * stress * share**2.6 * (1.0 + 1e-4 * cell**2)
    draw = 9.0 * share**1.6
    if "clamp_slip" in effects:
        limit = 70.0 * effects["clamp_slip"]["limit"]
        held = force / (1.0 + (force / limit) ** 6) ** (1.0 / 6.0)
        draw = draw - 2.0 * (1.0 - held / np.maximum(force, 1e-9)) * share
        force = held
    force = force * (1.0 + 0.3 * effects.get("punch_friction", {}).get("mu", 0.0) * share)
    force = force * (1.0 + effects.get("rate_dependence", {}).get("per_decade", 0.0))
    force = force * (1.0 - 0.5 * effects.get("stretched_weft", {}).get("share", 0.0) * (share > 0.5) * (share - 0.5))
    grid_x, grid_y = np.meshgrid(x, x, indexing="ij")
    dome = (1.0 - (grid_x / HALF) ** 2) * (1.0 - 0.7 * (grid_y / HALF) ** 2)
    positions = np.empty((len(travel), len(x), len(x), 3))
    positions[..., 0] = grid_x
    positions[..., 1] = grid_y - draw[:, None, None] * (grid_y / HALF) * (1.0 - (grid_x / HALF) ** 2)
    positions[..., 2] = travel[:, None, None] * dome
    peaks = np.outer(share, [0.3, 0.1, 0.3, 20.0, 30.0, 1e-2])[:, : len(PEAKS)]
    return Record(x, x, (True, True), travel, force, positions, peaks)


def formula(self: CaseSimulator, request: Request) -> Record:
    """Stand in for the simulator."""
    travel = np.linspace(0.0, request.total, request.steps + 1)
    effects = {item.id: dict(item.parameters) for item in request.effects}
    return specimen(travel, cell=0.28 * request.coarsening, stress=request.laws[0][2] / COUPON, effects=effects)


def proof_by_formula(task: Any, diagnosis: Any, finalist: Any, patch: Path, *, folder: Any, advance: Any) -> Proven:
    """Stand in for the ordinary runs: reads the patch as they do."""
    effects = [
        EffectSpec.of(item.id, {k: v for k, v in item.parameters.items() if k != "file"})
        for item in read_patch(patch).effects
    ]
    request = diagnosis.levels.request(task.setting.base.laws, effects)
    raw = diagnosis.bench.raw
    added = observe(task.simulator(request), raw) - observe(diagnosis.base_runs.coarse, raw)
    return Proven(diagnose_proof._prove(diagnosis, added, None), None, None, (), ())


@pytest.fixture(autouse=True)
def by_formula(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(CaseSimulator, "__call__", formula)
    monkeypatch.setattr(diagnose_run, "prove_patch", proof_by_formula)


def measure(folder: Path, *, effects: dict[str, dict[str, float]], seed: int = 0, noise: float = 0.01) -> Path:
    """Write the folder of a test on three specimens with these hidden effects."""
    rng = np.random.default_rng(seed)
    folder.mkdir()
    travel = np.linspace(0.0, 40.0, 81)
    truth = specimen(travel, cell=0.5, effects=effects)
    for number in (1, 2, 3):
        size = float(np.sqrt(np.mean(truth.force**2)))
        force = truth.force * (1.0 + 0.5 * noise * rng.standard_normal()) + noise * size * rng.standard_normal(81)
        rows = [f"{u:.3f},{value:.4f}" for u, value in zip(travel[1:], force[1:], strict=True)]
        (folder / f"punch_{number}.csv").write_text("\n".join(["displacement_mm,force_N", *rows]) + "\n")
    rows = ["displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm"]
    for step in range(5, 81, 5):
        for number in range(0, 90, 15):
            place = truth.positions[step, number, -1] + 0.05 * rng.standard_normal(3)
            rows.append(f"{travel[step]:.3f},{truth.x[number]:.3f}," + ",".join(f"{value:.4f}" for value in place))
    (folder / "free_edge.csv").write_text("\n".join(rows) + "\n")
    (folder / "measured.yaml").write_text(
        "title: three specimens\nchannels:\n"
        f"  punch_force: {{files: [punch_1.csv, punch_2.csv, punch_3.csv], noise: {noise * size:.3g} N}}\n"
        "  free_edge: {file: free_edge.csv, noise: 0.05 mm}\n"
    )
    return folder


def diagnosed(out: Path, *options: str, code: int = 0) -> dict[str, Any]:
    """Run the verb and return diagnosis.json."""
    among = [part for name in AMONG for part in ("--among", name)]
    assert main(["diagnose", "punch", "--measured", "set", "-o", str(out), "--jobs", "1", *among, *options]) == code
    found: dict[str, Any] = json.loads((out / "diagnosis.json").read_text())
    return found


def test_a_hidden_clamp_slip_is_named_patched_and_proven(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    measure(tmp_path / "set", effects={"clamp_slip": {"limit": 12.0}})
    out = tmp_path / "out"
    found = diagnosed(out)
    assert set(found) >= KEYS
    assert (found["verdict"], found["patch"]) == ("named", "patch.yaml")
    effect = found["effects"][0]
    assert effect["id"] == "clamp_slip"
    limit = effect["parameters"]["limit"]
    assert limit["unit"] == "N/mm"
    assert limit["low"] <= limit["value"] <= limit["high"]
    assert limit["value"] == pytest.approx(12.0, rel=0.05)
    assert found["where"][0]["channel"] == "punch_force"
    gaps = {(row["channel"], row["part"]): row for row in found["gap"]}
    assert set(gaps) == {(c, p) for c in ("punch_force", "free_edge") for p in ("fitted", "held_out")}
    held = gaps["punch_force", "held_out"]
    assert held["after_percent"] < 0.3 * held["before_percent"]
    assert held["after_chi"] < 2.0 < held["before_chi"]
    rows = {row["id"]: row for row in found["candidates"]}
    assert set(AMONG) <= set(rows)
    assert rows["clamp_slip"]["rejected_because"] == ""
    assert rows["punch_friction"]["rejected_because"]
    patch = read_patch(out / "patch.yaml")
    assert patch.effects[0].parameters["limit"] == limit["value"]
    assert patch.base is not None
    assert patch.base.sha256 == found["case"]["sha256"]
    assert patch.valid is not None
    assert patch.valid.displacement == (0.0, 40.0)
    text = capsys.readouterr()
    assert "Verdict: named" in text.out
    assert max(map(len, text.out.splitlines())) <= 80
    for stage in ("0 numerics gate", "1 detect", "2 screen", "4 rank", "5 verdict", "7 patch and prove"):
        assert stage in text.err
    page = (out / "report.html").read_text()
    assert "clamp_slip explains the gap" in page
    assert (out / "gap.png").stat().st_size > 10_000
