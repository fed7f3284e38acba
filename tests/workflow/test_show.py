"""The page of a folder is opened, or said where it is; printing needs a browser and says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from etextile.app.cli import main
from etextile.errors import BadInput, EtextileError
from etextile.studies import page


def test_without_a_display_the_place_of_the_page_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(page.sys, "platform", "linux")
    (tmp_path / "report.html").write_text("<p>")
    assert main(["show", str(tmp_path)]) == 0
    assert str(tmp_path / "report.html") in capsys.readouterr().out


def test_with_a_display_the_browser_opens_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(page.webbrowser, "open", lambda address: bool(opened.append(address)) or True)
    (tmp_path / "report.html").write_text("<p>")
    assert main(["show", str(tmp_path)]) == 0
    assert opened == [(tmp_path / "report.html").as_uri()]


def test_a_folder_without_a_page_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", str(tmp_path)]) == 2
    assert "there is no page in it" in capsys.readouterr().err
    with pytest.raises(BadInput, match="no such folder"):
        page.page_of(tmp_path / "none")


def test_printing_without_a_browser_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page.shutil, "which", lambda name: None)
    with pytest.raises(EtextileError, match="apt install chromium"):
        page.print_pdf(tmp_path / "report.html", tmp_path / "report.pdf")


@pytest.mark.slow
@pytest.mark.skipif(not any(map(page.shutil.which, page.BROWSERS)), reason="no Chromium on this machine")
def test_a_browser_prints_the_page(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("<h1>Wires</h1>")
    printed = page.print_pdf(tmp_path / "report.html", tmp_path / "report.pdf")
    assert printed.read_bytes().startswith(b"%PDF")
