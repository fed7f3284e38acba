"""The page of a sizing says what its data say, needs nothing else, and its data say which scatter is left out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from etextile.studies.sizing import _left_out
from loadcases.reader import load_case
from viz.sizing_html import render_sizing_html
from wires.sizing_words import sentences
from wires.trust import withheld


def sized(slack: float | None) -> dict[str, Any]:
    """Two loops, the more strained one with this slack."""
    length = None if slack is None else 4.6
    row = {
        "wire": 0, "name": "VCC <1>", "loop": 0, "weft_mm": 0.0, "warp_mm": 5.0, "span_strain": 0.2, "slack_now": 0.02,
        "probability_now": 1.0, "slack": slack, "probability": 0.01, "length_mm": length,
    }  # fmt: skip
    other = {**row, "loop": 1, "warp_mm": 25.0, "span_strain": 0.05, "slack": 0.03, "length_mm": 4.12}
    return {
        "title": "Elbow $\\frac{1$", "target": 0.01, "per": "loop", "criterion": "calibrated", "slack_for_all": slack,
        "crimp_now": 0.02, "crimp": 0.05, "probability_now": 1.0, "probability": 0.01, "loops": [row, other],
        "verdict": {"withheld": False, "sentence": ""},
        "notes": ["left out is the scatter of mounting strain (0.002)"], "verified": None,
    }  # fmt: skip


@pytest.mark.parametrize(("slack", "tone"), [(0.15, "good"), (None, "bad")])
def test_the_page_says_what_the_data_say(slack: float | None, tone: str, read_page: Callable[[str], Any]) -> None:
    data = sized(slack)
    page = read_page(render_sizing_html(data))
    assert page.depth == []
    assert ("section", {"class": f"verdict {tone}"}) in page.tags
    for sentence in (*sentences(data), *data["notes"], data["title"], "VCC <1>"):
        assert sentence in page.text
    assert ("15.0" if slack else "none is enough") in page.text
    sources = [attrs["src"] for tag, attrs in page.tags if tag == "img"]
    assert len(sources) == 2
    assert all(source.startswith("data:image/svg+xml") for source in sources)


def test_what_fails_to_hold_its_trust_limits_is_withheld(read_page: Callable[[str], Any]) -> None:
    held = withheld(["penetration 0.1 mm exceeds its limit"])
    data = sized(0.15) | {"verdict": {"withheld": True, "sentence": held}}
    page = read_page(render_sizing_html(data))
    assert ("section", {"class": "verdict withheld"}) in page.tags
    assert held in page.text


def test_scatter_that_is_left_out_is_named_with_its_size() -> None:
    quarter = _left_out(load_case("punch", overrides=["scatter.mounting=0"]).case)
    assert quarter == [
        "the laws of warp, weft, diagonal (1 x their covariance)",
        "slack from loop to loop (25 % of it)",
    ]
    whole = _left_out(load_case("punch", overrides=["fabric.portion=whole", "scatter.fabric=0"]).case)
    assert whole == [
        "mounting strain (0.002)", "shift of the wires (0.3 mm)", "shift of the loops (0.5 mm)",
        "body along x, y (0.5 mm)", "slack from loop to loop (25 % of it)",
    ]  # fmt: skip
