"""Effects by name: the library, a user's own from a file or an installed package, and the check of their numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from etextile.effects.base import Effect, Parameter
from etextile.effects.bending_stiffness import BendingStiffness
from etextile.effects.clamp_compliance import ClampCompliance
from etextile.effects.clamp_slip import ClampSlip
from etextile.effects.compression_carry import CompressionCarry
from etextile.effects.crimp_interchange import CrimpInterchange
from etextile.effects.datum_offset import DatumOffset
from etextile.effects.geometry import Geometry
from etextile.effects.machine_compliance import MachineCompliance
from etextile.effects.pretension import Pretension
from etextile.effects.punch_friction import PunchFriction
from etextile.effects.rate_dependence import RateDependence
from etextile.effects.rotational_shear import RotationalShear
from etextile.effects.shear_locking import ShearLocking
from etextile.effects.user import from_entry_points, from_file
from etextile.effects.yarn_damage import YarnDamage
from etextile.effects.yarn_sliding import YarnSliding
from etextile.effects.yarn_tail import YarnTail
from etextile.errors import BadInput, Problem, nearest
from etextile.mechanics.model import Model
from etextile.registry import Registry
from etextile.units import to_number


EFFECTS: Registry[type[Effect]] = Registry("effect")
for _effect in (
    RotationalShear,
    YarnTail,
    YarnDamage,
    ClampSlip,
    ClampCompliance,
    MachineCompliance,
    DatumOffset,
    Pretension,
    PunchFriction,
    YarnSliding,
    ShearLocking,
    CrimpInterchange,
    RateDependence,
    BendingStiffness,
    CompressionCarry,
    Geometry,
):
    EFFECTS.register(_effect.card.id, _effect)


def effect_class(name: str, file: str | None = None) -> type[Effect]:
    """Return the effect called `name`: from a Python file, the library, or an installed package, in this order.

    Raises BadInput that lists the known names.
    """
    if file is not None:
        return from_file(file, name)
    if name in EFFECTS:
        return EFFECTS[name]
    installed = from_entry_points()
    if name in installed:
        return installed[name]
    known = (*EFFECTS, *installed)
    message = f"unknown name (got {name!r}), known are {', '.join(known)}{nearest(name, known)}"
    raise BadInput.of(f"{message}; an effect of your own needs its file", key="id")


def check_effect(name: str, parameters: Mapping[str, Any]) -> dict[str, float]:
    """Return all parameters of an effect as numbers in its own units, defaults filled in.

    Raises BadInput with every problem: key `id`, or the name of the parameter that is unknown, missing or out of range.
    """
    given = dict(parameters)
    card = effect_class(name, given.pop("file", None)).card
    known = {item.name: item for item in card.parameters}
    problems = [_unknown(name, key, known) for key in given if key not in known]
    main = [item.name for item in card.parameters if item.neutral is not None]
    if not set(main) & set(given) and all(known[key].default is not None for key in main):
        problems.append(Problem(f"nothing is given that {name} would change, give {' or '.join(main)}", key="id"))
    values: dict[str, float] = {}
    for item in card.parameters:
        try:
            values[item.name] = _value(item, given)
        except ValueError as error:
            problems.append(Problem(str(error), key=item.name))
    if problems:
        raise BadInput(problems)
    return values


def build_effect(name: str, parameters: Mapping[str, Any]) -> Effect:
    """Return the effect with its parameters, plain numbers or text with units; BadInput as from `check_effect`.

    The key `file` names a Python file with an effect of the user's own.
    """
    values = check_effect(name, parameters)
    return effect_class(name, parameters.get("file"))(**values)


def apply_effects(model: Model, effects: Iterable[Effect]) -> Model:
    """Return the model with all effects, applied by stage: laws first, the machine last, whatever their order."""
    for effect in sorted(effects, key=lambda item: item.stage):
        model = effect.apply(model)
    return model


def with_effects(model: Model, chosen: Sequence[tuple[str, Mapping[str, Any]]]) -> Model:
    """Return the model with a case's effects, given as (id, parameters), applied by stage.

    Raises BadInput whose problems name their place in the list: `effects.0.limit`.
    """
    effects: list[tuple[int, Effect]] = []
    problems: list[Problem] = []
    for index, (name, parameters) in enumerate(chosen):
        try:
            effects.append((index, build_effect(name, parameters)))
        except BadInput as error:
            problems += _placed(error, index)
    if problems:
        raise BadInput(problems)
    for index, effect in sorted(effects, key=lambda item: item[1].stage):
        try:
            model = effect.apply(model)
        except BadInput as error:
            raise BadInput(_placed(error, index)) from error
        for block in model.truss_blocks:
            if block.fault:
                text = f"{effect.card.id} makes a model that cannot be computed: {block.fault}"
                raise BadInput([Problem(text, key=f"effects.{index}.id")])
    return model


def _placed(error: BadInput, index: int) -> list[Problem]:
    """Return the problems of an effect with keys that begin at the case; those of its file stay where they are."""
    return [
        problem if problem.file else replace(problem, key=f"effects.{index}.{problem.key or 'id'}")
        for problem in error.problems
    ]


def _value(item: Parameter, given: Mapping[str, Any]) -> float:
    """Return one parameter; raises ValueError with a text for the user."""
    if item.name not in given:
        if item.default is None:
            raise ValueError(f"this parameter is missing, give {item.meaning}, {_range(item)}")
        return item.default
    value = to_number(given[item.name], item.unit)
    if not item.allows(value):
        raise ValueError(f"out of range (got {given[item.name]!r}), must be {_range(item)}")
    return value


def _range(item: Parameter) -> str:
    unit = f" {item.unit}" if item.unit else ""
    low, high = item.possible
    beside = item.neutral is not None and not low <= item.neutral <= high
    return f"{low:g} to {high:g}{unit}" + (f" ({item.neutral:g} for no effect)" if beside else "")


def _unknown(name: str, key: str, known: Mapping[str, Parameter]) -> Problem:
    return Problem(f"unknown key for {name}, allowed are {', '.join(('id', *known))}{nearest(key, known)}", key=key)
