"""The page of a diagnosis stands alone, says what diagnosis.json says, and is drawn from it alone."""

from __future__ import annotations

import base64
import copy
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.pages import complaints

from etextile.text.diagnose import diagnosis_text
from viz.diagnosis_html import render_diagnosis_html
from viz.diagnosis_plots import Panel, Readings, Simulated
from viz.fields_page import field_map
from viz.scene import Scene


SAMPLE = json.loads((Path(__file__).parent / "diagnosis.json").read_text(encoding="utf-8"))
"""What `etextile diagnose punch --measured hidden_clamp` wrote."""


def sample(verdict: str = "named") -> dict[str, Any]:
    """Return the sample, turned into another verdict."""
    data: dict[str, Any] = copy.deepcopy(SAMPLE)
    data["verdict"] = verdict
    if verdict == "ambiguous":
        data |= {"ambiguous_with": ["yarn_tail"], "patch": None, "provisional": "provisional.yaml"}
    if verdict == "unexplained":
        data |= {"partial": data["effects"], "effects": [], "patch": None, "command": "", "wires": None}
    if verdict == "no_gap":
        data |= {"effects": [], "where": [], "patch": None, "command": "", "wires": None, "held_out": [], "as_run": []}
        data["stages"]["detect"]["detected"] = False
        data["rows"] = [row for row in data["rows"] if row["row"] == "base"]
    return data


def panel() -> Panel:
    """A small panel."""
    travel = np.linspace(0.5, 40.0, 20)
    curve = Simulated(travel, travel**2, 0.1 * travel)
    readings = (Readings(travel, travel**2, 0.0 * travel),)
    return Panel("punch_force", "punch force", "N", readings, curve, 0.2 * travel)


def test_the_page_needs_nothing_else(read_page: Callable[[str], Any]) -> None:
    text = render_diagnosis_html(sample(), panels=[panel()])
    page = read_page(text)
    assert page.depth == []
    sources = [attrs["src"] or "" for tag, attrs in page.tags if tag == "img"]
    assert len(sources) == 1
    assert all(source.startswith("data:image/") for source in sources)
    assert not [tag for tag, _ in page.tags if tag in ("link", "iframe")]
    assert not [attrs for tag, attrs in page.tags if tag == "script" and "src" in attrs]
    assert not re.search(r"(?:src|href)=\"(?!data:)|url\(|@import", text)


def runs(scene: Scene) -> list[dict[str, Any]]:
    """Two runs of two steps whose warp strain is the scene's and half of it; the second breaks nothing."""
    weaker = replace(scene.colouring, cells=0.5 * scene.colouring.cells, peak=0.5 * scene.colouring.peak)
    start = replace(scene, displacement_mm=0.0, colouring=replace(weaker, cells=0.0 * weaker.cells))
    quiet = replace(scene, colouring=weaker, loops=replace(scene.loops, state=0 * scene.loops.state))
    loops = [{"loop": k, "state": "open", "max_strain": 0.3, "first_failure_mm": 12.5, "failure_probability": 0.75}
             for k in range(3)]  # fmt: skip
    report = {"wires": [{"wire": k, "name": f"w{k}", "failure_probability": 1.0, "loops": loops} for k in range(3)]}
    return [
        field_map(name, {"warp_strain": [start, last]}, report)
        for name, last in (("without the effect", scene), ("with the effect", quiet))
    ]


