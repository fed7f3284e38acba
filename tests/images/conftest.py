"""A scene whose every colour is known beforehand: a paraboloid of cloth over a sphere, with wires and loops."""

import shutil
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from viz import gl
from viz.scene import Colouring, Scene, SceneBody, SceneLoops, SceneWires


BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SCRIPTS = ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-gl=angle", "--use-angle=swiftshader"]
HALF_MM, HEIGHT_MM = 50.0, 25.0


def sheet_points(x: np.ndarray) -> np.ndarray:
    """Return flat points lifted onto the paraboloid."""
    height = HEIGHT_MM * (1.0 - (x[:, 0] / HALF_MM) ** 2) * (1.0 - 0.5 * (x[:, 1] / HALF_MM) ** 2)
    return np.column_stack([x[:, :2], height])


def make_scene(*, quarter: bool = False, states: tuple[int, ...] = (0, 1, 2, 3)) -> Scene:
    """Return a scene with wires along y = 0, 20, 40 (and mirrored), each with loops at x = 0, 20 (and mirrored).

    The loops of wire number k are all in state `states[k]`; warp strain grows from 0 at the clamps to 40 %.
    """
    start, cells = (0.0, 10) if quarter else (-HALF_MM, 20)
    line = np.linspace(start, HALF_MM, cells + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(line, line, indexing="ij"))
    lattice = np.column_stack([x, y, 0.0 * x])
    number = np.arange(len(x)).reshape(cells + 1, cells + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    wefts = np.array([0.0, 20.0, 40.0]) if quarter else np.array([0.0, 20.0, 40.0, -20.0, -40.0])
    names = np.array([0, 1, 2]) if quarter else np.array([0, 1, 2, 1, 2])
    rows = np.concatenate([np.column_stack([line, np.full(len(line), weft), 0.0 * line]) for weft in wefts])
    order = len(lattice) + np.arange(len(rows)).reshape(len(wefts), -1)
    segments = np.stack([order[:, :-1], order[:, 1:]], axis=-1).reshape(-1, 2)
    flat = np.concatenate([lattice, rows])
    loop_x = np.array([0.0, 20.0]) if quarter else np.array([0.0, 20.0, -20.0])
    places = np.array([(along, weft) for weft in wefts for along in loop_x])
    loop_wire = np.repeat(names, len(loop_x))
    strain = 40.0 * (1.0 - np.abs(flat[quads, 0].mean(axis=1)) / HALF_MM)
    angle = np.linspace(0.0, 2.0 * np.pi, 33)[:-1]
    rim = np.column_stack([10.0 * np.cos(angle), 10.0 * np.sin(angle), np.full(32, HEIGHT_MM - 6.0)])
    top = np.array([[0.0, 0.0, HEIGHT_MM - 1.0]])
    faces = np.column_stack([np.arange(32), np.roll(np.arange(32), -1), np.full(32, 32)])
    state = np.array(states)[loop_wire]
    return Scene(
        title="paraboloid",
        displacement_mm=HEIGHT_MM,
        force_N=100.0,
        portion="quarter" if quarter else "whole",
        flat=flat,
        points=sheet_points(flat),
        quads=quads,
        colouring=Colouring("warp strain", "%", strain, float(strain.max())),
        touched=np.hypot(flat[:, 0], flat[:, 1]) < 12.0,
        clamped=np.isclose(np.abs(flat[:, 0]), HALF_MM) & (np.arange(len(flat)) < len(lattice)),
        wires=SceneWires(segments, np.repeat(names, len(line) - 1), np.full(len(segments), 0.05)),
        loops=SceneLoops(
            wire=loop_wire,
            index=np.tile(np.arange(len(loop_x)), len(wefts)),
            state=state,
            span_strain=0.05 * state,
            wire_strain=0.04 * state,
            flat=places,
            half_span=np.tile([2.0, 0.0], (len(places), 1)),
            deformed=sheet_points(places),
        ),
        body=SceneBody(np.concatenate([rim, top]), faces),
        symmetry=(quarter, quarter),
    )


@pytest.fixture
def scene() -> Callable[..., Scene]:
    """Return the maker of scenes."""
    return make_scene


@pytest.fixture
def opengl() -> None:
    """Skip where VTK cannot draw."""
    if not gl.available():
        pytest.skip(f"no OpenGL: {gl.REMEDY}")


class Page(HTMLParser):
    """Collects the tags with attributes, the text, and whether every tag is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.depth: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "img", "br", "link", "input"):
            self.depth.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.depth.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())

    def with_class(self, name: str) -> int:
        return sum(name in (attrs.get("class") or "").split() for _, attrs in self.tags)


@pytest.fixture
def read_page() -> Callable[[str], Page]:
    """Return what reads the text of a page."""
    return Page


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A headless Chromium; skips with the reason where there is none."""
    found = next((place for name in BROWSERS if (place := shutil.which(name))), None)
    if found is None:
        pytest.skip("no Chromium on this machine: apt install chromium")
    sync = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra test)")
    with sync.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=found, args=SCRIPTS)
        yield started
        started.close()


@pytest.fixture
def open_page(browser: Any) -> Callable[..., Any]:
    """Return what opens a page and waits for its moving part; `noise` holds errors and requests that leave the file."""

    def opened(path: Path, *, width: int = 1400) -> Any:
        tab = browser.new_page(viewport={"width": width, "height": 900})
        tab.noise = []
        tab.on("console", lambda message: tab.noise.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: tab.noise.append(str(error)))
        tab.on("request", lambda asked: tab.noise.append(asked.url) if asked.url.startswith("http") else None)
        tab.goto(path.as_uri())
        tab.wait_for_selector("[data-ready=true]", timeout=60_000)
        return tab

    return opened
