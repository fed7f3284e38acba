"""The page that can be turned: its numbers are those of the report, it needs no network, and a browser can work it."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.pages import complaints, pale

import etextile as et
from viz.html import state_styles
from viz.style import contrast
from viz.surface import shear_angle


TITLE = "A <b>bold</b> </script> <img src=x onerror=alert(1)> $\\frac{1$ \u202eRTL $x$ title"
"""Nothing of it may be run by a browser or read as a formula by the pictures."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> et.Run:
    case = et.load(
        "punch",
        {
            "title": TITLE,
            "motion.total": "30 mm",
            "motion.steps": 6,
            "fabric.coarsening": 30,
        },
    )
    return et.run(case, tmp_path_factory.mktemp("live") / "run")


def text_of(run: et.Run) -> str:
    return (run.folder / "report.html").read_text(encoding="utf-8")


def data_of(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="live-data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    data: dict[str, Any] = json.loads(found.group(1))
    return data


def test_every_loop_of_the_report_is_on_the_page_with_its_numbers(run: et.Run) -> None:
    said = {(wire["wire"], spot["loop"]): spot for wire in run.report["wires"] for spot in wire["loops"]}
    loops = data_of(text_of(run))["loops"]
    assert {(loop["wire"], loop["loop"]) for loop in loops} == set(said)
    for loop in loops:
        spot = said[loop["wire"], loop["loop"]]
        assert (loop["state"], loop["max_strain"], loop["broken"]) == (
            spot["state"], spot["max_strain"], spot["failure_probability"],
        )  # fmt: skip
        assert loop["strain"][-1] == pytest.approx(spot["max_strain"], abs=1e-4)
        assert loop["fails_at"] == spot["first_failure_mm"]
    assert data_of(text_of(run))["at"] == pytest.approx(run.report["punch"]["displacement_mm"])


def test_places_on_the_page_are_those_of_the_results(run: et.Run) -> None:
    data = data_of(text_of(run))["shape"]
    last = np.frombuffer(base64.b64decode(data["points"]), dtype="<u2").reshape(data["steps"], -1, 3)[-1]
    places = np.array(data["low"]) + data["scale"] * last
    true = run.results.points(-1)[np.unique(run.results.grid.quads)]
    quarter = places[(places[:, 0] > -0.01) & (places[:, 1] > -0.01)]
    assert np.abs(np.sort(quarter[:, 2]) - np.sort(true[:, 2])).max() < data["scale"]


def test_the_page_needs_no_network_and_swallows_no_title(run: et.Run) -> None:
    text = text_of(run)
    assert not re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', text)
    assert len(text) < 8e6
    assert "<img src=x" not in text
    assert "</script> <img" not in text
    assert "&lt;img src=x onerror=alert(1)&gt; $\\frac{1$" in text


def test_the_page_says_what_breaks_first_where_when_how_sure_and_the_strain_one_step_before(run: et.Run) -> None:
    said = run.report["verdict"]["first_failure"]
    block = re.search(r'<dl class="first">(.*?)</dl>', text_of(run), re.DOTALL)
    assert block is not None
    facts = " ".join(re.sub(r"<[^>]+>", " ", block.group(1)).split())
    assert f"wire {said['name']}, loop {said['loop']}" in facts
    assert f"warp {said['warp_mm']:.1f} mm, weft {said['weft_mm']:.1f} mm" in facts
    assert f"{said['displacement_mm']:.1f} mm" in facts
    at = np.array(run.report["punch"]["displacement_mm"])
    step = int(np.searchsorted(at, said["displacement_mm"]))
    wires = run.results.wires
    assert wires is not None
    loop = np.flatnonzero((wires.layout.loop_wire == said["wire"]) & (wires.layout.loop_index == said["loop"]))[0]
    kind = run.report["wires"][said["wire"]]["loops"][0]["strain_kind"]
    strain = wires.span_strain if kind == "fabric" else wires.wire_strain
    assert f"{strain[step][loop]:.4f} at {at[step - 1]:.1f} mm, the last step before" in facts


def test_charts_know_where_the_slider_meets_them(run: et.Run) -> None:
    tracks = [json.loads(html.unescape(found)) for found in re.findall(r'data-track="([^"]*)"', text_of(run))]
    force = tracks[0]["lines"][0]
    assert force["x"] == pytest.approx(run.report["punch"]["displacement_mm"])
    assert force["y"] == pytest.approx(run.report["punch"]["force_N"], rel=1e-4)
    assert all(0.0 < share < 1.0 for track in tracks for share in track["frame"])


def test_a_sheared_cell_shows_the_change_of_its_angle() -> None:
    angle = np.radians(20.0)
    points = np.array([[0, 0, 0], [2, 0, 0], [2 + np.sin(angle), np.cos(angle), 0], [np.sin(angle), np.cos(angle), 0]])
    assert shear_angle(points, np.array([[0, 1, 2, 3]])) == pytest.approx([angle])


def test_letters_on_states_and_tables_can_be_read_by_all(run: et.Run) -> None:
    for look in state_styles():
        assert contrast(look["ink"], look["colour"]) > 4.5, look["name"]
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)
    tables = re.findall(r"<table[^>]*>", text_of(run))
    assert len(tables) > 3
    assert all(re.search(r'aria-label="[^"]+"', table) for table in tables)


