"""How wires lie is said with the numbers of the whole specimen, and every criterion says what it ignores."""

from __future__ import annotations

import math

import pytest

from etextile.text.run import made_words
from loadcases.build_wires import wire_layout
from loadcases.fabric import load_fabric
from loadcases.reader import load_case
from wires.construction import laid, laid_words
from wires.failure import CRITERIA


def test_a_quarter_counts_the_wires_and_loops_of_the_whole_specimen() -> None:
    """Wires 65 yarns apart and loops 20 mm apart, one of each on the centre lines of 100 x 100 mm."""
    case = load_case("punch").case
    fabric = load_fabric(case.fabric.set)
    layout = wire_layout(case, fabric)
    assert layout is not None
    found = laid(layout)
    pitch = 65.0 / fabric.warp_density
    wires, loops = 2 * math.floor(50.0 / pitch) + 1, 2 * math.floor(50.0 / 20.0) + 1
    assert (found["wires"], found["loops"]) == (wires, wires * loops)
    assert found["pitch_mm"] == pytest.approx([pitch, pitch])
    assert found["loop_spacing_mm"] == pytest.approx([20.0, 20.0])
    words = laid_words({**found, "crimp": 0.02})
    assert words == f"17 wires every {pitch:.3g} mm, 85 loops of 4 mm every 20 mm with 2 % slack, crimp 2 %"


def test_drawn_wires_have_ranges_and_no_pitch() -> None:
    case = load_case("knee_pad").case
    layout = wire_layout(case, load_fabric(case.fabric.set))
    assert layout is not None
    found = laid(layout)
    assert found["pitch_mm"] is None
    assert found["loop_spacing_mm"][0] < found["loop_spacing_mm"][1]
    assert " to " in laid_words({**found, "crimp": 0.02})


@pytest.mark.parametrize("name", list(CRITERIA))
def test_every_criterion_says_what_it_ignores(name: str) -> None:
    ignores = getattr(CRITERIA[name], "ignores", "")
    assert len(ignores) > 40
    model = {"filaments": 7, "filament_diameter_mm": 0.03, "material": "copper_soft"}
    report = {"wire_model": model, "failure": {"criterion": name, "ignores": ignores}}
    assert ignores in made_words(report)
