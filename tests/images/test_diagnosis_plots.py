"""Pictures of a diagnosis: what is measured, simulated, left over, held out and marked is there in its colour."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb

from viz.diagnosis_plots import (
    AFTER,
    BEFORE,
    HELD_OUT,
    Panel,
    Readings,
    Simulated,
    panel_figure,
    save_evidence,
    save_panels,
)
from viz.style import STATES, drawing


TRAVEL = np.linspace(0.5, 40.0, 80)


def panel(*, after: bool = True, gap: float = 300.0, unit: str = "N") -> Panel:
    """A force that falls short of the simulation by up to `gap` from 20 mm on, and an effect that closes that."""
    simulated = TRAVEL**2
    missing = gap * np.maximum(TRAVEL - 20.0, 0.0) / 20.0
    nothing = np.zeros(80)
    return Panel(
        channel="punch_force",
        title="punch force",
        unit=unit,
        readings=(Readings(TRAVEL, simulated - missing, -missing, nothing if after else None),),
        before=Simulated(TRAVEL, simulated, 0.01 * simulated),
        noise=np.full(80, 10.0),
        after=Simulated(TRAVEL, simulated - missing, 0.01 * simulated) if after else None,
        held_out=Simulated(TRAVEL[60:], (simulated - missing)[60:], nothing[60:]) if after else None,
        onset=(20.0, 18.0, 22.0),
        split=30.0 if after else None,
    )


def pixels(shown: Panel) -> np.ndarray:
    """Return the colours (rows, columns, 3) of a panel, 0 to 1."""
    with drawing():
        figure = panel_figure(shown)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3] / 255.0


def share(picture: np.ndarray, colour: str, *, near: float = 0.06) -> float:
    """Return the share of pixels with about this colour."""
    return float(np.mean(np.abs(picture - to_rgb(colour)).max(axis=-1) < near))


def test_before_and_after_are_both_drawn() -> None:
    both, one = pixels(panel()), pixels(panel(after=False))
    assert share(both, BEFORE) > 2e-3
    assert share(both, AFTER) > 2e-3
    assert share(one, BEFORE) > 2e-3
    assert share(one, AFTER) < 2e-4


def test_the_onset_is_marked_and_the_held_out_part_shaded() -> None:
    both, one = pixels(panel()), pixels(panel(after=False))
    assert share(both, STATES[1].colour, near=0.12) > 1e-3
    assert share(both, HELD_OUT, near=0.01) > 0.05
    assert share(one, HELD_OUT, near=0.01) < 1e-3


def test_what_is_left_after_lies_on_the_zero_line() -> None:
    """In the lower axes the dots before spread over the height, those after stay in a narrow band."""
    picture = pixels(panel())
    lower = picture[int(0.62 * len(picture)) :]
    rows = {
        name: np.flatnonzero((np.abs(lower - to_rgb(colour)).max(axis=-1) < 0.06).any(axis=1))
        for name, colour in (("before", BEFORE), ("after", AFTER))
    }
    assert np.ptp(rows["before"]) > 4 * np.ptp(rows["after"])


@pytest.mark.parametrize("count", [1, 4])
def test_panels_stand_side_by_side_in_one_file(count: int, tmp_path: Path) -> None:
    path = save_panels([panel()] * count, tmp_path / "gap.png", title="Punch test", after_label="with clamp_slip")
    from matplotlib.image import imread

    height, width = imread(path).shape[:2]
    across = 2 if count == 4 else min(count, 3)
    assert width == pytest.approx(495 * across, abs=2)
    assert height / (count / across) > 500


def test_the_same_panel_gives_the_same_file(tmp_path: Path) -> None:
    first, second = (save_panels([panel()], tmp_path / f"{name}.png").read_bytes() for name in "ab")
    assert first == second


def test_evidence_shows_the_named_effect_in_colour(tmp_path: Path) -> None:
    from matplotlib.image import imread

    rows = [
        {"id": "clamp_slip", "probability": 0.97, "held_out_percent": 2.0, "rejected_because": ""},
        {"id": "yarn_tail", "probability": 0.03, "held_out_percent": None, "rejected_because": "fits far worse"},
    ]
    named = imread(save_evidence(rows, tmp_path / "a.png", title="Evidence"))[..., :3]
    rows[0]["rejected_because"] = "probability 0.97 is not enough"
    nobody = imread(save_evidence(rows, tmp_path / "b.png", title="Evidence"))[..., :3]
    assert share(named, AFTER) > 0.02
    assert share(nobody, AFTER) < 1e-3
