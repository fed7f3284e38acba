"""What every effect of the library keeps: card, neutral value, purity, consistent energies, declared signs."""

from __future__ import annotations

import pickle
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache

import numpy as np
import pytest

from etextile.contact.contact import Contact
from etextile.effects.base import Effect, Stage
from etextile.effects.registry import EFFECTS, apply_effects, build_effect, check_effect
from etextile.errors import BadInput
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Response
from etextile.results.restart import flatten, rebuild
from etextile.solve.path import Increment, Snapshot, advance, start
from etextile.solve.system import System
from etextile.types import Array
from loadcases.build import build, settings
from loadcases.reader import load_case


IDS = (
    "rotational_shear", "yarn_tail", "yarn_damage", "clamp_slip", "clamp_compliance", "machine_compliance",
    "datum_offset", "pretension", "punch_friction", "yarn_sliding", "shear_locking", "crimp_interchange",
    "rate_dependence", "bending_stiffness", "compression_carry", "geometry",
)  # fmt: skip
STEPS = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0)


@lru_cache
def punch(portion: str = "quarter", coarsening: float = 19.5) -> Model:
    case = load_case("punch", overrides=["wires=null", f"fabric.portion={portion}", f"fabric.coarsening={coarsening}"])
    return replace(build(case.case).model, travel=np.array(STEPS))


def example(name: str) -> Effect:
    return build_effect(name, EFFECTS[name].card.example.parameters)


def run(model: Model, last: float = 40.0) -> list[Increment]:
    chosen = settings(load_case("punch").case)
    steps = model.travel[model.travel <= last]
    return [item for item in advance(replace(model, travel=steps), chosen) if item.output]


@lru_cache
def forces(name: str) -> Array:
    model = punch() if name == "base" else example(name).apply(punch())
    return np.array([item.punch_force_N for item in run(model)])


def test_the_library_is_complete() -> None:
    assert sorted(EFFECTS) == sorted(IDS)


@pytest.mark.parametrize("name", IDS)
def test_the_card_says_everything(name: str) -> None:
    effect = EFFECTS[name]
    card = effect.card
    assert card.id == name
    assert is_dataclass(effect)
    assert [item.name for item in fields(effect)] == [item.name for item in card.parameters]
    assert all((card.mechanism, card.separate, card.literature, card.confused_with, card.signature, card.example))
    assert {"punch_force"} <= {item.channel for item in card.signature}
    assert set(card.confused_with) - set(EFFECTS) <= {"load cell gain"}
    for item in card.parameters:
        assert item.low < item.high
        assert item.neutral is None or item.allows(item.neutral)
        assert item.default is None or item.allows(item.default)
        assert item.allows(card.example.parameters[item.name])
    assert any(item.neutral is not None for item in card.parameters)


@pytest.mark.parametrize("name", IDS)
def test_the_neutral_effect_returns_the_model_itself(name: str) -> None:
    neutral = {item.name: item.neutral for item in EFFECTS[name].card.parameters if item.neutral is not None}
    effect = build_effect(name, neutral)
    assert effect.is_neutral
    model = punch()
    assert effect.apply(model) is model
    assert not example(name).is_neutral


@pytest.mark.parametrize("name", IDS)
def test_a_small_effect_has_a_small_consequence(name: str) -> None:
    """The neutral value is the limit of the mechanism: a thousandth of the example shows by less than 0.2 %."""
    effect = example(name)
    small = {
        item.name: getattr(effect, item.name) * (1e3 if item.scale == "log" else 1e-3)
        for item in effect.card.parameters
        if item.neutral is not None
    }
    found = run(replace(effect, **small).apply(punch()), last=30.0)[-1].punch_force_N
    assert found == pytest.approx(forces("base")[5], rel=2e-3)


@pytest.mark.parametrize("name", IDS)
def test_apply_is_pure(name: str) -> None:
    model = punch()
    before = contents(model)
    first, second = (example(name).apply(model) for _ in range(2))
    assert contents(model) == before
    assert contents(first) == contents(second)


