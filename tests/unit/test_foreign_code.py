"""Code that a case, a patch or a result file names runs only when its user said so."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import pytest

import etextile as et
from etextile import foreign_code
from etextile.app.cli import main
from etextile.errors import BadInput
from etextile.process import LocalPool


BODY = """
from pathlib import Path
import numpy as np
import etextile as et

Path(MARK).write_text("ran")


def ball(*, radius):
    reach = 1.2 * radius
    return et.implicit_body(
        lambda points: np.linalg.norm(points, axis=1) - radius, low=[-reach] * 3, high=[reach] * 3, edge=radius / 6
    )
"""
EFFECT = """
from pathlib import Path

Path(MARK).write_text("ran")
"""
CASE = "schema_version: 1\nextends: punch\nfabric: {portion: whole, coarsening: 40}\n"
NAMED = {
    "body": "body: {type: own, shape: ball, file: mine.py, dimensions: {radius: 15 mm}}\n",
    "effect": "effects:\n  - {id: mine, file: mine.py, share: 0}\n",
    "criterion": "failure: {criterion: mine, file: mine.py}\n",
}


@pytest.fixture(autouse=True)
def nothing_allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(foreign_code, "settings_file", lambda: tmp_path / "settings" / "config.toml")
    before = foreign_code.allowed()
    foreign_code.forget()
    yield
    foreign_code.forget()
    foreign_code.allow(before)


@pytest.fixture
def mark(tmp_path: Path) -> Path:
    return tmp_path / "mark"


def written(folder: Path, mark: Path, kind: str = "body") -> Path:
    code = BODY if kind == "body" else EFFECT
    # each test its own content, since a module is run once per content
    (folder / "mine.py").write_text(code.replace("MARK", repr(str(mark))))
    path = folder / "case.yaml"
    path.write_text(CASE + NAMED[kind])
    return path


@pytest.mark.parametrize("kind", NAMED)
@pytest.mark.parametrize("verb", ["check", "run", "ensemble", "layout", "size-loops"])
def test_no_verb_runs_what_a_case_names(
    tmp_path: Path,
    mark: Path,
    kind: str,
    verb: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = written(tmp_path, mark, kind)
    monkeypatch.chdir(tmp_path)
    assert main([verb, str(case)]) == 2
    said = capsys.readouterr().err
    assert hashlib.sha256((tmp_path / "mine.py").read_bytes()).hexdigest() in said
    assert "case.yaml:" in said
    assert "--allow-code" in said
    assert not mark.exists()
    assert not (tmp_path / "out").exists()


def test_check_runs_it_when_asked_and_names_its_hash(
    tmp_path: Path, mark: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = written(tmp_path, mark)
    assert main(["check", str(case), "--allow-code"]) == 0
    said = capsys.readouterr().out
    assert f"body.file runs {tmp_path / 'mine.py'}, sha256 " in said
    assert hashlib.sha256((tmp_path / "mine.py").read_bytes()).hexdigest() in said
    assert mark.read_text() == "ran"


def test_what_was_allowed_once_is_known_by_its_content(tmp_path: Path, mark: Path) -> None:
    case = written(tmp_path, mark)
    with pytest.raises(BadInput, match="allow_code=True"):
        et.load(case)
    loaded = et.load(case, allow_code=True)
    et.build(loaded)
    et.load(case)
    (tmp_path / "mine.py").write_text((tmp_path / "mine.py").read_text() + "# changed\n")
    with pytest.raises(BadInput, match="not run unasked"):
        et.load(case)


def test_a_file_named_in_a_change_is_the_caller_s_own(tmp_path: Path, mark: Path) -> None:
    written(tmp_path, mark)
    body = {"type": "own", "shape": "ball", "file": str(tmp_path / "mine.py"), "dimensions": {"radius": 15}}
    loaded = et.load("punch", {"fabric.portion": "whole", "fabric.coarsening": 40, "body": body})
    assert mark.exists()
    assert loaded.case.body is not None


def test_a_patch_runs_nothing_unasked(tmp_path: Path, mark: Path) -> None:
    written(tmp_path, mark, "effect")
    patch = tmp_path / "patch.yaml"
    patch.write_text(NAMED["effect"])
    with pytest.raises(BadInput):
        et.run("punch", tmp_path / "out", patch=patch)
    assert not mark.exists()


def test_trusted_folders_are_the_user_s_settings(tmp_path: Path, mark: Path) -> None:
    inside = tmp_path / "cases"
    inside.mkdir()
    case = written(inside, mark)
    settings = tmp_path / "settings" / "config.toml"
    settings.parent.mkdir()
    settings.write_text(f'trusted_folders = ["{tmp_path / "other"}"]\n')
    with pytest.raises(BadInput, match="not run unasked"):
        et.load(case)
    settings.write_text(f'trusted_folders = ["{inside}"]\n')
    et.load(case)
    assert mark.exists()


@pytest.mark.parametrize("text", ["trusted_folders = [", "trusted_folders = 3", 'trusted_folders = ["here"]'])
def test_settings_that_cannot_be_read_say_so(tmp_path: Path, mark: Path, text: str) -> None:
    settings = tmp_path / "settings" / "config.toml"
    settings.parent.mkdir()
    settings.write_text(text)
    with pytest.raises(BadInput, match=r"config\.toml"):
        et.load(written(tmp_path, mark))
    assert not mark.exists()


def test_map_and_report_run_nothing_even_when_it_was_allowed(tmp_path: Path, mark: Path) -> None:
    path = tmp_path / "mine.py"
    written(tmp_path, mark)
    foreign_code.allow_file(path)
    with foreign_code.never("map"), pytest.raises(BadInput, match="map runs no Python code"):
        foreign_code.require(path, path.read_bytes(), key="failure.file")


def allowed_there(_: int) -> frozenset[str]:
    return foreign_code.allowed()


def test_workers_may_run_what_their_parent_may() -> None:
    foreign_code.allow(["a" * 64])
    with LocalPool(1) as pool:
        (outcome,) = pool.run(allowed_there, [0])
    assert outcome.result == frozenset(["a" * 64])
