"""The verbs compare and diagnose from files to files, on a specimen whose mechanics is a formula.

The formula stands in the place of the simulator: force and edge follow power laws of the displacement, the clamp takes
the force up to a limit. So the surfaces are tested in seconds; the simulator itself has its own tests.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from html import unescape
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from etextile.app.cli import main
from etextile.diagnose.data.observe import PEAKS, Record, observe
from etextile.diagnose.predict.simulate import EffectSpec, Request, Runner
from etextile.effects.registry import EFFECTS
from etextile.errors import NoEquilibrium
from etextile.studies.diagnose import proof as diagnose_proof
from etextile.studies.diagnose import run as diagnose_run
from etextile.studies.diagnose.folder import CACHE, Folder
from etextile.studies.diagnose.proof import Proven, prove_patch
from etextile.studies.diagnose.simulator import CaseSimulator
from etextile.studies.run.outcome import Run
from loadcases.patch import Strains, read_patch
from loadcases.reader import LoadedCase


HALF = 50.0
COUPON = 9960.0
KEYS = {
    "verdict", "effects", "ambiguous_with", "where", "gap", "candidates", "next_measurement", "patch", "simulations",
    "wall_s",
}  # fmt: skip
PAGE = Path(__file__).parents[2] / "etextile" / "manual" / "howto" / "own_effect.md"
TWINS = ("clamp_compliance", "machine_compliance")
AMONG = ("clamp_slip", "punch_friction", "rate_dependence")
PROOFS: dict[Path, tuple[Any, Any, Any]] = {}
"""What the proofs by formula were asked for (task, diagnosis, finalist), by the file of the patch."""


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
    for name in TWINS:  # two effects that nothing in these channels tells apart
        part = effects.get(name, {}).get("compliance", 0.0) / EFFECTS[name].card.parameters[0].high
        force, draw = force * (1.0 - 0.6 * part * share**2), draw * (1.0 + 0.2 * part * share)
    cracked = effects.get("cracked_coating", {}).get("share", 0.0)
    force, draw = force * (1.0 - 0.45 * cracked * share**2), draw * (1.0 + 0.2 * cracked * share)
    if "stick_slip" in effects:
        force = force * (1.0 + effects["stick_slip"]["size"] * np.sin(9.0 * share) * (share > 0.3))
    grid_x, grid_y = np.meshgrid(x, x, indexing="ij")
    dome = (1.0 - (grid_x / HALF) ** 2) * (1.0 - 0.7 * (grid_y / HALF) ** 2)
    positions = np.empty((len(travel), len(x), len(x), 3))
    positions[..., 0] = grid_x
    positions[..., 1] = grid_y - draw[:, None, None] * (grid_y / HALF) * (1.0 - (grid_x / HALF) ** 2)
    positions[..., 2] = travel[:, None, None] * dome
    peaks = np.outer(share, [0.3, 0.1, 0.3, 20.0, 30.0, 1e-2])[:, : len(PEAKS)]
    return Record(x, x, (True, True), travel, force, positions, peaks)


def formula(self: CaseSimulator, request: Request) -> Record:
    """Stand in for the simulator; the way back is the way there."""
    travel = np.linspace(request.back or 0.0, request.total, request.steps + 1)
    effects = {item.id: dict(item.parameters) for item in request.effects}
    found = specimen(travel, cell=0.28 * request.coarsening, stress=request.laws[0][2] / COUPON, effects=effects)
    return replace(found, force=found.force * wider(travel, effects, radius=self.case.body.radius))


def wider(travel: np.ndarray, effects: dict[str, dict[str, float]], *, radius: float) -> np.ndarray:
    """Return what a punch of another radius does to the force: it tells the twins apart."""
    part = effects.get(TWINS[1], {}).get("compliance", 0.0) / EFFECTS[TWINS[1]].card.parameters[0].high
    return 1.0 + (0.9 * part * (travel / 40.0) ** 2 if radius != 15.0 else 0.0)


def proof_by_formula(
    task: Any, diagnosis: Any, finalist: Any, patch: Path, *, folder: Any, runner: Any, advance: Any
) -> Proven:
    """Stand in for the ordinary runs: reads the patch as they do."""
    PROOFS[patch] = (task, diagnosis, finalist)
    effects = [
        EffectSpec.of(item.id, {k: v for k, v in item.parameters.items() if k != "file"})
        for item in read_patch(patch).effects
    ]
    request = diagnosis.levels.request(task.setting.base.laws, effects)
    raw = diagnosis.bench.raw
    added = observe(runner([request])[0], raw) - observe(diagnosis.base_runs.coarse, raw)
    return Proven(diagnose_proof._prove(diagnosis, added, None), None, None, (), ())


@pytest.fixture(scope="module", autouse=True)
def by_formula() -> Iterator[None]:
    """Put the formula in the place of the simulator."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(CaseSimulator, "__call__", formula)
        patch.setattr(diagnose_run, "prove_patch", proof_by_formula)
        yield


