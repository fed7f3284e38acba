"""What is built in, as `etextile list` shows it."""

from __future__ import annotations

import pytest

from etextile.app.cli import main
from etextile.effects.registry import EFFECTS
from etextile.text.listing import KINDS
from loadcases import catalogue
from loadcases.schema_bond import Slipping
from loadcases.schema_loops import Loops
from loadcases.schema_scatter import Scatter
from loadcases.schema_wires import Wires
from loadcases.wire_material import NUMBERS
from wires.failure import CRITERIA


def listed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["list", *arguments]) == 0
    return capsys.readouterr().out


def test_all_kinds_are_listed_with_all_names(capsys: pytest.CaptureFixture[str]) -> None:
    text = listed(capsys)
    names = [*catalogue.names("case"), *catalogue.names("fabric"), *catalogue.names("wire material"), *CRITERIA]
    names += ["sphere", "ellipsoid", "capsule", "mesh", "elbow", "knee", "band", "pardiso", "superlu", *EFFECTS]
    for name in names:
        assert f"\n  {name} " in text, name
    assert [line[:-1] for line in text.splitlines() if line.endswith(":")] == list(KINDS)


def test_kinds_are_listed_in_the_order_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    text = listed(capsys, "wires", "cases")
    assert text.index("wires:") < text.index("cases:")
    assert "fabrics:" not in text


def test_an_unknown_kind_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "fabrcs"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("etextile: nothing to list (got 'fabrcs'), known are cases, fabrics")
    assert captured.err.strip().endswith("did you mean 'fabrics'?")


def test_every_number_of_a_wire_has_a_source_or_is_marked_estimated(capsys: pytest.CaptureFixture[str]) -> None:
    text = listed(capsys, "wires", "-v")
    header, *rows = text.split("wire numbers:\n")[1].split("\n\n")[0].splitlines()
    place = header.index("source")
    assert len(rows) == len(NUMBERS) * len(catalogue.names("wire material"))
    assert all(row[place:].strip() for row in rows)
    header, *rows = text.split("defaults of the case file:\n")[1].split("\n\n")[0].splitlines()
    keys = {row.split()[0] for row in rows}
    numbers = {
        f"{section}.{name}"
        for section, model in (("wires", Wires), ("wires.loops", Loops), ("wires.bond", Slipping))
        for name, info in model.model_fields.items()
        if isinstance(info.default, (int, float)) and not isinstance(info.default, bool)
    }
    assert numbers <= keys
    assert len(numbers) > 9
    assert all(row[header.index("source") :].startswith(("stated", "estimated")) for row in rows)
    header, *rows = text.split("criteria parameters:\n")[1].split("\n\n")[0].splitlines()
    assert len(rows) == sum(len(criterion.parameters) for criterion in CRITERIA.values())
    assert all(row[header.index("source") :].startswith(("stated", "derived", "estimated")) for row in rows)


def test_every_scatter_of_an_ensemble_has_a_source_or_is_marked_estimated(capsys: pytest.CaptureFixture[str]) -> None:
    header, *rows = listed(capsys, "scatter").split("scatter:\n")[1].split("\n\n")[0].splitlines()
    assert {row.split()[0] for row in rows} == {f"scatter.{name}" for name in Scatter.model_fields}
    assert all(row[header.index("source") :].startswith(("derived", "estimated")) for row in rows)


def test_every_effect_shows_its_card(capsys: pytest.CaptureFixture[str]) -> None:
    text = listed(capsys, "effects", "-v")
    for name, effect in EFFECTS.items():
        card = text.split(f"effect {name}:\n")[1].split("\n\n")[0]
        assert card.split(None, 1)[1].startswith(effect.card.mechanism)
        for parameter in effect.card.parameters:
            assert parameter.meaning in card
            assert f"{parameter.low:g} to {parameter.high:g}" in card
        assert all(f"in {item.channel}" in card for item in effect.card.signature)
        assert "mm at 10 / 20 / 25 / 30 / 40 mm with" in card
        assert effect.card.literature in card


def test_fabrics_are_marked_estimated(capsys: pytest.CaptureFixture[str]) -> None:
    text = listed(capsys, "fabrics", "-v")
    laws = text.split("fabric laws:\n")[1].strip().splitlines()[1:]
    assert sum("estimated: anchor" in row for row in laws if row.strip().startswith("estimated_")) == 9


def test_piped_tables_are_plain_aligned_and_whole(capsys: pytest.CaptureFixture[str]) -> None:
    text = listed(capsys, "criteria", "-v")
    assert text.isascii()
    assert "\x1b" not in text
    rows = text.split("criteria parameters:\n")[1].strip("\n").splitlines()
    column = rows[0].index("default")
    assert all(row[column - 1] == " " and row[column] != " " for row in rows if row)
    source = CRITERIA["span_strain"].parameters[0].source
    assert source in text
