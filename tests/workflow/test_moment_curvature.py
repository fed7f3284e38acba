"""A measured bending moment over the curvature: read, foretold by the law that was put in, calibrated and diagnosed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.diagnose.data.bent import read_moment_curvature
from etextile.diagnose.predict.bent import bent_record
from etextile.errors import BadInput
from etextile.results.reader import open_results
from etextile.studies.diagnose.setting import assemble
from loadcases.build_bent import bent_piece
from loadcases.measurements import load_measurements


COARSE = {"fabric.coarsening": 58.5}
HEAD = "curvature_1_per_m,moment_Nm_per_m\n"
MISTAKES = {
    "way back": ("0,0\n2,1\n1,1\n3,2\n4,3\n", "leave out repeats and the way back"),
    "other side": ("-1,0\n2,1\n3,1\n4,2\n5,3\n", "to one side"),
    "per millimetre": ("0,0\n0.01,1\n0.02,1\n0.03,2\n0.04,3\n", "convert to 1/m"),
    "four rows": ("0,0\n2,1\n3,1\n4,2\n", "at least 5"),
    "another unit": ("0,0\n2,1\n3,1\n4,2\n5,500\n", "N m per m"),
}


def law(curvature: np.ndarray, D: float, moment: float, share: float) -> np.ndarray:
    """Return the moment (N m/m) of curvatures in 1/m by the effect's own formula."""
    k = 1e-3 * curvature
    return np.asarray(D * k * (share + (1.0 - share) / np.sqrt(1.0 + (D * k / moment) ** 2)))


def softening(D: float, moment: float, share: float) -> dict[str, object]:
    return COARSE | {"effects": [{"id": "bending_stiffness", "D": D, "moment": moment, "share": share}]}


def measured(folder: Path, moment: np.ndarray, curvature: np.ndarray, more: str = "") -> Path:
    folder.mkdir()
    rows = "\n".join(f"{k:.6g},{m:.8g}" for k, m in zip(curvature, moment, strict=True))
    folder.joinpath("bent.csv").write_text(f"{HEAD}{rows}\n")
    text = "title: bent\nchannels:\n  moment_curvature: {files: [bent.csv], noise: 0.002 N}\n"
    folder.joinpath("measured.yaml").write_text(text + more)
    return folder


