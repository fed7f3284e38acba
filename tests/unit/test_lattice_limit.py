"""The limit of three lattices: exact for errors of h^2, refused with the reason for anything else."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.studies.run.lattice_limit import Level, limit_of, richardson
from etextile.types import Array


TRAVEL = np.linspace(5.0, 50.0, 10)
TRUE = TRAVEL**2
PLACES = np.array([1.0, 0.4, 0.2])


def levels(sizes: tuple[float, ...], power: float, *, wobble: float = 0.0) -> list[Level]:
    """Return lattices whose force and strains are off by the cell's size to a power, strains also to and fro."""
    found = []
    for number, size in enumerate(sizes):
        off = 1e-3 * size**power
        way = PLACES * (1.0 + wobble * np.array([1.0, -1.0, 1.0]) * (-1.0) ** number)
        span = 1e-4 * TRUE[:, None] * (PLACES + off * way)
        wire = np.maximum((1.0 + span) / 1.04 - 1.0, 0.0)
        found.append(Level((round(100 / size), round(100 / size)), size, TRUE * (1.0 - off), span, wire))
    return found


@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (4.1, 1.9, 1.0)])
def test_errors_of_the_square_of_the_cell_are_taken_off_exactly(sizes: tuple[float, ...]) -> None:
    found = limit_of(levels(sizes, 2.0), None, None)
    assert found.reason == ""
    assert found.force is not None
    assert found.span is not None
    assert found.wire is not None
    assert found.force.order == pytest.approx(2.0)
    np.testing.assert_allclose(found.force.values, TRUE)
    np.testing.assert_allclose(found.span.values, 1e-4 * TRUE[:, None] * PLACES)
    exact = np.maximum((1.0 + 1e-4 * TRUE[:, None] * PLACES) / 1.04 - 1.0, 0.0)
    taut = np.all([level.wire > 0.0 for level in found.levels], axis=0)
    np.testing.assert_allclose(found.wire.values[taut], exact[taut], atol=1e-12)
    assert np.all(np.abs(found.wire.values - exact) <= found.wire.doubt + 1e-12)


def test_a_limit_is_doubted_by_a_quarter_of_what_was_extrapolated_at_least() -> None:
    values: list[Array] = [np.array([1.0 + size**2]) for size in (4.0, 2.0, 1.0)]
    assert richardson(values, [4.0, 2.0, 1.0]).doubt == pytest.approx([0.25])


def test_a_term_of_the_fourth_power_stays_within_the_doubt() -> None:
    values: list[Array] = [np.array([1.0 + size**2 + 0.05 * size**4]) for size in (4.0, 2.0, 1.0)]
    found = richardson(values, [4.0, 2.0, 1.0])
    assert 0.0 < abs(found.values[0] - 1.0) < found.doubt[0]


@pytest.mark.parametrize(("power", "said"), [(1.0, "power 1.0"), (3.0, "power 3.0")])
def test_forces_that_fall_otherwise_are_refused(power: float, said: str) -> None:
    found = limit_of(levels((4.0, 2.0, 1.0), power), None, None)
    assert said in found.reason
    assert "finer fabric.coarsening" in found.reason
    assert found.force is None


def test_forces_that_go_to_and_fro_are_refused() -> None:
    swinging = [Level((9, 9), size, TRUE * (1.0 + off), np.zeros((10, 0)), np.zeros((10, 0)))
                for size, off in ((4.0, 0.04), (2.0, -0.02), (1.0, -0.005))]  # fmt: skip
    assert "off its shape" in limit_of(swinging, None, None).reason


def test_loops_whose_strains_change_without_order_are_refused() -> None:
    assert "alike" in limit_of(levels((4.0, 2.0, 1.0), 2.0, wobble=3.0), None, None).reason


def test_lattices_that_hardly_differ_need_no_order() -> None:
    flat = [Level((9, 9), size, TRUE * (1.0 + 1e-5 * way), np.zeros((10, 0)), np.zeros((10, 0)))
            for size, way in ((4.0, 1.0), (2.0, -1.0), (1.0, 1.0))]  # fmt: skip
    found = limit_of(flat, None, None)
    assert found.force is not None
    np.testing.assert_allclose(found.force.values, TRUE, rtol=2e-5)
