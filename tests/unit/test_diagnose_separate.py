"""The next measurement is the one in which two runs differ most, counted in deviations of the instrument."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.diagnose.data.observe import PEAKS, Record
from etextile.diagnose.decide.separate import NOISE, separations
from etextile.vocabulary import CLAMP, EDGE, STRAIN


def flat() -> Record:
    """A specimen that stays flat while the punch travels 40 mm."""
    travel = np.linspace(0.0, 40.0, 9)
    x = np.linspace(0.0, 50.0, 11)
    at_rest = np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((11, 11))], axis=-1)
    return Record(x, x, (True, True), travel, travel**2, np.repeat(at_rest[None], 9, axis=0), np.zeros((9, len(PEAKS))))


def slipped(size: float) -> Record:
    """The same whose last line of nodes is pulled out of the clamp by up to `size` mm, all lines in proportion."""
    run = flat()
    positions = run.positions.copy()
    positions[..., 0] *= 1.0 - size / 50.0 * (run.displacement / 40.0)[:, None, None]
    return replace(run, positions=positions)


def test_slip_is_best_seen_at_the_clamp_at_the_end() -> None:
    found = {item.channel: item for item in separations(flat(), slipped(2.0))}
    assert found[CLAMP].sigma == pytest.approx(2.0 / NOISE[CLAMP], rel=1e-6)
    assert found[CLAMP].first == pytest.approx(0.0)
    assert found[CLAMP].second == pytest.approx(2.0)
    assert found[CLAMP].displacement == 40.0
    assert "the slip would be 0.00 mm against 2.00 mm (20 standard deviations of 0.1 mm)" in found[CLAMP].words
    assert found[STRAIN].sigma == pytest.approx(0.04 / NOISE[STRAIN], rel=1e-3)
    assert found[EDGE].quantity == "warp"


def test_the_clearest_channel_comes_first_and_measured_ones_are_left_out() -> None:
    assert [item.channel for item in separations(flat(), slipped(2.0))] == [CLAMP, STRAIN, EDGE]
    assert [item.channel for item in separations(flat(), slipped(2.0), measured=(CLAMP,))] == [STRAIN, EDGE]


def test_what_hardly_differs_is_not_called_clear() -> None:
    assert not any(item.clear for item in separations(flat(), slipped(0.1)))
