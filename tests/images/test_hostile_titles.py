"""Titles and names of other files are drawn as they stand: no formula, no warning, nothing beyond the sheet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from viz.flat import flat_failure_map
from viz.legend import TITLE_POINTS, sheet
from viz.scene import Scene
from viz.style import drawing


HOSTILE = "</script><b>$\\frac{1$ {{ 7*7 }} [bold]x[/bold] \u65e5\u672c %s {0}"


@pytest.mark.parametrize("title", ["Elbow", HOSTILE, HOSTILE * 9])
def test_a_title_stays_text_and_on_the_sheet(title: str) -> None:
    with drawing():
        figure = sheet((1500, 1200), title)
        (text,) = figure.texts
        box = text.get_window_extent()
    assert 0.0 <= box.x0 < box.x1 <= 1500.0
    assert not text.get_parse_math()
    assert TITLE_POINTS[0] <= text.get_fontsize() <= TITLE_POINTS[1]
    assert box.y1 - box.y0 < 75.0, "two lines at most: the plots begin there"
    shown = text.get_text().replace("\n", " ").rstrip("…")
    assert title.startswith(shown)
    assert (shown == title) == (len(title) < 200)


def test_hostile_names_of_wires_are_drawn_without_a_warning(scene: Callable[..., Scene], tmp_path: Path) -> None:
    made = scene()
    named = replace(made, title=HOSTILE, wires=replace(made.wires, names=(HOSTILE, "$x_{$", "\u65e5")))
    with (
        Image.open(flat_failure_map(named, tmp_path / "a.png")) as hostile,
        Image.open(flat_failure_map(replace(named, wires=made.wires), tmp_path / "b.png")) as plain,
    ):
        assert not np.array_equal(np.asarray(hostile), np.asarray(plain))
