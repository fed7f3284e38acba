"""States of any nesting survive the way through named arrays, and foreign states are refused."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from etextile.errors import EtextileError
from etextile.results.restart import flatten, rebuild


@dataclass(frozen=True)
class Slip:
    amount: NDArray[np.float64]
    stuck: NDArray[np.bool_]
    work: float


@dataclass(frozen=True)
class State:
    x: NDArray[np.float64]
    travel: float
    leg: int
    parts: tuple[Slip | None, ...]


def state(value: float, *, size: int = 3) -> State:
    slip = Slip(np.full(size, value), np.full(size, value > 0), 2 * value)
    return State(np.full((size, 3), value), value, int(value), (slip, None))


def test_names_follow_the_nesting() -> None:
    assert list(flatten(state(1.0))) == ["x", "travel", "leg", "parts.0.amount", "parts.0.stuck", "parts.0.work"]


def test_a_state_comes_back_from_its_arrays_with_types_and_structure() -> None:
    back = rebuild(state(0.0), flatten(state(4.0)))
    assert isinstance(back, State)
    assert (back.travel, back.leg, back.parts[1]) == (4.0, 4, None)
    assert type(back.leg) is int
    np.testing.assert_array_equal(back.x, np.full((3, 3), 4.0))
    np.testing.assert_array_equal(back.parts[0].amount, np.full(3, 4.0))
    assert back.parts[0].stuck.dtype == bool
    assert back.parts[0].work == 8.0


def test_the_template_is_left_alone() -> None:
    template = state(0.0)
    rebuild(template, flatten(state(4.0)))
    np.testing.assert_array_equal(template.x, 0.0)


def test_a_state_of_another_model_is_refused() -> None:
    with pytest.raises(EtextileError, match=r"x \(4, 3\), not \(3, 3\)"):
        rebuild(state(0.0), flatten(state(1.0, size=4)))
    arrays = flatten(state(1.0))
    del arrays["parts.0.work"]
    with pytest.raises(EtextileError, match=r"parts\.0\.work on one side only"):
        rebuild(state(0.0), arrays)