def measure(folder: Path, *, effects: dict[str, dict[str, float]], seed: int = 0, noise: float = 0.01) -> Path:
    """Write the folder of a test on two specimens with these hidden effects."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True)
    travel = np.linspace(0.0, 40.0, 41)
    truth = specimen(travel, cell=0.5, effects=effects)
    size = float(np.sqrt(np.mean(truth.force**2)))
    for number in (1, 2):
        force = truth.force * (1.0 + 0.5 * noise * rng.standard_normal()) + noise * size * rng.standard_normal(41)
        rows = [f"{u:.3f},{value:.4f}" for u, value in zip(travel[1:], force[1:], strict=True)]
        (folder / f"punch_{number}.csv").write_text("\n".join(["displacement_mm,force_N", *rows]) + "\n")
    rows = ["displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm"]
    for step in range(5, 41, 5):
        for number in range(0, 90, 30):
            place = truth.positions[step, number, -1] + 0.05 * rng.standard_normal(3)
            rows.append(f"{travel[step]:.3f},{truth.x[number]:.3f}," + ",".join(f"{value:.4f}" for value in place))
    (folder / "free_edge.csv").write_text("\n".join(rows) + "\n")
    (folder / "measured.yaml").write_text(
        "title: two specimens\nchannels:\n"
        f"  punch_force: {{files: [punch_1.csv, punch_2.csv], noise: {noise * size:.3g} N}}\n"
        "  free_edge: {file: free_edge.csv, noise: 0.05 mm}\n"
    )
    return folder


def diagnosed(folder: Path, *options: str, among: tuple[str, ...] = AMONG, code: int = 0) -> dict[str, Any]:
    """Run the verb on folder/set into folder/out and return diagnosis.json."""
    chosen = [part for name in among for part in ("--among", name)]
    places = ["--measured", str(folder / "set"), "-o", str(folder / "out")]
    assert main(["diagnose", "punch", *places, "--jobs", "1", *chosen, *options]) == code
    found: dict[str, Any] = json.loads((folder / "out" / "diagnosis.json").read_text())
    return found


@pytest.fixture(scope="module")
def clamp(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The diagnosis of a clamp that slips."""
    folder = tmp_path_factory.mktemp("clamp")
    measure(folder / "set", effects={"clamp_slip": {"limit": 12.0}})
    return folder, diagnosed(folder)


def test_a_hidden_clamp_slip_is_named_with_its_limit(clamp: tuple[Path, dict[str, Any]]) -> None:
    _, found = clamp
    assert set(found) >= KEYS
    assert (found["verdict"], found["patch"]) == ("named", "patch.yaml")
    effect = found["effects"][0]
    assert effect["id"] == "clamp_slip"
    limit = effect["parameters"]["limit"]
    assert limit["unit"] == "N/mm"
    assert limit["low"] <= limit["value"] <= limit["high"]
    assert limit["value"] == pytest.approx(12.0, rel=0.05)
    assert found["where"][0]["channel"] == "punch_force"