def test_fields_of_the_runs_are_on_the_page_with_their_places_and_strains(scene: Callable[..., Scene]) -> None:
    made = scene()
    text = render_diagnosis_html(sample(), panels=[panel()], runs=runs(made))
    found = re.search(r'id="fields-data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    first, second = json.loads(found.group(1))["runs"]
    corners = np.frombuffer(base64.b64decode(first["cells"]), dtype="<u2").reshape(-1, 4, 2)
    places = np.array(first["flat"]["low"]) + first["flat"]["scale"] * corners
    assert places == pytest.approx(made.flat[made.quads][:, :, :2], abs=0.01)
    for run, share in ((first, 1.0), (second, 0.5)):
        field = run["fields"]["warp_strain"]
        values = np.frombuffer(base64.b64decode(field["values"]), dtype=np.uint8).reshape(2, -1) / 250.0 * field["most"]
        assert values[0].max() == 0.0
        assert values[1] == pytest.approx(share * made.colouring.cells, abs=0.1)
    assert [loop["states"][-1] for loop in second["loops"]] == [0] * len(second["loops"])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_browser_says_why_not_and_moves_both_fields(
    scene: Callable[..., Scene], tmp_path: Path, open_page: Callable[..., Any]
) -> None:
    path = tmp_path / "report.html"
    path.write_text(render_diagnosis_html(sample(), panels=[panel()], runs=runs(scene())), encoding="utf-8")
    tab = open_page(path)
    rejected = next(row for row in sample()["candidates"] if row["rejected_because"])
    button = tab.locator("#evidence button", has_text=rejected["id"]).first
    button.focus()
    said = tab.locator("#evidence dl").inner_text()
    assert rejected["rejected_because"] in said
    assert button.get_attribute("aria-pressed") == "true"
    tab.locator("#evidence button").first.hover()
    assert "nothing: it is named" in tab.locator("#evidence dl").inner_text()
    maps = tab.locator("#fields canvas")
    slider = tab.locator("#steer input")
    slider.press("End")
    ends = [maps.nth(k).evaluate("(item) => item.toDataURL()") for k in (0, 1)]
    assert ends[0] != ends[1]
    slider.press("Home")
    starts = [maps.nth(k).evaluate("(item) => item.toDataURL()") for k in (0, 1)]
    assert starts[0] == starts[1] != ends[1]
    tab.locator("#steer button").click()
    assert tab.locator("#steer button").inner_text() == "Pause"
    slider.press("Home")
    tab.locator("#steer button").click()
    slider.press("Home")
    assert "without the effect, 0 mm" in tab.locator("#fields figcaption").first.inner_text()
    assert complaints(tab) == []
    tab.set_viewport_size({"width": 390, "height": 844})
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    assert tab.noise == []


def test_the_slider_reads_the_curves_of_a_panel(read_page: Callable[[str], Any]) -> None:
    page = read_page(render_diagnosis_html(sample(), panels=[panel()]))
    tracks = [json.loads(attrs["data-track"] or "") for _, attrs in page.tags if "data-track" in attrs]
    assert len(tracks) == 1
    lines = {line["label"]: line for line in tracks[0]["lines"]}
    assert lines["simulated"]["y"] == pytest.approx([x**2 for x in lines["simulated"]["x"]], rel=1e-4)
    assert set(lines) == {"measured", "simulated"}
    left, top, wide, high = tracks[0]["frame"]
    assert (left, left + wide, top, top + high) == pytest.approx((0.205, 0.975, 0.05, 0.9), abs=0.01)


def test_the_page_says_what_the_data_say(read_page: Callable[[str], Any]) -> None:
    data = sample()
    text = read_page(render_diagnosis_html(data, panels=[panel()])).text
    assert data["sentence"] in text
    assert data["where_sentence"] in text
    for row in data["candidates"]:
        assert row["id"] in text
        assert row["rejected_because"] in text
    effect = data["effects"][0]
    for name, item in effect["parameters"].items():
        assert name in text
        assert f"{item['value']:.4g}" in text
    assert effect["mechanism"] in text
    for row in data["rows"]:
        assert f"{row['percent']:.1f} ({row['chi']:.1f})" in text
    for row in data["audit"]:
        assert row["remark"] in text
    assert data["command"] in text
    assert data["case"]["sha256"] in text
    assert data["wires"]["after"] in text


@pytest.mark.parametrize(
    ("verdict", "tone", "words"),
    [
        ("named", "good", "What is missing"),
        ("ambiguous", "withheld", "The best of several"),
        ("unexplained", "bad", "The closest effect, not sufficient"),
        ("no_gap", "good", "Validity audit"),
    ],
)
def test_every_verdict_has_its_page_and_its_text(
    verdict: str, tone: str, words: str, read_page: Callable[[str], Any]
) -> None:
    data = sample(verdict)
    page = read_page(render_diagnosis_html(data, panels=[panel()]))
    assert page.depth == []
    assert ("section", {"class": f"verdict {tone}"}) in page.tags
    assert words in page.text
    assert ("Why not the others" in page.text) == (verdict != "no_gap")
    text = diagnosis_text(data)
    assert f"Verdict: {verdict.replace('_', ' ')}" in text
    assert max(map(len, text.splitlines())) <= 80


def test_text_on_the_terminal_says_the_same() -> None:
    data = sample()
    text = " ".join(diagnosis_text(data).split())
    for row in data["rows"]:
        assert f"{row['percent']:.1f} ({row['chi']:.1f})" in text
    assert data["effects"][0]["id"] in text
    assert data["candidates"][0]["id"] in text
    assert "Wires at" in text


def test_what_was_kept_out_of_the_choice_stands_in_text_and_page(read_page: Callable[[str], Any]) -> None:
    sentence = "only clamp_slip could be named (--among); yarn_tail could not be named, whatever it would explain"
    data = sample() | {"restrictions": [sentence]}
    assert f"restricted: {sentence}" in " ".join(diagnosis_text(data).split())
    assert f"Restricted: {sentence}." in read_page(render_diagnosis_html(data, panels=[panel()])).text


def test_four_channels_fit_on_the_terminal() -> None:
    data = sample()
    more = [{**row, "channel": {"punch_force": "strain_field", "free_edge": "clamp_line"}[row["channel"]]}
            for row in data["rows"]]  # fmt: skip
    data["rows"] = [*data["rows"], *more]
    text = diagnosis_text(data)
    for row in data["rows"]:
        assert text.count(f"{row['percent']:.1f} ({row['chi']:.1f})") >= 2
    assert "strain field" in text
    assert max(map(len, text.splitlines())) <= 80


def test_all_candidates_are_listed_when_asked_for() -> None:
    data = sample()
    last = data["candidates"][-1]["id"]
    assert last in diagnosis_text(data, every=True)
    assert last not in diagnosis_text(data)
    assert "more in diagnosis.json" in diagnosis_text(data)


def test_text_of_a_user_cannot_break_the_page(read_page: Callable[[str], Any]) -> None:
    data = sample()
    data["measured"]["title"] = "<script>alert(1)</script> & more"
    text = render_diagnosis_html(data, panels=[])
    assert "<script>" not in text
    assert "<script>alert(1)</script> & more" in read_page(text).text


def test_the_same_data_give_the_same_page() -> None:
    first, second = (render_diagnosis_html(sample(), panels=[panel()]) for _ in range(2))
    assert first == second


def test_text_and_page_tell_one_probability_and_claim_no_certainty() -> None:
    data = sample()
    rows = [*data["effects"], data["candidates"][0], data["stages"]["finalists"][0]]
    assert [row["probability"] for row in rows] == pytest.approx([1.0] * 3, abs=1e-6)
    page, text = render_diagnosis_html(data, panels=[]), diagnosis_text(data)
    assert '<div class="value">&gt;0.999 <small></small></div><div class="name">Probability of clamp_slip</div>' in page
    assert re.search(r"clamp_slip\s.*>0\.999", text)
    assert "1.000" not in text
    assert "clamp_slip, the best of several and no name" in render_diagnosis_html(sample("ambiguous"), panels=[])