def contents(item: object) -> bytes:
    """Return all fields as bytes, without what is only computed from them and kept for speed."""

    def plain(part: object) -> object:
        if is_dataclass(part):
            return (type(part), *(plain(getattr(part, each.name)) for each in fields(part)))
        return tuple(plain(each) for each in part) if isinstance(part, tuple) else part

    return pickle.dumps(plain(item))


@lru_cache
def deformed(name: str) -> tuple[Model, Snapshot]:
    model = example(name).apply(punch(coarsening=40.0))
    return model, run(model, last=25.0)[-1].state


@pytest.mark.parametrize("name", IDS)
def test_energy_force_and_tangent_agree(name: str) -> None:
    """Central differences of energy and gradient along a random direction, from a state with history."""
    model, state = deformed(name)
    system = System(model)
    random = np.random.default_rng(4)
    x = state.x + 0.02 * random.standard_normal(state.x.shape)
    way = random.standard_normal(state.x.shape)
    travel = state.travel + 0.1

    def parts(step: float) -> list[Response]:
        """The answers of all but plain contact, whose friction has no potential and which has tests of its own."""
        answers = system.evaluate(x + step * way, travel, state.states).responses
        return [item for part, item in zip(model.contributions, answers, strict=True) if not isinstance(part, Contact)]

    def at(step: float) -> tuple[float, Array]:
        gradient = np.zeros_like(x)
        for response in parts(step):
            response.add_gradient(gradient)
        return sum(sum(vars(response.energy()).values()) for response in parts(step)), gradient

    values = np.zeros(len(system.pattern.indices))
    kept = [
        pairs
        for part, pairs in zip(model.contributions, system.pattern.pairs, strict=True)
        if not isinstance(part, Contact)
    ]
    for response, pairs in zip(parts(0.0), kept, strict=True):
        response.add_tangent(system.pattern.rows, pairs, values, exact=True, damping=0.0)
    upper = system.pattern.matrix(values).toarray()
    push = ((upper + np.triu(upper, 1).T) @ way.ravel()).reshape(-1, 3)
    slope = float(np.vdot(at(0.0)[1], way))
    errors = []
    for h in (1e-4, 1e-5, 1e-6):
        (e_plus, g_plus), (e_minus, g_minus) = at(h), at(-h)
        errors.append(
            (
                abs((e_plus - e_minus) / (2 * h) - slope) / abs(slope),
                float(np.linalg.norm((g_plus - g_minus) / (2 * h) - push) / np.linalg.norm(push)),
            )
        )
    assert min(error for error, _ in errors) < 1e-6
    assert min(error for _, error in errors) < 1e-5


@pytest.mark.parametrize("name", IDS)
def test_the_convex_part_of_the_tangent_is_positive(name: str) -> None:
    model, state = deformed(name)
    system = System(model)
    x = state.x + 0.05 * np.random.default_rng(5).standard_normal(state.x.shape)
    trial = system.evaluate(x, state.travel, state.states)
    values = np.zeros(len(system.pattern.indices))
    for response, pairs in zip(trial.responses, system.pattern.pairs, strict=True):
        response.add_tangent(system.pattern.rows, pairs, values, exact=False, damping=0.0)
    upper = system.pattern.matrix(values).toarray()
    sizes = np.linalg.eigvalsh(upper + np.triu(upper, 1).T)
    assert sizes[0] > -1e-9 * sizes[-1]


@pytest.mark.parametrize("name", IDS)
def test_a_stopped_run_goes_on_with_the_same_digits(name: str) -> None:
    model, state = deformed(name)
    same = rebuild(start(model), flatten(state))
    further = replace(model, travel=np.array([state.travel, state.travel + 1.0]))
    first, second = (next(advance(further, snapshot=item, first_index=1)) for item in (state, same))
    np.testing.assert_array_equal(first.positions, second.positions)


@pytest.mark.parametrize("name", IDS)
def test_signs_and_onsets_are_as_declared(name: str) -> None:
    base, found = forces("base"), forces(name)
    change = found / base - 1.0
    signature = next(item for item in EFFECTS[name].card.signature if item.channel == "punch_force")
    early = np.array(STEPS) <= signature.onset_mm - 5.0
    assert np.all(np.abs(change[early]) < 0.005), change
    strongest = change[np.argmax(np.abs(change))]
    assert np.sign(strongest) == signature.sign
    assert abs(strongest) > 0.003