def test_the_gap_shrinks_where_nothing_was_fitted(clamp: tuple[Path, dict[str, Any]]) -> None:
    gaps = {(row["channel"], row["part"]): row for row in clamp[1]["gap"]}
    assert set(gaps) == {(c, p) for c in ("punch_force", "free_edge") for p in ("fitted", "held_out")}
    held = gaps["punch_force", "held_out"]
    assert held["after_percent"] < 0.3 * held["before_percent"]
    assert held["after_chi"] < 2.0 < held["before_chi"]
    rows = {row["row"] for row in clamp[1]["rows"]}
    assert rows == {"base", "re-tuned", "with effect", "floor"}


def test_the_patch_says_what_was_found_and_where_it_holds(clamp: tuple[Path, dict[str, Any]]) -> None:
    folder, found = clamp
    patch = read_patch(folder / "out" / "patch.yaml")
    limit = found["effects"][0]["parameters"]["limit"]
    assert patch.effects[0].parameters["limit"] == limit["value"]
    interval = next(item for item in patch.intervals if item.parameter == "limit")
    assert (interval.low, interval.high) == (limit["low"], limit["high"])
    assert patch.base is not None
    assert patch.base.sha256 == found["case"]["sha256"]
    assert patch.valid is not None
    assert patch.valid.displacement == (0.0, 40.0)
    text = (folder / "out" / "patch.yaml").read_text()
    assert found["command"] in text
    assert not (folder / "out" / "provisional.yaml").exists()


def test_every_other_effect_hears_why_not(clamp: tuple[Path, dict[str, Any]]) -> None:
    rows = {row["id"]: row for row in clamp[1]["candidates"]}
    assert set(AMONG) <= set(rows)
    assert rows["clamp_slip"]["rejected_because"] == ""
    assert all(row["rejected_because"] for name, row in rows.items() if name != "clamp_slip")
    assert rows["clamp_slip"]["held_out_percent"] < rows["punch_friction"]["held_out_percent"]


def test_page_and_pictures_come_with_it(clamp: tuple[Path, dict[str, Any]]) -> None:
    folder, found = clamp
    page = (folder / "out" / "report.html").read_text()
    assert found["sentence"] in unescape(page)
    assert 'src="data:image/svg+xml' in page
    for name in ("gap.png", "evidence.png"):
        assert (folder / "out" / name).read_bytes().startswith(b"\x89PNG")


def ordinary_record(loaded: LoadedCase, patch: Path | None = None) -> Record:
    """Return what the formula says about an ordinary run."""
    case = loaded.case
    effects = case.effects if patch is None else read_patch(patch).effects
    travel = np.linspace(0.0, case.motion.total, case.motion.steps + 1)
    return specimen(travel, cell=0.28 * case.fabric.coarsening, effects={item.id: item.parameters for item in effects})


def ordinary_run(loaded: LoadedCase, output: Path, *, patch: Path | None = None, **_: Any) -> Run:
    """Stand in for the ordinary command; with a patch the fabric is stretched by a third less."""
    found = ordinary_record(loaded, patch)
    strain = found.peaks[1:, :3] * (1.0 if patch is None else 2.0 / 3.0)
    report = {
        "punch": {"displacement_mm": list(found.displacement[1:])},
        "strain": {f"{name}_max": list(strain[:, i]) for i, name in enumerate(Strains.model_fields)},
    }
    return Run(0, output, report, found)  # type: ignore[arg-type]