@pytest.mark.parametrize(("rows", "message"), MISTAKES.values(), ids=MISTAKES)
def test_wrong_records_are_named(rows: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bent.csv"
    path.write_text(HEAD + rows)
    with pytest.raises(BadInput, match=message):
        read_moment_curvature(path)


def test_units_of_bending_testers_are_converted(tmp_path: Path) -> None:
    path = tmp_path / "kes.csv"
    path.write_text("curvature_1_per_cm,moment_gfcm_per_cm\n" + "".join(f"{0.5 * i},{0.1 * i}\n" for i in range(6)))
    found = read_moment_curvature(path)
    np.testing.assert_allclose(found.curvature[-1], 250.0)
    np.testing.assert_allclose(found.moment[-1], 0.5 * 9.80665e-3)


@pytest.mark.parametrize("coarsening", [19.5, 58.5])
@pytest.mark.parametrize("portion", ["whole", "quarter"])
def test_the_moment_is_the_law_on_any_lattice_and_does_not_stretch(coarsening: float, portion: str) -> None:
    case = et.load("cantilever_d1388", softening(150.0, 0.3, 0.05) | {"fabric.coarsening": coarsening}).case
    if portion == "quarter":
        case = case.model_copy(update={"fabric": case.fabric.model_copy(update={"portion": portion})})
    k = np.array([0.5, 2.0, 8.0, 14.0])
    record = bent_record(bent_piece(case).model, k)
    np.testing.assert_allclose(record.force[1:], law(k, 150.0, 0.3, 0.05), rtol=1e-6)
    length = np.linalg.norm(np.diff(record.positions, axis=1), axis=-1)
    np.testing.assert_allclose(length, np.broadcast_to(length[0], length.shape), rtol=1e-12)


@pytest.mark.slow
def test_calibrate_finds_a_softening_law_and_holds_it_in_its_intervals(tmp_path: Path) -> None:
    k = np.linspace(0.0, 14.0, 29)
    noisy = law(k, 6.0, 0.03, 0.2) + np.random.default_rng(5).normal(0.0, 0.0005, len(k))
    folder = measured(tmp_path / "m", noisy, k)
    folder.joinpath("measured.yaml").write_text(folder.joinpath("measured.yaml").read_text().replace("0.002", "0.0005"))
    keys = [f"effects.bending_stiffness.{name}" for name in ("D", "moment", "share")]
    found = et.calibrate(
        et.load("cantilever_d1388", COARSE), folder, free=keys, output=tmp_path / "f.yaml", held_out=False, finer=False,
    )  # fmt: skip
    for key, truth in zip(keys, (6.0, 0.03, 0.2), strict=True):
        row = found.data["parameters"][key]
        assert row["identified"]
        assert row["low"] < truth < row["high"]
        assert row["high"] - row["low"] < 0.5 * truth
    noise = 100.0 * 0.0005 / np.sqrt(np.mean(noisy**2))
    assert found.data["gap"][0]["percent"] == pytest.approx(noise, rel=0.25)


def test_compare_tells_how_much_stiffer_a_ply_is(tmp_path: Path) -> None:
    k = np.linspace(0.0, 14.0, 15)
    folder = measured(tmp_path / "m", law(k, 1.5, 1e3, 1.0), k)
    row = et.compare(et.load("cantilever_d1388", COARSE), folder, tmp_path / "out").data["gap"][0]
    assert row["measured_over_computed"]["factor"] == pytest.approx(3.0, rel=1e-6)
    assert row["percent"] == pytest.approx(100.0 * 2.0 / 3.0, rel=1e-6)


PLAYS_NO_PART = {
    "pretension": "pretension needs clamped edges, the case has none",
    "clamp_slip": "nothing clamps the piece and no body presses it",
}


def test_effects_that_play_no_part_in_bending_are_told(tmp_path: Path) -> None:
    k = np.linspace(0.0, 14.0, 15)
    own = [{"id": "bending_stiffness", "D": 0.5}, {"id": "datum_offset", "offset": 0.5}]
    case = et.load("punch", {"effects": own, "fabric.coarsening": 39})
    folder = measured(tmp_path / "m", law(k, 0.5, 1e3, 1.0), k)
    task = assemble(case, load_measurements(folder), among=["rotational_shear", *PLAYS_NO_PART])
    assert [item.card.id for item in task.setting.candidates] == ["rotational_shear"]
    assert task.restrictions[-3:] == (
        *(f"{name} is left out of a bending test: {why}" for name, why in PLAYS_NO_PART.items()),
        f"datum_offset plays no part in bending: {PLAYS_NO_PART['clamp_slip']}",
    )


@pytest.mark.parametrize(
    ("case", "more", "message"),
    [
        ("cantilever_d1388", "  pressure_height: {files: [height.csv]}\n", "a test of its own"),
        ("burst_7cm2", "", "needs a flat rectangle"),
        ("elbow_sleeve", "", "needs a flat rectangle"),
    ],
)
def test_a_bending_test_stands_alone_on_a_rectangle(case: str, more: str, message: str, tmp_path: Path) -> None:
    k = np.linspace(0.0, 14.0, 6)
    folder = measured(tmp_path / "m", k, k, more)
    folder.joinpath("height.csv").write_text("pressure_bar,height_mm\n0.1,1\n0.2,2\n0.3,3\n")
    with pytest.raises(BadInput, match=message):
        et.compare(case, folder, tmp_path / "out")


def test_a_lattice_that_is_too_coarse_is_refused(tmp_path: Path) -> None:
    k = np.linspace(0.0, 400.0, 9)
    with pytest.raises(BadInput, match="too coarse for a curvature of 400"):
        et.compare(et.load("cantilever_d1388", COARSE), measured(tmp_path / "m", 0.01 * k, k), tmp_path / "out")


@pytest.mark.slow
def test_diagnose_names_bending_and_its_size(tmp_path: Path) -> None:
    k = np.linspace(0.0, 40.0, 41)
    noisy = law(k, 6.0, 1e3, 1.0) + np.random.default_rng(3).normal(0.0, 0.002, len(k))
    folder = measured(tmp_path / "m", noisy, k)
    case = et.load("cantilever_d1388", COARSE)
    done = et.diagnose(case, folder, tmp_path / "out", among=["bending_stiffness", "pretension"], jobs=1)
    assert done.data["verdict"] == "named"
    (effect,) = done.data["effects"]
    assert effect["id"] == "bending_stiffness"
    assert effect["parameters"]["D"]["low"] < 5.5 < effect["parameters"]["D"]["high"]
    assert [row["after_percent"] < 8.0 for row in done.data["gap"]] == [True] * len(done.data["gap"])


@pytest.mark.slow
def test_a_cantilever_in_equilibrium_has_the_moment_of_its_curvature(tmp_path: Path) -> None:
    """Weight beyond a station times its lever is the law at the curvature there."""
    run = et.run(et.load("cantilever_d1388", {"fabric.compression_ratio": 1}), tmp_path / "run")
    results = open_results(run.folder)
    points = results.points(results.steps - 1)
    flat = results.grid.reference
    x = np.unique(np.round(flat[:, 0], 6))
    line = np.array([points[np.isclose(flat[:, 0], place)].mean(axis=0) for place in x])
    h = float(np.diff(x).mean())
    weight = 9.80665e-3 * 1e-6 * 400.0 * h * np.array([0.5, *np.ones(len(x) - 2), 0.5])
    moments = np.array([float(np.sum(weight[i:] * (line[i:, 0] - line[i, 0]))) for i in range(len(x))])
    largest = moments.max()
    for i, moment in enumerate(moments[2:-1], start=2):
        first, second = (line[i] - line[i - 1]) / h, (line[i + 1] - line[i]) / h
        curvature = 2.0 * np.sin(0.5 * np.arccos(np.clip(first @ second, -1.0, 1.0))) / h
        assert abs(moment - 0.5 * curvature) < 0.01 * largest
