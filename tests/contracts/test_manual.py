"""The manual: every page is reached, nothing is loaded from the network, and the command says where it lies."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from etextile.app.cli import main
from etextile.manual import build
from loadcases.catalogue import names


SECTIONS = sorted(path.parent.name for path in build.SOURCES.glob("*/index.md"))


def test_every_page_stands_in_a_section_of_the_front_page() -> None:
    front = (build.SOURCES / "index.md").read_text(encoding="utf-8")
    assert {"tutorial", "howto", "theory", "formats", "api", "validation"} <= set(SECTIONS)
    assert [section for section in SECTIONS if f"\n{section}/index\n" not in front] == []
    reached = {build.SOURCES / "index.md", *(p for s in SECTIONS for p in (build.SOURCES / s).glob("*.md"))}
    written = {path for path in build.SOURCES.rglob("*.md") if build.PAGES not in path.parents}
    assert sorted(written - reached) == []


@pytest.mark.parametrize("section", SECTIONS)
def test_a_section_takes_up_every_page_in_its_folder(section: str) -> None:
    text = (build.SOURCES / section / "index.md").read_text(encoding="utf-8")
    pages = {page.stem for page in (build.SOURCES / section).glob("*.md")} - {"index"}
    every = ":glob:" in text and "\n*\n```" in text
    assert every or [page for page in sorted(pages) if f"\n{page}\n" not in text] == []


def test_every_shipped_case_is_a_script_of_the_gallery_of_at_most_25_lines() -> None:
    scripts = [path.read_text(encoding="utf-8") for path in (build.SOURCES / "gallery").glob("*.py")]
    assert [name for name in names("case") if not any(f'"{name}"' in text for text in scripts)] == []
    assert [text for text in scripts if len(text.splitlines()) > 25] == []


def test_no_two_scripts_of_the_gallery_run_into_one_folder() -> None:
    scripts = sorted((build.SOURCES / "gallery").glob("*.py"))
    folders = {path.stem: set(re.findall(r'"(out/[^"/{]+)', path.read_text(encoding="utf-8"))) for path in scripts}
    every = [folder for used in folders.values() for folder in used]
    assert len(every) >= len(names("case"))
    assert sorted({folder for folder in every if every.count(folder) > 1}) == []


def test_the_walks_through_the_code_lead_past_places_that_exist() -> None:
    page = (build.SOURCES / "howto" / "read_the_code.md").read_text(encoding="utf-8")
    places = re.findall(r"^\| `([\w/]+\.py)` \| `(\w+)` \|", page, re.MULTILINE)
    lost = [
        (file, name) for file, name in places
        if not re.search(rf"^ *(?:def|class) {name}\b", (build.ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)
    ]  # fmt: skip
    assert len(places) > 40
    assert lost == []


def test_what_a_page_shows_from_elsewhere_exists() -> None:
    assert [home for home in build.ELSEWHERE.values() if not (build.ROOT / home).is_file()] == []
    assert build.elsewhere("tests/workflow/NONE.md").startswith("# workflow\n")


def test_a_page_that_loads_from_the_network_is_found(tmp_path: Path) -> None:
    address = "https://example.org"
    (tmp_path / "a.html").write_text(f'<a href="{address}">a link is no load</a><img src="plot.png"/>')
    (tmp_path / "b.html").write_text(f'<script defer src="{address}/tex.js"></script>')
    (tmp_path / "c.html").write_text('<link rel="stylesheet" href="//example.org/a.css"/>')
    assert sorted(line[:6] for line in build.from_the_network(tmp_path)) == ["b.html", "c.html"]


def test_the_verb_names_the_pages_once_they_are_built_and_the_sources_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(build, "PAGES", tmp_path)
    assert main(["manual"]) == 0
    before = capsys.readouterr()
    assert Path(before.out.strip()) == build.SOURCES / "index.md"
    assert "etextile manual --build" in before.err
    (tmp_path / "index.html").touch()
    assert main(["manual"]) == 0
    after = capsys.readouterr()
    assert Path(after.out.strip()) == tmp_path / "index.html"
    assert after.err == ""
