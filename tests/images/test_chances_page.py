"""The pages of ensembles: what a map says of a loop is what stands in the data, on every mirror image and step."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.pages import complaints

from etextile.lattice.piece import divide, weave_piece
from etextile.lattice.weave import Weave
from viz.ensemble_html import EnsembleView, map_data, render_comparison_html, render_ensemble_html, solid_data
from viz.ensemble_plots import specimen_scene
from viz.mirror import whole
from viz.plots import Curve
from viz.scene import Scene
from wires.layout import WireLayout, lay_out


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, warp_density=11.0, weft_density=8.9)
LATTICE = weave_piece(WEAVE, divide(WEAVE, (100.0, 100.0), 39.0, "quarter"))
AT = np.array([0.0, 10.0, 20.0, 30.0])
HOSTILE = "</script><b onclick=alert(1)>$\\frac{1$ \u202eevil"


def rising(end: float) -> dict[str, list[float]]:
    """Probability that rises in a straight line to `end`, with an interval of 0.1 on each side."""
    value = end * AT / AT[-1]
    return {
        "value": value.tolist(),
        "low": np.clip(value - 0.1, 0, 1).tolist(),
        "high": np.clip(value + 0.1, 0, 1).tolist(),
    }


def ends(curve: dict[str, list[float]], name: str, prefix: str = "") -> dict[str, float]:
    return {name: curve["value"][-1], f"{prefix}low": curve["low"][-1], f"{prefix}high": curve["high"][-1]}


def last(curve: dict[str, list[float]]) -> dict[str, float]:
    return {name: values[-1] for name, values in curve.items()}


def chances(name: str = "", *, share: float = 1.0, title: str = HOSTILE) -> EnsembleView:
    """An ensemble whose loop number k fails with `share` (k + 1) / (L + 1); its wires as their last loop."""
    layout = lay_out(
        length_mm=100.0, width_mm=100.0, portion="quarter", wire_spacing_mm=20.0, loop_spacing_mm=20.0,
        loop_length_mm=4.0, loop_slack=0.02,
    )  # fmt: skip
    loops = [rising(share * (k + 1) / (layout.n_loops + 1)) for k in range(layout.n_loops)]
    return EnsembleView(_data(layout, loops, title=title), specimen_scene(
        LATTICE, layout, LATTICE.edges["x_max"], portion="quarter"), name)  # fmt: skip


def moving(own: EnsembleView) -> EnsembleView:
    """The same with the fabric of a run of steps at 5, 20 and 30 mm, lifted as far as that."""
    flat = whole(own.specimen)
    scenes = [_lifted(flat, height) for height in (5.0, 20.0, 30.0)]
    return replace(own, fields={"warp_strain": scenes}, way=(5.0, 20.0, 30.0))


def _lifted(scene: Scene, height: float) -> Scene:
    up = np.array([0.0, 0.0, height])
    loops = replace(scene.loops, deformed=scene.loops.deformed + up)
    return replace(scene, displacement_mm=height, points=scene.points + up, loops=loops)


def _data(layout: WireLayout, loops: list[dict[str, list[float]]], *, title: str) -> dict[str, Any]:
    events = dict.fromkeys(("any_failure", "any_open", "share_failed", "share_open"), rising(0.8))
    none = {"value": None, "low": None, "high": None}
    wires, curves = [], []
    for wire in range(layout.n_wires):
        own = np.flatnonzero(layout.loop_wire == wire).tolist()
        curves.append(loops[own[-1]])
        rows = [
            {"loop": layout.loop_index[k], "warp_mm": layout.loop_warp_mm[k], "copies": int(layout.loop_copies[k]),
             **ends(loops[k], "failure_probability"), **ends(rising(0.0), "open_probability", "open_"),
             "max_strain_mean": 0.1, "max_strain_std": None}
            for k in own
        ]  # fmt: skip
        wires.append({"wire": wire, "name": f"w{wire}", "weft_mm": layout.weft_mm[wire], "loops": rows,
                      "copies": int(layout.wire_copies[wire]),
                      **ends(curves[-1], "failure_probability"), **ends(rising(0.0), "open_probability", "open_"),
                      "half_failed_mm": none})  # fmt: skip
    row = {"output": "share_failed", "input": "strength", "label": "strength", "matters": True}
    data = {
        "case": {"title": title, "name": title, "sha256": "ab"},
        "unit": "mm",
        "failure": {"criterion": "span_strain", "parameters": {"onset": 0.07}},
        "samples": 16,
        "failed_runs": 1,
        "seed": 0,
        "method": "sobol",
        "specimen": {name: last(curve) for name, curve in events.items()} | {"wires": 8, "half_failed_mm": none},
        "wires": wires,
        "fragility": {"displacement_mm": AT, "travel_mm": AT, **events, "wires": curves, "loops": loops},
        "inputs": [{"name": "strength", "label": "strength", "distribution": "normal", "origin": "estimated: why"}],
        "ranking": [{**row, "rank_correlation": -0.7, "low": -0.9, "high": -0.4}],
        "failed": [{"sample": 3, "reason": title}],
        "verdict": {"withheld": False, "survive": False, "sentence": title},
        "trust": {"samples_over_limits": 0, "limits": {}},
        "notes": [title],
        "versions": {"etextile": "0"},
    }
    plain: dict[str, Any] = json.loads(json.dumps(data, default=lambda item: item.tolist()))
    return plain


def page() -> str:
    return render_ensemble_html(chances(), curves=[Curve(AT, AT / 40.0, "some")], x_label="displacement [mm]")


def comparison() -> str:
    designs = moving(chances("A")), moving(chances("B", share=0.5))
    data = {
        "designs": {
            item.name: {"title": HOSTILE, "case": "", "sha256": "ab", "specimen": item.data["specimen"]}
            for item in designs
        },
        "samples": 16, "seed": 0, "method": "sobol", "better": "B",
        "verdict": {"withheld": False, "sentence": HOSTILE},
        "differs": [{"key": "wires.loops.slack", "A": 0.02, "B": None}], "notes": [],
        "difference": {name: {"value": -0.2, "low": -0.3, "high": -0.1} for name in designs[0].data["specimen"]},
        "wires": [{"A": 0, "B": 0, "names": ["w0", "w0"], "weft_mm": [0.0, 0.0],
                   "failure_probability": [0.6, 0.3], "difference": -0.3,
                   "low": -0.4, "high": -0.2}],
    }  # fmt: skip
    curves = [Curve(AT, -AT / 100.0, "wires")]
    return render_comparison_html(data, designs, curves=curves, fragility=curves, x_label="mm")


def test_all_four_quarters_have_the_numbers_of_the_loops_that_were_modelled() -> None:
    own = chances()
    made = map_data(own)
    layout_loops = [(wire["weft_mm"], loop) for wire in own.data["wires"] for loop in wire["loops"]]
    assert len(made["loops"]) == len(layout_loops)
    for spot in made["drawn"]:
        weft, loop = layout_loops[spot["of"]]
        assert np.abs(spot["at"]) == pytest.approx([loop["warp_mm"], weft])
        assert made["loops"][spot["of"]]["value"][-1] == pytest.approx(loop["failure_probability"])
    copies = sum(wire["copies"] * loop["copies"] for wire in own.data["wires"] for loop in wire["loops"])
    assert len(made["drawn"]) == copies > len(layout_loops)


def test_the_fabric_of_a_page_stands_where_the_curves_stand() -> None:
    own = moving(chances())
    made, drawn = solid_data(own), map_data(own)["drawn"]
    assert made["places"] == pytest.approx([0.0, 1.0 / 3.0, 1.0, 2.0], abs=1e-3)
    shape = made["shape"]
    kept = np.frombuffer(base64.b64decode(shape["loops"]), dtype="<u2").reshape(3, -1, 3)
    loops = np.array(shape["low"]) + shape["scale"] * kept
    for places, height in zip(loops, (5.0, 20.0, 30.0), strict=True):
        assert places[:, :2] == pytest.approx(np.array([spot["at"] for spot in drawn]), abs=0.01)
        assert places[:, 2] == pytest.approx(height, abs=0.01)


@pytest.mark.parametrize("make", [page, comparison])
def test_a_page_stands_alone_and_titles_stay_text(make: Callable[[], str], read_page: Callable[[str], Any]) -> None:
    text = make()
    seen = read_page(text)
    assert seen.depth == []
    assert HOSTILE in seen.text
    assert "onclick" not in [name for _, attrs in seen.tags for name in attrs]
    assert all((attrs["src"] or "").startswith("data:") for tag, attrs in seen.tags if tag == "img")
    assert not re.search(r"(?:src|href)=\"https?:|url\(|@import", text)
    data = re.search(r'id="live-data">(.*?)</script>', text, re.DOTALL)
    assert data is not None
    assert json.loads(data.group(1))["unit"] == "mm"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_one_slider_moves_both_designs_and_a_loop_says_its_numbers(
    tmp_path: Path, open_page: Callable[..., Any]
) -> None:
    path = tmp_path / "compare.html"
    path.write_text(comparison(), encoding="utf-8")
    tab = open_page(path)
    tab.locator("[data-live=slider]").evaluate("(s) => { s.value = 2; s.dispatchEvent(new Event('input')); }")
    assert "At 20 mm, A: some wire" in tab.locator("[data-live=moment]").inner_text()
    assert all(text.startswith("At 20 mm: wires -0.2") for text in tab.locator(".said").all_inner_texts())
    tab.locator("[data-live=pick]").select_option("1")
    first, second = tab.locator("[data-live=facts]").all_inner_texts()
    loops = len(map_data(chances())["loops"])
    for text, share in ((first, 1.0), (second, 0.5)):
        assert f"{share * 2 / (loops + 1) * 2 / 3:.3f} (" in text, text
    tab.locator("[data-solid='1'] [data-view=top]").click()
    tab.locator("[data-solid='0'] canvas").press("ArrowLeft")
    cameras = tab.evaluate("() => window.etextile.maps.map((item) => item.solid.camera.position.toArray())")
    assert cameras[0] == pytest.approx(cameras[1])
    play = tab.locator("[data-live=play]")
    play.click()
    assert play.inner_text() == "Pause"
    play.click()
    canvas = tab.locator("[data-design='1'] canvas")
    canvas.scroll_into_view_if_needed()
    box, (x, y) = canvas.bounding_box(), tab.evaluate("() => window.etextile.maps[1].flat.at(0)")
    place = box["x"] + x, box["y"] + y
    tab.mouse.move(*place)
    tip = tab.locator("[data-design='1'] .tip")
    assert tip.is_visible()
    assert "w0, 0" in tip.inner_text()
    assert complaints(tab) == []
    tab.set_viewport_size({"width": 390, "height": 844})
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    assert tab.noise == []


def test_the_page_of_a_whole_specimen_tells_of_no_mirror_images() -> None:
    plain = chances()
    for wire in plain.data["wires"]:
        wire["copies"] = 1
        for loop in wire["loops"]:
            loop["copies"] = 1
    drawn = [
        render_ensemble_html(own, curves=[Curve(AT, AT / 40.0, "some")], x_label="mm") for own in (plain, chances())
    ]
    assert ["Mirror images" in text for text in drawn] == [False, True]