@pytest.fixture
def page(run: et.Run, open_page: Callable[..., Any]) -> Any:
    return open_page(run.folder / "report.html")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_browser_turns_plays_asks_and_filters(run: et.Run, page: Any) -> None:
    live = page.locator("#live")
    slider = live.locator("[data-live=slider]")
    slider.evaluate("(item) => { item.value = 2; item.dispatchEvent(new Event('input')); }")
    assert "15 mm" in live.locator("[data-live=moment]").inner_text()
    slider.evaluate("(item) => { item.value = 5; item.dispatchEvent(new Event('input')); }")

    live.locator("canvas[tabindex]").scroll_into_view_if_needed()
    place = page.evaluate(
        "() => { const [x, y] = window.etextile.solid.at(0); const b = document.querySelector('#live canvas')"
        ".getBoundingClientRect(); return [x + b.left, y + b.top]; }"
    )
    page.mouse.click(*place)
    facts = live.locator("[data-live=facts]").inner_text()
    spot = run.report["wires"][0]["loops"][0]
    assert f"{spot['max_strain']:.3f}" in facts
    assert spot["state"] in facts
    assert live.locator("[data-live=chart] svg").count() == 1

    visible = "() => window.etextile.data.loops.filter((l) => l.states[5] === 3).length"
    assert page.evaluate(visible) > 0
    before = page.evaluate("() => document.querySelector('#live canvas').toDataURL()")
    live.locator("input[value='3']").uncheck()
    assert page.evaluate("() => document.querySelector('#live canvas').toDataURL()") != before
    live.locator("[data-live=top]").click()
    live.locator("canvas[tabindex]").press("ArrowLeft")
    assert page.noise == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_ten_loops_on_the_page_say_what_the_report_says_and_charts_follow(run: et.Run, page: Any) -> None:
    live = page.locator("#live")
    said = [(wire, spot) for wire in run.report["wires"] for spot in wire["loops"]][:10]
    assert len(said) == 10
    for wire, spot in said:
        number = page.evaluate(
            "([w, l]) => window.etextile.data.loops.findIndex((i) => i.wire === w && i.loop === l)",
            [wire["wire"], spot["loop"]],
        )
        live.locator("[data-live=pick]").select_option(str(number))
        facts = live.locator("[data-live=facts]").inner_text()
        assert f"{spot['max_strain']:.3f}" in facts
        assert spot["state"] in facts
        assert spot["first_failure_mm"] is None or f"{spot['first_failure_mm']:.1f} mm" in facts
    live.locator("[data-live=field]").select_option("probability")
    live.locator("[data-live=field]").select_option("shear")
    slider = live.locator("[data-live=slider]")
    slider.focus()
    slider.press("Home")
    assert page.locator(".said").first.inner_text().startswith("At 5 mm")
    slider.press("End")
    assert f"{run.report['punch']['force_N'][-1]:.3g}" in page.locator(".said").first.inner_text()
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.noise == []


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_without_script_the_still_pictures_and_tables_stay(run: et.Run, browser: Any) -> None:
    tab = browser.new_context(java_script_enabled=False).new_page()
    tab.goto((run.folder / "report.html").as_uri())
    assert not tab.locator("#live").is_visible()
    assert tab.locator("figure img").first.is_visible()
    assert tab.locator("table").count() > 2