@pytest.mark.parametrize("name", IDS)
def test_the_examples_of_the_card_are_what_the_simulation_gives(name: str) -> None:
    """Printed by tests/benchmarks/effect_signatures.py with smaller steps, hence the width.

    Crossings start to slip within the last increment here, so yarn sliding shows the step most.
    """
    card = EFFECTS[name].card
    width = 0.2 if name == "yarn_sliding" else 0.05
    change = 100.0 * (forces(name) / forces("base") - 1.0)
    np.testing.assert_allclose(change[[1, 3, 4, 5, 7]], card.example.force_percent, atol=0.6, rtol=width)


def test_the_order_of_the_list_does_not_matter() -> None:
    chosen = [example(name) for name in ("machine_compliance", "rotational_shear", "clamp_slip", "rate_dependence")]
    assert [item.stage for item in sorted(chosen, key=lambda e: e.stage)] == sorted(item.stage for item in chosen)
    one, other = (apply_effects(punch(coarsening=40.0), order) for order in (chosen, chosen[::-1]))
    assert pickle.dumps(one) == pickle.dumps(other)
    assert Stage.LAW < Stage.MACHINE


def test_all_effects_together_still_make_a_model() -> None:
    model = apply_effects(punch(coarsening=40.0), [example(name) for name in IDS])
    found = run(model, last=10.0)
    assert len(found) == 2
    assert np.isfinite(found[-1].punch_force_N)


@pytest.mark.slow
@pytest.mark.parametrize("name", IDS)
def test_a_quarter_is_a_quarter_of_the_whole(name: str) -> None:
    """Symmetry planes must not change the mechanism (areas, widths and turns there count by their share)."""
    quarter, whole = (run(example(name).apply(punch(portion, 35.1)), last=25.0)[-1] for portion in ("quarter", "whole"))
    assert whole.punch_force_N == pytest.approx(quarter.punch_force_N, rel=1e-3)
    assert whole.clamp_force_N == pytest.approx(whole.punch_force_N, rel=1e-3)


def test_numbers_carry_units() -> None:
    assert check_effect("clamp_slip", {"limit": "1.2 kN/m"}) == {"limit": pytest.approx(1.2), "hardening": 0.0}
    assert check_effect("yarn_tail", {"slope_change": "-50 %", "onset": "12 %"})["onset"] == pytest.approx(0.12)
    assert check_effect("shear_locking", {"stiffness": 3, "angle": "0.5 rad"})["angle"] == pytest.approx(28.648, 1e-4)


@pytest.mark.parametrize(
    ("name", "parameters", "key", "words"),
    [
        ("clmp_slip", {"limit": 3}, "id", "did you mean 'clamp_slip'?"),
        ("clamp_slip", {"limt": 3}, "limt", "did you mean 'limit'?"),
        ("clamp_slip", {"limt": 3}, "limit", "this parameter is missing"),
        (
            "clamp_slip",
            {"limit": 5000},
            "limit",
            "out of range (got 5000), must be 0.02 to 1000 N/mm (0 for no effect)",
        ),
        ("clamp_slip", {"limit": "12 N"}, "limit", "the unit does not fit (got '12 N')"),
        ("clamp_slip", {"limit": "much"}, "limit", "text, not a number"),
        ("clamp_slip", {"limit": None}, "limit", "not a number"),
        ("geometry", {}, "id", "give radius or x or y"),
        ("my_own", {"file": "nowhere.py"}, "file", "no such Python file (got 'nowhere.py')"),
    ],
)
def test_wrong_input_is_refused_with_a_remedy(name: str, parameters: dict[str, object], key: str, words: str) -> None:
    with pytest.raises(BadInput) as caught:
        build_effect(name, parameters)
    assert any(problem.key == key and words in problem.message for problem in caught.value.problems)


@pytest.mark.parametrize("name", ["machine_compliance", "datum_offset", "punch_friction", "geometry"])
def test_effects_on_a_body_need_one(name: str) -> None:
    pulled = build(load_case("tension_warp", overrides=["wires=null", "fabric.coarsening=40"]).case).model
    with pytest.raises(BadInput, match="needs a body"):
        example(name).apply(pulled)
