"""Usual ranges are opened once beyond the end that a leader leans on, and no farther than what can be."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.diagnose.decide.opening import beyond, widened_grid
from etextile.diagnose.predict.table import ParameterGrid, axes_of
from etextile.effects.base import Parameter
from etextile.effects.registry import EFFECTS, build_effect
from etextile.errors import BadInput


def test_a_punch_of_eleven_millimetres_is_within_the_opened_range_and_only_on_its_side() -> None:
    radius = EFFECTS["geometry"].card.parameter("radius")
    wider = beyond(radius, -2.0)
    assert wider is not None
    assert (wider.low, wider.high) == (-6.0, 2.0)
    assert build_effect("geometry", {"radius": -4.0}).values["radius"] == -4.0


@pytest.mark.parametrize(
    ("item", "end", "expected"),
    [
        (Parameter("share", "", 0.0, 1.0, "a share"), 1.0, None),
        (Parameter("limit", "N/mm", 0.5, 100.0, "a limit", scale="log", limits=(0.02, 1000.0)), 0.5, (0.05, 100.0)),
        (Parameter("limit", "N/mm", 0.5, 100.0, "a limit", scale="log", limits=(0.2, 1000.0)), 0.5, (0.2, 100.0)),
        (Parameter("mu", "", 0.0, 1.0, "friction", limits=(0.0, 2.0)), 1.0, (0.0, 2.0)),
        (Parameter("mu", "", 0.0, 1.0, "friction", limits=(0.0, 2.0)), 0.0, None),
        (Parameter("onset", "", 0.1, 0.4, "a shape", neutral=None, default=0.2, limits=(0.0, 1.0)), 0.1, (0.0, 0.4)),
    ],
)
def test_a_physical_limit_is_a_wall(item: Parameter, end: float, expected: tuple[float, float] | None) -> None:
    wider = beyond(item, end)
    assert (None if wider is None else (wider.low, wider.high)) == expected


def test_an_opened_grid_keeps_its_nodes_and_gets_new_ones_beyond_the_old_end() -> None:
    card = EFFECTS["geometry"].card
    grid = ParameterGrid(card, axes_of(card))
    wider = beyond(card.parameter("radius"), 2.0)
    assert wider is not None
    new = widened_grid(grid, [wider])
    assert set(grid.axes[0].nodes.tolist()) < set(new.axes[0].nodes.tolist())
    values = new.axes[0].to_value(new.axes[0].nodes)
    assert values.max() == pytest.approx(6.0)
    assert np.count_nonzero(values > 2.0 + 1e-9) == 3
    assert values[new.axes[0].neutral or 0] == pytest.approx(0.0)
    assert [item[1]["radius"] for item in new.nodes() if item[1]["radius"] > 5.9] == [pytest.approx(6.0)]


def test_what_cannot_be_is_still_refused() -> None:
    with pytest.raises(BadInput, match="-12 to 30 mm"):
        build_effect("geometry", {"radius": -13.0})
