"""What every failure criterion must do, run over the registry."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from etextile.vocabulary import INTACT, OPEN
from wires.failure import CRITERIA, evaluate, resolve
from wires.layout import lay_out


LAYOUT = lay_out(
    length_mm=100, width_mm=20, wire_spacing_mm=6.0, loop_spacing_mm=20.0, loop_length_mm=4.0, loop_slack=0.02
)

pytestmark = pytest.mark.parametrize("name", list(CRITERIA))


def stretched(span: Array) -> WireHistory:
    """History in which the fabric strains (S,) are the same at all loops and elements."""
    every = span[:, None] * np.ones(LAYOUT.n_loops)
    return WireHistory(
        displacement_mm=np.linspace(0.0, 50.0, span.size),
        span_strain=every,
        wire_strain=np.maximum((1 + every) / (1 + LAYOUT.loop_slack) - 1, 0.0),
        element_wire=np.arange(LAYOUT.n_wires),
        element_warp_mm=np.zeros(LAYOUT.n_wires),
        element_strain=span[:, None] * np.ones(LAYOUT.n_wires),
        layout=LAYOUT,
    )


def test_unstrained_wires_are_intact(name: str) -> None:
    result = evaluate(stretched(np.zeros(3)), name)
    assert (result.state == INTACT).all()
    assert (result.filaments_broken == 0).all()
    assert (result.failure_probability == 0).all()
    assert (result.open_probability < 1e-12).all()
    assert np.isnan(result.first_failure_mm).all()


def test_compressed_wires_are_intact(name: str) -> None:
    result = evaluate(stretched(np.linspace(0.0, -0.3, 4)), name)
    assert (result.state == INTACT).all()
    assert (result.max_strain == 0).all()


def test_large_strain_opens_every_wire(name: str) -> None:
    result = evaluate(stretched(np.linspace(0.0, 1.0, 4)), name)
    assert (result.loop_state == OPEN).all()
    assert result.wire_open_probability == pytest.approx(1.0)


def test_states_come_in_order_and_all_occur(name: str) -> None:
    result = evaluate(stretched(np.linspace(0.0, 0.6, 601)), name)
    assert (np.diff(result.state, axis=0) >= 0).all()
    assert np.unique(result.state).tolist() == [0, 1, 2, 3]


def test_more_strain_is_never_better(name: str) -> None:
    ends = np.linspace(0.0, 0.3, 61)
    results = [evaluate(stretched(np.array([0.0, end])), name) for end in ends]
    for quantity in ("loop_state", "loop_broken", "max_strain", "failure_probability", "open_probability"):
        assert (np.diff([getattr(result, quantity)[0] for result in results]) >= -1e-12).all(), quantity


def test_damage_is_irreversible(name: str) -> None:
    loaded, unloaded = np.array([0.0, 0.1]), np.array([0.0, 0.1, 0.02, -0.1, 0.05])
    there, back = evaluate(stretched(loaded), name), evaluate(stretched(unloaded), name)
    assert (np.diff(back.state, axis=0) >= 0).all()
    assert (np.diff(back.filaments_broken, axis=0) >= 0).all()
    assert np.array_equal(there.loop_state, back.loop_state)
    assert np.array_equal(there.failure_probability, back.failure_probability)


def test_states_agree_with_shares_and_first_failure(name: str) -> None:
    result = evaluate(stretched(np.linspace(0.0, 0.2, 21)), name)
    damaged = result.state >= 2
    assert (damaged | (result.filaments_broken == 0)).all()
    at = np.interp(result.first_failure_mm, result.displacement_mm, np.arange(21))
    first = damaged.argmax(axis=0)
    assert ((first - 1 <= at) & (at <= first)).all()


def test_first_failure_does_not_depend_on_the_step(name: str) -> None:
    coarse, fine = (evaluate(stretched(np.linspace(0.0, 0.2, n)), name).first_failure_mm for n in (8, 2001))
    assert coarse == pytest.approx(fine, abs=0.05)


def test_evaluation_is_pure(name: str) -> None:
    history = stretched(np.linspace(0.0, 0.15, 5))
    before, parameters = copy.deepcopy(history), resolve(name, {})
    first = CRITERIA[name].evaluate(history, parameters)
    second = CRITERIA[name].evaluate(history, parameters)
    assert parameters == resolve(name, {})
    assert np.array_equal(history.span_strain, before.span_strain)
    assert np.array_equal(history.wire_strain, before.wire_strain)
    assert np.array_equal(first.state, second.state)
    assert np.array_equal(first.filaments_broken, second.filaments_broken)


def test_it_is_documented(name: str) -> None:
    criterion = CRITERIA[name]
    assert criterion.name == name
    assert 10 < len(criterion.summary) < 100
    for parameter in criterion.parameters:
        assert parameter.source
        assert parameter.origin in ("stated", "derived", "estimated")
        assert parameter.default >= parameter.minimum