NAMES = """async () => {
  const { placed } = await import("names");
  const anchors = Array.from({ length: 36 }, (_, k) => ({ x: 150 + 12 * (k % 12), y: 100 + 9 * Math.floor(k / 12),
    name: `LED${k}` }));
  const wide = document.createElement("canvas").getContext("2d");
  wide.font = "11px system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif";
  return placed(anchors, { width: 500, height: 300 }).flatMap((at, k) => {
    const half = wide.measureText(anchors[k].name).width / 2;
    return at ? [[at.x - half, at.x + half, at.y - 5, at.y + 5]] : [];
  });
}"""


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_everybody_reaches_hears_and_reads_the_page(page: Any) -> None:
    assert complaints(page) == []
    boxes = page.evaluate(NAMES)
    assert len(boxes) > 20
    for number, (left, right, top, bottom) in enumerate(boxes):
        others = [b for b in boxes[:number] if b[0] < right and left < b[1] and b[2] < bottom and top < b[3]]
        assert not others, "names of parts lie beside each other"
    page.evaluate("() => { document.querySelector('footer p').style.color = '#8a94a0'; }")
    assert pale(page), "words that are too pale are found"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_finger_asks_a_loop_in_both_pictures(run: et.Run, browser: Any) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    tab = context.new_page()
    tab.goto((run.folder / "report.html").as_uri())
    tab.wait_for_selector("[data-ready=true]", timeout=60_000)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    facts = tab.locator("[data-live=facts]")
    loops = tab.evaluate("() => window.etextile.data.loops.map((loop) => [loop.name, loop.loop])")
    for picture, canvas in (("solid", "canvas[tabindex]"), ("flat", "[data-live=flat]")):
        number = len(loops) - 1 if picture == "flat" else 0
        tab.locator(f"#live {canvas}").scroll_into_view_if_needed()
        place = tab.evaluate(
            "([picture, canvas, k]) => { const [x, y] = window.etextile[picture].at(k);"
            " const box = document.querySelector(`#live ${canvas}`).getBoundingClientRect();"
            " return [x + box.left, y + box.top]; }",
            [picture, canvas, number],
        )
        tab.touchscreen.tap(*place)
        name, loop = loops[number]
        assert facts.inner_text().split("\n")[1:4:2] == [name, str(loop)]
    tab.locator("[data-live=play]").tap()
    assert tab.locator("[data-live=play]").inner_text() == "Pause"
    context.close()


NO_WEBGL = (
    "const own = HTMLCanvasElement.prototype.getContext; HTMLCanvasElement.prototype.getContext = "
    "function (kind, ...more) { return kind.startsWith('webgl') ? null : own.call(this, kind, ...more); };"
)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_without_webgl_slider_undeformed_map_and_histories_stay(run: et.Run, browser: Any) -> None:
    tab = browser.new_page()
    tab.add_init_script(NO_WEBGL)
    tab.goto((run.folder / "report.html").as_uri())
    tab.wait_for_selector("[data-ready=true]", timeout=60_000)
    assert not tab.locator("#live canvas[tabindex]").is_visible()
    flat = tab.locator("[data-live=flat]")
    assert flat.is_visible()
    before = flat.evaluate("(item) => item.toDataURL()")
    tab.locator("[data-live=slider]").press("Home")
    assert flat.evaluate("(item) => item.toDataURL()") != before
    assert tab.locator("[data-live=chart] svg").count() == 1
    assert tab.locator("[data-live=field] option").all_inner_texts() == ["Wire strain", "Probability", "State"]
