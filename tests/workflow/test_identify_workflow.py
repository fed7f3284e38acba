"""From files to a fabric file: folder and lists, what the file holds, what is refused, the shipped nylon."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.nylon_data import ANGLES, FOLDER, load_nylon

from etextile.app.verbs_identify import identify as verb
from etextile.errors import BadInput
from etextile.identify.coupon import loading_curve, pull
from etextile.identify.result import identify_fabric
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.identify import curves_of, identify_curves, read_lists, write
from etextile.text.identify import identification_text
from loadcases.fabric import load_fabric


LAWS = {
    "warp": (PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.0561 / 0.0155, 0.12),
    "weft": (PowerLaw(4500.0, 0.2, 4230.0, 1.1), 0.0997 / 0.0155, 0.12),
    "bias": (PowerLaw(1500.0, 0.2, 1550.0, 2.2), 0.0489 / 0.0155, 0.45),
}


def measured(path: Path, *directions: str, unloading: int = 40) -> Path:
    rng = np.random.default_rng(11)
    lines = ["title: synthetic coupons", "channels:", "  tensile:", "    strain_from: specimen"]
    for direction in directions:
        law, ratio, top = LAWS[direction]
        names = []
        for i in (1, 2):
            strain, stress = pull(law, top, area_ratio=ratio, unloading=max(unloading, 1))
            if unloading == 0:
                strain, stress = strain[:-1], stress[:-1]
            stress = stress + rng.normal(0.0, 0.01 * stress.max(), len(stress))
            names.append(f"{direction}_{i}.csv")
            table = np.column_stack([strain, stress])
            np.savetxt(path / names[-1], table, delimiter=",", header="strain,stress_MPa", comments="")
        lines.append(f"    {direction}: [{', '.join(names)}]")
    (path / "measured.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_folder_becomes_a_fabric_file_that_reads_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Noise of 1 % hides a preload of some tenths of a per cent that was set to zero: H is known to 16 %, n to 5 %."""
    output = tmp_path / "out" / "fabric.yaml"
    assert verb(measured(tmp_path, *LAWS), output=output) == 0
    fabric = load_fabric(output)
    for direction, family in (("warp", fabric.warp), ("weft", fabric.weft), ("bias", fabric.diagonal)):
        law, _, top = LAWS[direction]
        for name, limit, widest in (("E", 0.05, 0.05), ("H", 0.08, 0.18), ("n", 0.02, 0.06)):
            found = getattr(family, name)
            assert found.value == pytest.approx(getattr(law, name), rel=limit)
            assert found.std is not None
            assert 0.5 * abs(found.value - getattr(law, name)) < found.std < widest * found.value
        assert family.covariance is not None
        assert family.covariance.parameters == ("E", "H", "n")
        assert family.covariance.matrix[1][1] ** 0.5 == pytest.approx(family.H.std, rel=1e-4)
        assert family.covariance.between_specimens is not None
        assert family.strain_range == pytest.approx((0.0, top))
        assert not family.estimated
    text = capsys.readouterr().out
    assert "paper's procedure" in text
    assert max(len(line) for line in text.splitlines() if not line.startswith("wrote")) <= 80
    names = ("measured_curves", "modulus_fit", "hardening_fit", "fitted_curves")
    assert sorted(path.name for path in output.parent.glob("*.png")) == sorted(f"fabric_{name}.png" for name in names)


def test_lists_of_files_do_the_same_as_the_folder(tmp_path: Path) -> None:
    folder = measured(tmp_path, "warp")
    title, curves = curves_of(folder)
    files = {"warp": [tmp_path / "warp_1.csv", tmp_path / "warp_2.csv"]}
    from_lists = read_lists(files, on_specimen=True)
    one, other = (identify_curves(item, title=title).fabric for item in (curves, from_lists))
    assert one == other
    assert one.weft.source == "not measured, from estimated_mid"
    assert one.weft.estimated
    assert one.weft.H == load_fabric("estimated_mid").weft.H


def test_a_modulus_without_unloading_is_said_to_be_unidentified(tmp_path: Path) -> None:
    title, curves = curves_of(measured(tmp_path, "warp", unloading=0))
    result = identify_curves(curves, title=title)
    family = result.fabric.warp
    assert family.E.estimated
    assert family.E.std is None
    assert family.E.source == "unidentified (no unloading measured), taken from estimated_mid"
    assert family.covariance is not None
    assert family.covariance.parameters == ("H", "n")
    assert "E is unidentified" in identification_text(result)
    assert write(result, tmp_path / "fabric.yaml", plots=False).fabric_file is not None
    assert load_fabric(tmp_path / "fabric.yaml").warp.E.source == family.E.source


