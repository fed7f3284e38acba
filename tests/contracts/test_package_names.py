"""Other distributions that use our package names are found and named, with what to do."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from etextile.collisions import FIRST_LINES, find_foreign, other_owners


ROOT = Path(__file__).parents[2]


@pytest.fixture
def planted(tmp_path: Path) -> Path:
    """Return a folder of installed packages with somebody else's `viz` in it."""
    package, listing = tmp_path / "viz", tmp_path / "viz-1.4.dist-info"
    package.mkdir()
    listing.mkdir()
    (package / "__init__.py").write_text("def plot():\n    return None\n")
    (listing / "METADATA").write_text("Metadata-Version: 2.1\nName: viz\nVersion: 1.4\n")
    (listing / "RECORD").write_text("viz/__init__.py,,\nviz-1.4.dist-info/METADATA,,\n")
    return tmp_path


def run(code: str, *first: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (*first, ROOT)))}
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment, cwd=ROOT / "tests"
    )


@pytest.mark.parametrize("name", FIRST_LINES)
def test_the_packages_beside_ours_hold_nothing_but_their_line(name: str) -> None:
    assert (ROOT / name / "__init__.py").read_text(encoding="utf-8").strip() == FIRST_LINES[name]
    assert find_foreign() == {}


def test_a_package_that_hides_ours_stops_the_command_with_its_name_and_the_remedy(planted: Path) -> None:
    done = run("from etextile.app.cli import main; raise SystemExit(main(['list', 'cases']))", planted)
    assert done.returncode == 2
    assert str(planted / "viz" / "__init__.py") in done.stderr
    assert "of the distribution viz" in done.stderr
    assert "pip uninstall viz" in done.stderr
    assert "Traceback" not in done.stderr


def test_the_front_door_says_the_same(planted: Path) -> None:
    done = run("import etextile as et\ntry:\n    et.load\nexcept et.errors.BadInput as e:\n    print(e)", planted)
    assert "'viz' is not that of etextile" in done.stdout + done.stderr


def test_an_overwritten_package_is_found(tmp_path: Path) -> None:
    for name, line in FIRST_LINES.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(line)
    (tmp_path / "wires" / "__init__.py").write_text("VERSION = 3")
    code = "from pathlib import Path; from etextile.collisions import find_foreign; print(*find_foreign(Path(PLACE)))"
    assert run(code.replace("PLACE", repr(str(tmp_path))), tmp_path).stdout.split() == ["wires"]


def test_check_warns_of_a_distribution_that_shares_a_name_and_hides_nothing(planted: Path) -> None:
    assert other_owners([str(planted)]) == {"viz": ["viz"]}
    code = "import sys; sys.path.append(sys.argv[1] if len(sys.argv) > 1 else PLACE)\n".replace(
        "PLACE", repr(str(planted))
    )
    done = run(f"{code}from etextile.app.cli import main; raise SystemExit(main(['check', 'punch']))")
    assert done.returncode == 0
    assert "'viz' (viz)" in done.stderr