@pytest.fixture
def proven_by_run(
    clamp: tuple[Path, dict[str, Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[float], tuple[Proven, int]]:
    """Prove the patch of the clamp that slips; the run with held-out displacements ends at a displacement (mm)."""
    path = clamp[0] / "out" / "patch.yaml"
    task, diagnosis, finalist = PROOFS[path]
    (tmp_path / "patch.yaml").write_bytes(path.read_bytes())

    def prove(end: float) -> tuple[Proven, int]:
        def held_out(loaded: LoadedCase, folder: Path, **_: Any) -> SimpleNamespace:
            found = ordinary_record(loaded)
            there = found.displacement <= end
            return SimpleNamespace(
                results=replace(
                    found, displacement=found.displacement[there], force=found.force[there],
                    positions=found.positions[there], peaks=found.peaks[there], completed=bool(there.all()),
                )
            )  # fmt: skip

        monkeypatch.setattr(diagnose_proof, "run", ordinary_run)
        monkeypatch.setattr(diagnose_proof, "simulate", held_out)
        monkeypatch.setattr(diagnose_proof, "record_of", lambda results: results)
        proven = prove_patch(
            task, diagnosis, finalist, tmp_path / "patch.yaml", folder=Folder(tmp_path, "key"),
            runner=Runner(task.simulator), advance=lambda done, total, words: None,
        )  # fmt: skip
        doubts = diagnose_run._doubts(diagnosis, proven)
        return proven, diagnose_run.DiagnosisOutcome(tmp_path, {}, diagnosis, doubts).exit_code

    return prove


def test_the_patch_holds_up_to_the_strains_of_the_run_with_it(
    proven_by_run: Callable[[float], tuple[Proven, int]], tmp_path: Path
) -> None:
    """Without the effect the formula stretches the warp to 0.3 at 40 mm, and further up to the end of the case."""
    before = (tmp_path / "patch.yaml").read_text()
    proven, code = proven_by_run(np.inf)
    assert (proven.notes, code) == ((), 0)
    valid = read_patch(tmp_path / "patch.yaml").valid
    assert valid is not None
    assert valid.displacement == (0.0, 40.0)
    assert valid.strain is not None
    assert valid.strain.model_dump() == pytest.approx({"warp": 0.2, "weft": 0.2 / 3.0, "diagonal": 0.2}, rel=1e-4)
    after = (tmp_path / "patch.yaml").read_text()
    kept = [line for line in after.splitlines() if not line.startswith("#")]
    assert kept[: kept.index("  strain:")] == [line for line in before.splitlines() if not line.startswith("#")]


def test_held_out_points_beyond_a_run_that_breaks_off_are_missed(
    proven_by_run: Callable[[float], tuple[Proven, int]],
) -> None:
    proven, code = proven_by_run(37.5)
    assert code == 4
    (note,) = proven.notes
    assert "fitted without the held-out displacements finds no equilibrium beyond 37.5 mm" in note
    lost = re.match(r"(\d+) of \d+ measured points, (\d+) of them held out", note)
    assert lost is not None
    assert lost[1] == lost[2] == str(2 * 3 + 3 * 3)  # forces at 38, 39, 40 mm twice; the edge at 40 mm in three places


@pytest.mark.slow
def test_a_repeated_call_uses_the_runs_of_the_first(
    clamp: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    folder, first = clamp
    assert first["simulations"] > 30
    assert len(list((folder / "out" / CACHE).glob("*.npz"))) == first["simulations"]
    again = diagnosed(folder)
    # kept runs are in single precision, so refits at the likeliest parameters may move by a hair and run again
    assert again["simulations"] < 0.4 * first["simulations"]
    assert again["verdict"] == first["verdict"]
    limits = [item["effects"][0]["parameters"]["limit"]["value"] for item in (first, again)]
    assert limits[1] == pytest.approx(limits[0], rel=1e-3)
    captured = capsys.readouterr()
    assert "Verdict: named" in captured.out
    assert max(map(len, captured.out.splitlines())) <= 80 + len(str(folder))
    for stage in ("0 numerics gate", "1 detect", "2 screen", "4 rank", "5 verdict", "7 patch and prove"):
        assert stage in captured.err


def test_another_measurement_does_not_overwrite_without_force(
    clamp: tuple[Path, dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, _ = clamp
    before = {path: path.stat().st_mtime_ns for path in (folder / "out").iterdir()}
    measure(tmp_path / "set", effects={}, seed=3)
    command = ["diagnose", "punch", "--measured", str(tmp_path / "set"), "-o", str(folder / "out"), "--jobs", "1"]
    assert main(command) == 2
    assert "of another case or measurement" in capsys.readouterr().err
    assert {path: path.stat().st_mtime_ns for path in (folder / "out").iterdir()} == before


@pytest.mark.slow
def test_nothing_hidden_is_no_gap_and_leaves_no_patch(tmp_path: Path) -> None:
    measure(tmp_path / "set", effects={}, seed=1)
    found = diagnosed(tmp_path)
    assert (found["verdict"], found["patch"], found["effects"]) == ("no_gap", None, [])
    assert all(row["before_percent"] == row["after_percent"] for row in found["gap"])
    assert all(row["before_chi"] < 2.0 for row in found["gap"])
    assert not (tmp_path / "out" / "patch.yaml").exists()
    assert "No gap" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_twins_stay_ambiguous_and_leave_no_proven_patch(tmp_path: Path) -> None:
    high = EFFECTS["clamp_compliance"].card.parameters[0].high
    measure(tmp_path / "set", effects={"clamp_compliance": {"compliance": 0.4 * high}}, seed=5)
    found = diagnosed(tmp_path, among=(*TWINS, "punch_friction"))
    assert (found["verdict"], found["patch"], found["provisional"]) == ("ambiguous", None, "provisional.yaml")
    assert {found["effects"][0]["id"], *found["ambiguous_with"]} >= set(TWINS)
    assert set(found["class"]) == set(TWINS)
    assert "these channels cannot tell" in found["sentence"]
    assert found["next_measurement"].startswith("To tell ")
    possible = {" + ".join(ids) for ids in found["ambiguous_sets"]}
    assert all((row["id"] in possible) is not bool(row["rejected_because"]) for row in found["candidates"])
    assert "NOT PROVEN" in (tmp_path / "out" / "provisional.yaml").read_text()
    assert read_patch(tmp_path / "out" / "provisional.yaml").effects[0].id in TWINS
    assert not (tmp_path / "out" / "patch.yaml").exists()
    held = next(row for row in found["gap"] if (row["channel"], row["part"]) == ("punch_force", "held_out"))
    assert held["after_percent"] < 0.5 * held["before_percent"]
    told_apart_by_the_measurement_that_it_asked_for(
        tmp_path, found, effects={"clamp_compliance": {"compliance": 0.4 * high}}
    )


def told_apart_by_the_measurement_that_it_asked_for(
    folder: Path, first: dict[str, Any], *, effects: dict[str, dict[str, float]]
) -> None:
    """The twins act alike but under another punch, which the plan finds; its folder is filled and diagnosed."""
    plan, place = first["next"], folder / "out" / "next"
    assert (plan["test"], plan["folder"]) == ("second_radius", "next")
    assert plan["repeats"]["specimens"] is None
    assert (
        max(item["bits"] for item in plan["options"] if item["test"] != "second_radius")
        < 0.1 * plan["options"][0]["bits"]
    )
    foretold = np.genfromtxt(place / "predictions.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    rng, travel = np.random.default_rng(3), np.linspace(1.0, 40.0, 40)
    truth = specimen(travel, cell=0.5, effects=effects)
    for name in ("second_radius_1.csv", "second_radius_2.csv"):
        assert (place / name).read_text() == "displacement_mm,force_N\n"
        force = truth.force * wider(travel, effects, radius=25.0) * (1.0 + 0.005 * rng.standard_normal())
        rows = [f"{u:.3f},{f + 5.0 * rng.standard_normal():.4f}" for u, f in zip(travel, force, strict=True)]
        (place / name).write_text("\n".join(["displacement_mm,force_N", *rows]) + "\n")
    own = np.interp(foretold["displacement_mm"], travel, truth.force)
    assert np.all((own > foretold["clamp_compliance_low"]) & (own < foretold["clamp_compliance_high"]))
    chosen = [part for name in (*TWINS, "punch_friction") for part in ("--among", name)]
    places = ["--measured", str(place), "-o", str(folder / "out"), "--jobs", "1"]
    assert main(["diagnose", "punch", *places, *chosen]) == 0
    found = json.loads((folder / "out" / "diagnosis.json").read_text())
    assert (found["verdict"], found["class"], found["next"]) == ("named", ["clamp_compliance"], None)
    assert found["simulations"] < 40 < first["simulations"] + 20
    (done,) = found["rounds"]
    assert done["test"] == "second_radius"
    assert done["before"][TWINS[1]] > 0.1 > 1e4 * done["after"][TWINS[1]]
    assert (folder / "out" / "patch.yaml").exists()


@pytest.mark.slow
def test_what_no_library_holds_is_not_named(tmp_path: Path) -> None:
    measure(tmp_path / "set", effects={"stick_slip": {"size": 0.12}}, seed=2)
    found = diagnosed(tmp_path)
    assert found["verdict"] == "unexplained"
    assert (found["patch"], found["effects"]) == (None, [])
    assert found["where"]
    assert "No effect of the library explains the gap" in found["sentence"]


@pytest.mark.slow
def test_the_effect_of_the_manual_takes_part(tmp_path: Path) -> None:
    blocks = re.findall(r"````{file} \w+.py\n(.*?)````", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    code = next(block for block in blocks if "class CrackedCoating" in block)
    (tmp_path / "coating.py").write_text(code)
    measure(tmp_path / "set", effects={"cracked_coating": {"share": 0.8}}, seed=4, noise=0.005)
    among = ("cracked_coating", "clamp_slip", "punch_friction")
    found = diagnosed(tmp_path, "--effect", str(tmp_path / "coating.py"), among=among)
    assert found["verdict"] == "named"
    assert found["effects"][0]["parameters"]["share"]["value"] == pytest.approx(0.8, rel=0.1)
    effect = read_patch(tmp_path / "out" / "patch.yaml").effects[0]
    assert (effect.id, Path(effect.parameters["file"]).name) == ("cracked_coating", "coating.py")


def test_a_case_that_finds_no_equilibrium_cannot_be_diagnosed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(self: CaseSimulator, request: Request) -> Record:
        found = formula(self, request)
        return replace(found, displacement=0.5 * found.displacement, completed=False)

    monkeypatch.setattr(CaseSimulator, "__call__", broken)
    measure(tmp_path / "set", effects={})
    command = ["punch", "--measured", str(tmp_path / "set"), "-o", str(tmp_path / "out"), "--jobs", "1"]
    for verb in ("compare", "diagnose"):
        assert main([verb, *command]) == NoEquilibrium.exit_code
        assert "no equilibrium beyond 20.0 mm, but was measured up to 40.0 mm" in capsys.readouterr().err


def test_an_interrupted_diagnosis_goes_on_from_its_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = 0

    def interrupted(self: CaseSimulator, request: Request) -> Record:
        nonlocal made
        made += 1
        if made == 10:
            raise KeyboardInterrupt
        return formula(self, request)

    measure(tmp_path / "set", effects={})
    command = ["compare", "punch", "--measured", str(tmp_path / "set"), "-o", str(tmp_path / "out"), "--jobs", "1"]
    monkeypatch.setattr(CaseSimulator, "__call__", interrupted)
    assert main(command) == 130
    assert "the same command goes on with them" in capsys.readouterr().err
    assert len(list((tmp_path / "out" / CACHE).glob("*.npz"))) == 9
    monkeypatch.setattr(CaseSimulator, "__call__", formula)
    assert main(command) == 0
    found = json.loads((tmp_path / "out" / "compare.json").read_text())
    assert 0 < found["simulations"] < 10


def test_compare_says_how_large_the_gap_is_and_where_it_begins(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    measure(tmp_path / "set", effects={"clamp_slip": {"limit": 12.0}})
    assert (
        main(["compare", "punch", "--measured", str(tmp_path / "set"), "-o", str(tmp_path / "out"), "--jobs", "1"]) == 0
    )
    found = json.loads((tmp_path / "out" / "compare.json").read_text())
    assert found["agree"] is False
    gap = {row["channel"]: row for row in found["gap"]}
    travel = np.linspace(1.0, 40.0, 40)
    slipping = specimen(travel, cell=0.5, effects={"clamp_slip": {"limit": 12.0}}).force
    off = slipping - specimen(travel, cell=0.5, effects={}).force
    expected = 100.0 * np.sqrt(np.mean(off**2) / np.mean(slipping**2))
    assert gap["punch_force"]["percent"] == pytest.approx(expected, rel=0.05)
    assert gap["punch_force"]["chi"] > 2.0
    text = capsys.readouterr().out
    assert found["where"][0]["sentence"].split(" from")[0] in text
    assert (tmp_path / "out" / "compare.png").read_bytes().startswith(b"\x89PNG")
