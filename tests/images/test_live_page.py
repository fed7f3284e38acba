"""The page that can be turned: its numbers are those of the report, it needs no network, and a browser can work it."""

from __future__ import annotations

import base64
import json
import re
import shutil
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import etextile as et


BROWSER = next(
    (place for name in ("chromium", "chromium-browser", "google-chrome") if (place := shutil.which(name))), None
)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine: apt install chromium")
SCRIPTS = ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-gl=angle", "--use-angle=swiftshader"]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> et.Run:
    case = et.load(
        "punch",
        {
            "title": "A <b>bold</b> </script> $x$ title",
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
    data = data_of(text_of(run))
    last = np.frombuffer(base64.b64decode(data["points"]), dtype="<u2").reshape(len(data["at"]), -1, 3)[-1]
    places = np.array(data["low"]) + data["scale"] * last
    true = run.results.points(-1)[np.unique(run.results.grid.quads)]
    quarter = places[(places[:, 0] > -0.01) & (places[:, 1] > -0.01)]
    assert np.abs(np.sort(quarter[:, 2]) - np.sort(true[:, 2])).max() < data["scale"]


def test_the_page_needs_no_network_and_swallows_no_title(run: et.Run) -> None:
    text = text_of(run)
    assert not re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', text)
    assert len(text) < 8e6
    assert "</script> $x$" not in text
    assert "A &lt;b&gt;bold&lt;/b&gt; &lt;/script&gt; $x$ title" in text


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    sync = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra test)")
    with sync.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=BROWSER, args=SCRIPTS)
        yield started
        started.close()


@pytest.fixture
def page(run: et.Run, browser: Any) -> Any:
    tab = browser.new_page(viewport={"width": 1400, "height": 900})
    tab.noise = []
    tab.on("console", lambda message: tab.noise.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: tab.noise.append(str(error)))
    tab.on("request", lambda asked: tab.noise.append(asked.url) if asked.url.startswith("http") else None)
    tab.goto((run.folder / "report.html").as_uri())
    tab.wait_for_selector("#live[data-ready=true]", timeout=60_000)
    return tab


@needs_browser
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_browser_turns_plays_asks_and_filters(run: et.Run, page: Any) -> None:
    live = page.locator("#live")
    slider = live.locator("[data-live=slider]")
    slider.evaluate("(item) => { item.value = 2; item.dispatchEvent(new Event('input')); }")
    assert "15 mm" in live.locator("[data-live=moment]").inner_text()
    slider.evaluate("(item) => { item.value = 5; item.dispatchEvent(new Event('input')); }")

    live.scroll_into_view_if_needed()
    place = page.evaluate(
        "() => { const a = window.etextile.onScreen(0); const b = document.querySelector('#live canvas')"
        ".getBoundingClientRect(); return [a.x + b.left, a.y + b.top]; }"
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
    live.locator("canvas").press("ArrowLeft")
    assert page.noise == []


@needs_browser
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_without_script_the_still_pictures_and_tables_stay(run: et.Run, browser: Any) -> None:
    tab = browser.new_context(java_script_enabled=False).new_page()
    tab.goto((run.folder / "report.html").as_uri())
    assert not tab.locator("#live").is_visible()
    assert tab.locator("figure img").first.is_visible()
    assert tab.locator("table").count() > 2
