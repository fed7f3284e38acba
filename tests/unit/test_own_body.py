"""Bodies of a user's own: from a Python file or a package, checked before anything is computed."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from etextile import foreign_code, plugins
from etextile.contact.own import body_function, implicit_body, own_body
from etextile.contact.sphere import sphere
from etextile.errors import BadInput
from loadcases.build import build
from loadcases.reader import load_case


BALL = '''
import numpy as np
import etextile as et


def ball(*, radius, squash=0.0):
    """A ball by its signed distance alone."""
    reach = 1.2 * radius
    return et.implicit_body(
        lambda points: np.linalg.norm(points, axis=1) - radius, low=[-reach] * 3, high=[reach] * 3, edge=radius / 12
    )


def turned(*, radius, angle_deg):
    return ball(radius=radius)


def liar(*, radius):
    body = ball(radius=radius)

    class Liar:
        surface, bounds, support = body.surface, body.bounds, body.support

        def distance(self, points):
            found = body.distance(points)
            return et.Distance(found.gap, -found.normal, found.hessian)

    return Liar()


def nothing(*, radius):
    return None


def broken(*, radius):
    return radius / 0.0
'''
CASE = """schema_version: 1
extends: punch
fabric: {portion: whole, coarsening: 40}
body: {type: own, shape: ball, file: ball.py, dimensions: {radius: 15 mm}}
"""


@pytest.fixture(autouse=True, scope="module")
def code_may_run() -> Iterator[None]:
    with foreign_code.trusting():
        yield


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "ball.py"
    path.write_text(BALL)
    return path


def test_a_signed_distance_alone_makes_a_body_that_contact_can_use() -> None:
    body = implicit_body(lambda x: np.linalg.norm(x, axis=1) - 15.0, low=(-18, -18, -18), high=(18, 18, 18), edge=1.25)
    exact = sphere(radius=15.0)
    points = np.random.default_rng(3).normal(size=(200, 3))
    points *= (15.0 + np.linspace(-0.3, 0.3, 200))[:, None] / np.linalg.norm(points, axis=1)[:, None]
    mine, true = body.distance(points), exact.distance(points)
    assert np.abs(mine.gap - true.gap).max() < 0.02
    assert np.abs(mine.normal - true.normal).max() < 0.03
    assert body.support(np.array([0.0, 0.0, 1.0])) == pytest.approx(15.0, abs=0.02)


def test_a_case_names_the_file_and_the_dimensions(file: Path) -> None:
    case = file.parent / "case.yaml"
    case.write_text(CASE)
    loaded = load_case(case)
    built = build(loaded.case)
    assert built.body is not None
    assert built.body.bounds()[1, 2] == pytest.approx(0.0, abs=1e-9)
    file.write_text(BALL + "\n# other\n")
    assert load_case(case).sha256 != loaded.sha256


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("shape: bal, file: ball.py", "did you mean 'ball'"),
        ("shape: ball, file: bull.py", "no such Python file"),
        ("shape: ball, file: ball.py", "ball needs radius"),
        ("shape: ball, file: ball.py, dimensions: {radius: 3 N}", "3 N"),
        ("shape: ball, file: ball.py, dimensions: {radius: 3, radios: 4}", "unknown dimension of ball.*'radius'"),
        ("shape: ball", "installed packages .* no function 'ball'"),
    ],
)
def test_what_is_wrong_with_it_is_said_at_its_line(file: Path, section: str, words: str) -> None:
    case = file.parent / "case.yaml"
    case.write_text(f"schema_version: 1\nextends: punch\nfabric: {{portion: whole}}\nbody: {{type: own, {section}}}\n")
    with pytest.raises(BadInput, match=words) as caught:
        load_case(case)
    assert {problem.line for problem in caught.value.problems} == {4}


def test_a_half_needs_a_body_that_is_known_to_be_symmetric(file: Path) -> None:
    case = file.parent / "case.yaml"
    case.write_text(CASE.replace("portion: whole", "portion: quarter"))
    with pytest.raises(BadInput, match=r"set fabric\.portion to whole"):
        load_case(case)


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ("nothing", "returns NoneType, which lacks distance"),
        ("broken", "broken fails: ZeroDivisionError"),
        ("liar", "positive outside"),
    ],
)
def test_what_is_no_body_is_refused_before_the_simulation(file: Path, shape: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        own_body(shape=shape, file=str(file), dimensions={"radius": 15.0})


def test_a_wrong_normal_is_found_by_differences(file: Path) -> None:
    file.write_text(BALL.replace("-found.normal", "found.normal * [1.0, 1.0, 1.4]"))
    with pytest.raises(BadInput, match="normal is not the gradient of gap"):
        own_body(shape="liar", file=str(file), dimensions={"radius": 15.0})


def test_angles_are_degrees_where_the_name_says_so(file: Path) -> None:
    own_body(shape="turned", file=str(file), dimensions={"radius": "1.5 cm", "angle_deg": "0.5 rad"})
    with pytest.raises(BadInput, match="angle_deg"):
        own_body(shape="turned", file=str(file), dimensions={"radius": 15.0, "angle_deg": "3 mm"})


def test_an_installed_body_is_found_by_its_entry_point(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(file.parent)
    point = EntryPoint("ball", "ball:ball", "etextile.bodies")
    monkeypatch.setattr(plugins, "entry_points", lambda group: [point] if group == "etextile.bodies" else [])
    assert body_function("ball", None).__name__ == "ball"


def test_a_box_without_a_body_is_refused() -> None:
    with pytest.raises(BadInput, match="nowhere negative"):
        implicit_body(lambda x: np.linalg.norm(x, axis=1) - 1.0, low=(50, 50, 50), high=(80, 80, 80))
    with pytest.raises(BadInput, match="corners of a box"):
        implicit_body(lambda x: x[:, 0], low=(0, 0, 0), high=(1, -1, 1))
