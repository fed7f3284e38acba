"""Limits of a path that need no simulation: pushing without force, and what comes before the first resistance."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.studies.run.limits import Course, without_force


@pytest.mark.parametrize(
    ("force", "found"),
    [
        ((1.0, 3.0, 9.0, 20.0), 0),
        ((0.0, 0.0, 2.0, 9.0), 0),  # mounted slack: pushed straight first
        ((1.0, 3.0, 0.0, 0.0), 2),  # the body slipped between the nodes
        ((0.0, 2.0, 0.0, 5.0), 1),
        ((0.0, 0.0, 0.0, 0.0), 4),  # it was between them from the start
    ],
)
def test_pushing_without_force_counts_from_the_first_resistance_on(force: tuple[float, ...], found: int) -> None:
    nothing = np.zeros(4)
    path = Course(np.arange(1.0, 5.0), np.array(force), nothing, nothing, nothing, 0.0, 0, 0.0)
    assert without_force(path) == found


def test_going_back_and_out_again_is_no_push() -> None:
    """Unloaded to no force and pushed again up to where it was before."""
    travel, force = np.array([1.0, 2.0, 0.5, 1.5]), np.array([1.0, 4.0, 0.0, 0.0])
    nothing = np.zeros(4)
    assert without_force(Course(travel, force, nothing, nothing, nothing, 0.0, 0, 0.0)) == 0
