"""The page stands alone, says what the report says and shows it in the colours of the states."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from etextile.results.wire_history import WireHistory
from viz.html import MeasuredCurve, render_report_html
from wires.facts import CaseFacts, RunCurves, SolverFacts, WireFacts
from wires.failure import evaluate
from wires.layout import Portion, lay_out
from wires.report import build_report
from wires.trust import check_run


def report(
    *, strain: float = 0.2, title: str = "Elbow", portion: Portion = "whole", gap: float = 0.01
) -> dict[str, Any]:
    """Report of three wires whose strains fall from `strain` at the centre to nothing at the edge."""
    layout = lay_out(
        length_mm=100,
        width_mm=20,
        portion=portion,
        wire_spacing_mm=6.0,
        loop_spacing_mm=20.0,
        loop_length_mm=4.0,
        loop_slack=0.02,
    )
    travel = np.linspace(0.0, 40.0, 11)
    span = (
        (travel / 40.0)[:, None] * strain * np.exp(-((layout.loop_warp_mm / 30) ** 2) - (layout.loop_weft_mm / 6) ** 2)
    )
    history = WireHistory(
        displacement_mm=travel,
        span_strain=span,
        wire_strain=np.maximum((1 + span) / 1.02 - 1, 0.0),
        element_wire=np.zeros(0, dtype=np.int64),
        element_warp_mm=np.zeros(0),
        element_strain=np.zeros((travel.size, 0)),
        layout=layout,
    )
    return build_report(
        case=CaseFacts(title, "ab12", portion=portion, size_mm=(100, 20)),
        curves=RunCurves(travel, travel**2, travel / 100, travel / 300, travel / 200, travel / 10),
        solver=SolverFacts(170, 601, 10, 90, 0, True, 1.0, 0.8, gap, 0.002),
        checks=check_run(
            max_penetration_mm=gap,
            allowed_penetration_mm=0.02,
            energy_error=0.002,
            force_imbalance=1e-6,
            unconverged_increments=0,
        ),
        damage=evaluate(history),
        wires=WireFacts("copper_soft", 7, 0.03, 0.011),
        notes=("a remark",),
    )


@pytest.fixture
def usual_page(read_page: Callable[[str], Any]) -> Any:
    """The page of the usual report, made once."""
    return read_page(render_report_html(report()))


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    """A PNG of one pixel."""
    path = tmp_path / "warp_strain.png"
    path.write_bytes(
        bytes.fromhex(
            "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c49444154789c63f8cfc0000003010100"
            "c9fe92ef0000000049454e44ae426082"
        )
    )
    return path


def test_the_page_needs_nothing_else(picture: Path, read_page: Callable[[str], Any]) -> None:
    text = render_report_html(report(), maps=[picture], curves=[MeasuredCurve("test", [0, 20], [0, 300])])
    page = read_page(text)
    assert page.depth == []
    sources = [attrs["src"] or "" for tag, attrs in page.tags if tag == "img"]
    assert len(sources) == 4
    assert all(source.startswith("data:image/") for source in sources)
    assert not [tag for tag, _ in page.tags if tag in ("script", "link", "iframe")]
    assert not re.search(r"(?:src|href)=\"(?!data:)|url\(|@import", text)


def test_every_loop_is_shown_in_its_state(usual_page: Any) -> None:
    made = report()
    page = usual_page
    for state in ("intact", "plastic", "partial", "open"):
        cells = [attrs for _, attrs in page.tags if (attrs.get("class") or "") == f"cell {state}"]
        assert len(cells) == sum(loop["state"] == state for wire in made["wires"] for loop in wire["loops"]), state
    assert page.with_class("cell") == 15


def test_the_page_says_what_the_report_says(usual_page: Any) -> None:
    made = report()
    page = usual_page
    assert made["verdict"]["sentence"] in page.text
    assert "Wires fail" in page.text
    assert "a remark" in page.text
    assert "100 × 20 mm, whole modelled" in page.text
    assert "estimated" in page.text
    assert "SHA-256 ab12" in page.text


@pytest.mark.parametrize(
    ("strain", "gap", "headline", "tone"),
    [
        (0.03, 0.01, "The wires survive", "good"),
        (0.2, 0.01, "Wires fail", "bad"),
        (0.2, 0.03, "Verdict withheld", "withheld"),
    ],
)
def test_the_verdict_has_its_tone(
    strain: float, gap: float, headline: str, tone: str, read_page: Callable[[str], Any]
) -> None:
    page = read_page(render_report_html(report(strain=strain, gap=gap)))
    assert headline in page.text
    assert ("section", {"class": f"verdict {tone}"}) in page.tags


def test_a_break_that_is_possible_but_not_likelier_than_none_is_not_called_a_failure(
    read_page: Callable[[str], Any],
) -> None:
    made = report(strain=0.2, gap=0.01)
    page = read_page(render_report_html({**made, "verdict": {**made["verdict"], "first_failure": None}}))
    assert "Wires may fail" in page.text
    assert "Wires fail" not in page.text


def test_a_portion_tells_about_its_mirror_images(read_page: Callable[[str], Any], usual_page: Any) -> None:
    assert "A quarter is modelled" in read_page(render_report_html(report(portion="quarter"))).text
    assert "is modelled: mirror" not in usual_page.text


def test_text_of_the_case_cannot_break_the_page(read_page: Callable[[str], Any]) -> None:
    text = render_report_html(report(title="<script>alert(1)</script> & more"))
    assert "<script>" not in text
    assert "<script>alert(1)</script> & more" in read_page(text).text


def test_the_same_report_gives_the_same_page() -> None:
    assert render_report_html(report()) == render_report_html(report())


def test_a_case_without_wires_has_a_page(read_page: Callable[[str], Any]) -> None:
    made = {**report(), "wires": [], "damage": None, "failure": None, "wire_model": None}
    made["verdict"] = {**made["verdict"], "survive": None, "first_failure": None, "sentence": "The case has no wires."}
    page = read_page(render_report_html(made))
    assert "No verdict" in page.text
    assert "Worst loops" not in page.text
