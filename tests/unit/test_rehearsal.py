"""What is a user's own fails in `check`, at its line, and not only in the run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from etextile import foreign_code
from etextile.app.cli import main
from etextile.contact.own import own_body
from etextile.errors import BadInput


CASE = "schema_version: 1\nextends: punch\nfabric: {portion: whole, coarsening: 45}\n"
EFFECT = '''
from dataclasses import dataclass, replace
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature
from etextile.effects.change import lattice_block, with_lattice_block


@dataclass(frozen=True)
class Softer(Effect):
    """Yarns are softer."""

    share: float = 0.0
    card: ClassVar[Card] = Card(
        id="softer",
        mechanism="Yarns are softer.",
        parameters=(Parameter("share", "", 0.0, 0.9, "the share of the yarns' area that is lost"),),
        example=Example({"share": 0.3}),
        signature=(Signature("punch_force", -1, 0.0, "less"),),
        separate="A coupon.",
    )

    def transform(self, model):
        block = lattice_block(model)
        return with_lattice_block(model, replace(block, CHANGED))
'''
CRITERION = '''
from dataclasses import dataclass

import numpy as np

import etextile as et


@dataclass(frozen=True)
class Mine:
    """Wires by their strain."""

    name: str = "mine"
    summary: str = "by strain"
    parameters: tuple = (
        et.CriterionParameter("onset", 0.06, "", "estimated", "strain at which filaments break"),
        et.CriterionParameter("scale", 0.026, "", "estimated", "Weibull scale beyond the onset"),
        et.CriterionParameter("shape", 1.2, "", "estimated", "Weibull shape"),
        et.CriterionParameter("scatter", 0.005, "", "estimated", "standard deviation of the onset"),
        et.CriterionParameter("filaments", 7, "", "stated", "filaments of a wire", minimum=1),
    )

    def evaluate(self, history, parameters):
        strain = history.JUDGED
        flows = np.full(strain.shape[1], 0.002)
        return et.bundle_damage(
            history, strain, yield_strain=flows, criterion=self.name, parameters=parameters, strain_kind="wire"
        )
'''
BODY = """
import numpy as np
import etextile as et


def ball(*, radius):
    reach = 1.2 * radius
    body = et.implicit_body(
        lambda points: np.linalg.norm(points, axis=1) - radius, low=[-reach] * 3, high=[reach] * 3, edge=radius / 8
    )

    class Turned:
        surface, bounds, support = body.surface, body.bounds, body.support

        def distance(self, points):
            found = body.distance(points)
            return et.Distance(SIGN * found.gap, SIGN * found.normal, SIGN * found.hessian)

    return Turned()
"""
OWN = {
    "effect": ("effects:\n  - {id: softer, file: mine.py, share: 0.2}\n", EFFECT, "CHANGED", "area=0.9 * block.area"),
    "criterion": ("failure: {criterion: mine, file: mine.py}\n", CRITERION, "JUDGED", "wire_strain"),
    "body": ("body: {type: own, shape: ball, file: mine.py, dimensions: {radius: 15}}\n", BODY, "SIGN", "1.0"),
}


def written(folder: Path, kind: str, value: str | None = None) -> Path:
    section, code, word, right = OWN[kind]
    (folder / "mine.py").write_text(code.replace(word, right if value is None else value))
    path = folder / "case.yaml"
    path.write_text(CASE + section)
    return path


@pytest.mark.parametrize("kind", OWN)
def test_check_lets_pass_what_works(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(written(tmp_path, kind)), "--allow-code"]) == 0
    assert "ready to run" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("kind", "value", "said"),
    [
        ("effect", "area=block.aera", r"mine\.py:\d+: transform fails: AttributeError.*'aera'"),
        (
            "effect",
            "area=block.area[:3]",
            r"softer makes a model that cannot be computed: area of the trusses .* has the shape \(3,\)",
        ),
        ("criterion", "wire_strian", r"mine\.py:\d+: .*AttributeError.*'wire_strian'"),
        ("body", "-1.0", "gap and normal may both have the wrong sign"),
    ],
)
def test_check_finds_what_fails(
    kind: str, value: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(written(tmp_path, kind, value)), "--allow-code"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.search(said, captured.err), captured.err
    assert "fault of the program" not in captured.err


def test_a_body_turned_inside_out_is_refused(tmp_path: Path) -> None:
    written(tmp_path, "body", "-1.0")
    with foreign_code.trusting(), pytest.raises(BadInput, match="both have the wrong sign"):
        own_body(shape="ball", file=str(tmp_path / "mine.py"), dimensions={"radius": 15.0})


@pytest.mark.slow
def test_strains_of_a_run_that_a_file_judged_are_drawn_without_its_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    quick = ["--set", "motion.total=3", "--set", "motion.steps=1", "--set", "outputs.maps=[failure, wire_strain]"]
    main(["run", str(written(tmp_path, "criterion")), "--allow-code", "-o", str(out), "--quiet", *quick])
    (tmp_path / "mine.py").write_text("raise SystemExit('this code must not run')")
    foreign_code.forget()
    capsys.readouterr()
    assert main(["map", str(out), "--output", str(tmp_path / "maps")]) == 0
    captured = capsys.readouterr()
    assert "wire_strain.png" in captured.out
    assert "the map of states is left out" in captured.err
    assert main(["map", str(out), "--field", "failure"]) == 2
    assert "map runs no Python code" in capsys.readouterr().err
