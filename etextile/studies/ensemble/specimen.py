"""One sampled specimen: the model of a case with fabric laws, mounting, loops, wires and body as drawn.

The case is changed where it has a key for it (places of wires, loops and body) and built anew; the rest changes the
model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import TypeGuard

import numpy as np

from etextile.effects.change import with_laws
from etextile.effects.pretension import Pretension
from etextile.ensemble.inputs import COLUMNS, REACH
from etextile.ensemble.sample import local_normal
from etextile.ensemble.store import SampleKey
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, WIRE
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution
from etextile.mechanics.truss import TrussBlock
from etextile.studies.ensemble.plan import ScatterPlan, moved, plan_of
from etextile.types import Array
from etextile.vocabulary import FABRIC_FAMILIES
from loadcases.build import Built, build
from loadcases.judging import judge_for
from loadcases.reader import read_case
from loadcases.schema import Case
from wires.judge import Judge
from wires.layout import WireLayout


FAMILY_NUMBER = dict(zip(FABRIC_FAMILIES, (WARP, WEFT, DIAGONAL), strict=True))


@dataclass(frozen=True)
class SampleTask:
    """One sample to run: the case as canonical YAML, what it belongs to, where it is kept, its row of unit numbers."""

    case_text: str
    key: SampleKey
    folder: str
    number: int
    row: tuple[float, ...]


@dataclass(frozen=True)
class Nominal:
    """A case without scatter, and what scatters in it."""

    case: Case
    built: Built
    plan: ScatterPlan
    judge: Judge
    """Of a garment whose strength is drawn."""


@dataclass(frozen=True)
class SampledSpecimen:
    """A sampled specimen: the model to run, the factor on the strains its wires stand, and the inputs by name."""

    built: Built
    strength: float
    inputs: dict[str, float]


@lru_cache(maxsize=4)
def nominal(case_text: str) -> Nominal:
    """Return a case without scatter, built once per process."""
    case = read_case(case_text).case
    return Nominal(case, build(case), plan_of(case), judge_for(case).within_garment)


def specimen_of(now: Nominal, task: SampleTask) -> SampledSpecimen:
    """Return the sampled specimen of a task."""
    row = dict(zip(COLUMNS, task.row, strict=True))
    values = {item.name: item.value(row) for item in now.plan.inputs}
    case = moved(now.case, values)
    built = now.built if case is now.case else build(case)
    model = built.model
    levels: dict[str, float] = {}
    for family, scatter in now.plan.families.items():
        number = FAMILY_NUMBER[family]
        factors = scatter.factors([row[f"{family}_{k}"] for k in (1, 2, 3)])
        before = model.lattice_block.laws[number]
        model = with_laws(model, (number,), partial(_scaled, factors=factors))
        top = getattr(built.fabric, family).strain_range[1]
        levels[f"{family}_level"] = _stress(model.lattice_block.laws[number], top) / _stress(before, top)
    mounting = values.get("mounting", 0.0)
    model = _mounted(model, mounting)
    built = replace(built, model=model)
    if now.plan.loop_slack > 0.0 and built.wires is not None:
        built = _with_slack(built, _loop_slack(built.wires.layout, now.plan.loop_slack, task))
        levels["loop_slack"] = float(built.wires.layout.loop_slack.mean()) if built.wires is not None else 0.0
    return SampledSpecimen(built, float(np.exp(values.get("strength", 0.0))), {**levels, **values})


def _scaled(law: PowerLaw, factors: Mapping[str, float]) -> PowerLaw:
    return replace(law, E=law.E * factors["E"], H=law.H * factors["H"], n=law.n * factors["n"])


def _stress(law: PowerLaw, engineering_strain: float) -> float:
    return float(law.loading_curve(np.array([engineering_strain]))[0])


def _mounted(model: Model, strain: float) -> Model:
    """Return the model of a piece that was cut 1 / (1 + strain) as long as the clamps are apart, wires and all."""
    if strain == 0.0:
        return model
    return Pretension(strain=strain).apply(model)


def _loop_slack(layout: WireLayout, share: float, task: SampleTask) -> Array:
    """Return the slack (L,) of the loops, each scattered by itself."""
    slack = layout.loop_slack.copy()
    for wire in range(layout.n_wires):
        own = layout.loop_wire == wire
        draw = local_normal(int(own.sum()), seed=task.key.seed, sample=task.number, place=wire, reach=REACH)
        slack[own] *= np.maximum(1.0 + share * draw, 0.0)
    return slack


def _with_slack(built: Built, slack: Array) -> Built:
    """Return the model with loops of another slack."""
    wires = built.wires
    if wires is None or not len(slack):
        return built
    factor = np.ones(wires.count + wires.layout.n_loops)
    factor[wires.loops] = (1.0 + slack) / (1.0 + wires.layout.loop_slack)
    parts: list[Contribution] = []
    first = 0
    for part in built.model.contributions:
        if _is_wire(part):
            own = factor[first : first + len(part.nodes)]
            first += len(own)
            part = replace(part, rest_length=part.rest_length * own)
        parts.append(part)
    return replace(
        built,
        model=replace(built.model, contributions=tuple(parts)),
        wires=replace(wires, layout=wires.layout.with_loop_slack(slack)),
    )


def _is_wire(part: Contribution) -> TypeGuard[TrussBlock]:
    return isinstance(part, TrussBlock) and bool(len(part.family)) and bool((part.family == WIRE).all())
