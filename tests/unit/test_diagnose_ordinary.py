"""Ordinary readings of a channel show a change of the specimen by as much as it moves there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.diagnose.data.observe import PEAKS, Record, observe
from etextile.studies.diagnose.ordinary import imagined
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


@pytest.mark.parametrize(("channel", "most"), [(CLAMP, 2.0), (EDGE, 0.95 * 2.0), (STRAIN, 0.04)])
def test_slip_is_read_where_an_ordinary_measurement_looks(channel: str, most: float) -> None:
    """At full travel: the line itself, an edge mark at 95 % of the half specimen, a strain of slip over length."""
    points = imagined(flat(), 40.0)[channel]
    apart = np.abs(observe(slipped(2.0), points) - observe(flat(), points))
    assert np.nanmax(apart) == pytest.approx(most, rel=1e-3)
    assert points.displacement[int(np.nanargmax(apart))] == 40.0