def test_problems_of_all_files_come_together_and_nothing_is_written(tmp_path: Path) -> None:
    folder = measured(tmp_path, "warp", "weft")
    (tmp_path / "warp_1.csv").write_text("strain,stress_MPa\n0,0\n0.01,x\n", encoding="utf-8")
    (tmp_path / "weft_2.csv").write_text("", encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        verb(folder, output=tmp_path / "fabric.yaml")
    assert [(Path(item.file).name, item.line) for item in caught.value.problems] == [
        ("warp_1.csv", 3),
        ("weft_2.csv", 1),
    ]
    assert not list(tmp_path.glob("fabric*"))


def test_a_file_of_another_origin_is_not_overwritten(tmp_path: Path) -> None:
    folder = measured(tmp_path, "warp")
    output = tmp_path / "mine.yaml"
    output.write_text("title: mine\n", encoding="utf-8")
    with pytest.raises(BadInput, match="not overwritten without --force"):
        verb(folder, output=output)
    assert output.read_text(encoding="utf-8") == "title: mine\n"
    assert verb(folder, output=output, force=True, quiet=True) == 0
    assert verb(folder, output=output, quiet=True) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "give either a folder of measurements or lists"),
        ({"warp": (Path("a.csv"),), "width": "29 mm"}, "--thickness, --gauge-length is missing"),
        ({"warp": (Path("a.csv"),), "width": "29 mm", "thickness": "thin", "gauge_length": "60"}, "not a number|text"),
    ],
)
def test_options_that_do_not_fit_together_are_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        verb(None, **arguments)  # type: ignore[arg-type]


def test_another_thickness_than_the_fabrics_is_refused() -> None:
    weave = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
    with pytest.raises(BadInput, match=r"thickness 0\.067 mm differs from the fabric's 0\.35 mm"):
        identify_fabric({"warp": [load_nylon(0)]}, weave, named={})


def test_the_shipped_nylon_is_what_identification_returns_before_it_is_refined() -> None:
    """Refinement moves H and n and nothing else; that its strips return the curves is tested with it."""
    title, curves = curves_of(FOLDER)
    again = identify_curves(curves, title=title, fabric="nylon_woven", modulus_from="estimated_mid").fabric
    shipped = load_fabric("nylon_woven")
    for name in ("warp", "weft", "diagonal"):
        ours, theirs = getattr(again, name), getattr(shipped, name)
        assert ours.E.value == pytest.approx(theirs.E.value, rel=1e-3)
        assert ours.H.std / ours.H.value == pytest.approx(theirs.H.std / theirs.H.value, rel=1e-3)
        assert ours.n.std == pytest.approx(theirs.n.std, rel=1e-3)
        assert ours.strain_range == pytest.approx(theirs.strain_range, rel=1e-3)
        assert ours.compression_ratio == theirs.compression_ratio == 1.0
        assert theirs.E.estimated
        assert "unidentified" in theirs.E.source
        assert "refined by virtual coupons" in theirs.source


def test_the_nylon_laws_return_the_measured_curves_within_two_per_cent_of_the_peak() -> None:
    _, curves = curves_of(FOLDER)
    identified = identify_curves(curves, title="nylon", fabric="nylon_woven", modulus_from="estimated_mid").identified
    for family in identified.families.values():
        (fit,) = family.fit.specimens
        hencky = np.log1p(fit.segments.strain) - fit.hardening.datum
        stress = loading_curve(family.law, hencky).stress / family.area_ratio
        assert np.abs(stress - fit.segments.stress).max() < 0.02 * fit.segments.stress.max()


def test_nylon_curves_are_there_for_every_angle() -> None:
    peaks = {angle: float(load_nylon(angle).stress.max()) for angle in ANGLES}
    assert peaks[90] > 1.9 * peaks[0] > 4.0 * peaks[45]
    assert peaks[30] == pytest.approx(12.166 / (27.0 * 0.067), rel=1e-3)


def test_shipped_measurements_are_found_by_name() -> None:
    title, curves = curves_of("hidden_clamp")
    assert title
    assert {direction: len(found) for direction, found in curves.items()} == {"warp": 3, "weft": 3, "bias": 3}
    with pytest.raises(BadInput, match="did you mean 'hidden_clamp'"):
        curves_of("hiden_clamp")
