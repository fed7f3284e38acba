"""The next measurement is the cheapest in which two runs differ clearly, counted in deviations of the instrument."""

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


def test_the_cheapest_that_decides_comes_first_and_measured_ones_are_left_out() -> None:
    """Edge and field both decide (9.5 and 13 deviations); a photograph takes less than cameras with a pattern."""
    found = separations(flat(), slipped(2.0))
    assert [item.channel for item in found] == [CLAMP, EDGE, STRAIN]
    assert found[1].sigma < found[2].sigma
    assert [item.channel for item in separations(flat(), slipped(2.0), measured=(CLAMP,))] == [EDGE, STRAIN]


def test_what_decides_comes_before_what_is_cheap_and_does_not() -> None:
    """A slip of 0.55 mm: 2.6 deviations at the edge, 3.7 in the field."""
    found = separations(flat(), slipped(0.55), measured=(CLAMP,))
    assert [(item.channel, item.clear) for item in found] == [(STRAIN, True), (EDGE, False)]


def test_what_hardly_differs_is_not_called_clear() -> None:
    assert not any(item.clear for item in separations(flat(), slipped(0.1)))
