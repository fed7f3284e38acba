"""The block `life` of the report: how many cycles the loops last, and the chance of fewer than are required.

A loop whose life by the law is N lasts fewer than n cycles with the probability

    P = Phi(ln(n / N) / s)

with the standard deviation s of the logarithm of lives. Of a garment, with loops independent of each other, it is
1 - (1 - P0) prod (1 - P)^copies, where P0 is the chance that a filament breaks in the first loading already (what the
failure criterion says): the two are told apart and together. The chance of the worst loop alone is what is left if all
loops shared their luck; the truth lies between.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import ndtr

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from wires.damage import FailureResult
from wires.fatigue import Cycles, StrainLife, swings
from wires.wording import cycles as written
from wires.wording import probability


SCATTER = 0.5
"""Standard deviation of ln(life) where a case gives none: as of a Weibull shape of 2.6, an estimate."""
ASSUMED = (
    "the fabric was identified for monotonic loading; mean strain is not corrected for; the swing of a wire that is "
    "pushed back counts whole, although it may buckle; where fabric lies slack its shape and so the swing is not unique"
)


@dataclass(frozen=True)
class LifeSpec:
    """What a case says of life: the law, scatter of ln(life) (None: the estimate), required cycles, agreed terms."""

    law: StrainLife
    scatter: float | None = None
    required: float | None = None
    terms: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Life:
    """Largest strain range, its mean, first plastic strain and cycles to failure of every loop (L,), and the block."""

    strain_range: Array
    strain_mean: Array
    first_plastic_strain: Array
    cycles_to_failure: Array
    block: dict[str, Any] | None

    def loop(self, loop: int) -> dict[str, float]:
        """Return the keys of a loop in the report."""
        names = ("strain_range", "strain_mean", "first_plastic_strain", "cycles_to_failure")
        return {name: float(getattr(self, name)[loop]) for name in names}


def life_of(history: WireHistory, damage: FailureResult, spec: LifeSpec | None, *, left: Array | None = None) -> Life:
    """Return the lives of all loops; without a law the swings alone, and no block unless the path repeats itself.

    left (R,): travels of a path that was not simulated further because the piece had settled.
    """
    part = Cycles.of(history)
    if left is not None and left.size:
        part = part.continued(left)
    found = [swings(part.loops[:, loop]) for loop in range(history.layout.n_loops)]
    largest = np.array([item.largest for item in found]).reshape(-1, 2)
    plastic = np.maximum(part.first - damage.parameters.get("yield_strain", 0.0), 0.0)
    lives = np.full(len(found), np.inf)
    if spec is not None:
        sums = np.array([item.damage(spec.law) for item in found])
        with np.errstate(divide="ignore"):
            lives = part.count / sums
    block = None
    if spec is not None or part.repeated:
        block = _block(history, damage, part, largest[:, 0], lives, spec)
    return Life(largest[:, 0], largest[:, 1], plastic, lives, block)


def by_life(wires: Sequence[Mapping[str, Any]], most: int) -> list[dict[str, Any]]:
    """Return loops of a report, those of the shortest lives first, of the largest swings where no life is known."""
    loops = [
        {"weft_mm": wire["weft_mm"], **loop, "wire": wire["wire"], "name": wire.get("name") or str(wire["wire"])}
        for wire in wires
        for loop in wire["loops"]
    ]
    loops.sort(
        key=lambda loop: (math.inf if (life := loop["cycles_to_failure"]) is None else life, -loop["strain_range"])
    )
    return loops[:most]


def _block(
    history: WireHistory,
    damage: FailureResult,
    part: Cycles,
    ranges: Array,
    lives: Array,
    spec: LifeSpec | None,
) -> dict[str, Any]:
    """Return the entry of the report."""
    layout = history.layout
    head = {
        "counted_on": "the cycles of the path after its first turn" if part.repeated else "loading to depth and back",
        "cycles_in_path": part.count,
        "assumed": ASSUMED,
    }
    worst = int(np.argmin(lives)) if len(lives) else None
    critical = None
    if worst is not None:
        worst = worst if np.isfinite(lives[worst]) else int(np.argmax(ranges))
        critical = {
            "wire": layout.loop_wire[worst],
            "loop": layout.loop_index[worst],
            "warp_mm": layout.loop_warp_mm[worst],
            "weft_mm": layout.weft_mm[layout.loop_wire[worst]],
        }
    found: dict[str, Any] = {
        "required_cycles": None,
        "shortest_cycles": None,
        "p_below_required": None,
        "critical_loop": critical,
        **head,
        "law": None,
        "scatter": None,
        "terms": {} if spec is None else dict(spec.terms),
    }
    if spec is not None:
        found |= {
            "required_cycles": spec.required,
            "shortest_cycles": float(lives.min(initial=np.inf)),
            "law": {**spec.law.report(), "source": spec.law.source},
            "scatter": _scatter(spec),
            **_chances(damage, lives, spec),
        }
    return {**found, "sentence": _sentence(found, ranges)}


def _scatter(spec: LifeSpec) -> dict[str, Any]:
    given = spec.scatter is not None
    return {"log_std": spec.scatter if given else SCATTER, "origin": "case" if given else "estimated"}


def _chances(damage: FailureResult, lives: Array, spec: LifeSpec) -> dict[str, Any]:
    """Return the chances of a life below the required one: of the garment, by parts."""
    if spec.required is None:
        return {}
    log_std = spec.scatter if spec.scatter is not None else SCATTER
    with np.errstate(divide="ignore"):
        each = ndtr(np.log(spec.required / np.maximum(lives, 1e-300)) / log_std)
    layout = damage.layout
    copies = layout.loop_copies * layout.wire_copies[layout.loop_wire]
    worn = -np.expm1(np.sum(copies * np.log1p(-np.minimum(each, 1.0 - 1e-16))))
    first = 0.0 if damage.reliability is None else float(damage.reliability.report()["p_any_wire_broken"])
    return {
        "p_below_required": 1.0 - (1.0 - first) * (1.0 - float(worn)),
        "p_parts": {
            "first_loading": first,
            "worn": float(worn),
            "worst_loop": float(np.max(each, initial=0.0)),
        },
    }


def _sentence(found: Mapping[str, Any], ranges: Array) -> str:
    """Say what the block holds."""
    place = found["critical_loop"]
    if place is None:
        return "The wires have no loops whose life could be told."
    where = f"wire {place['wire']}, loop {place['loop']}"
    if found["law"] is None:
        return (
            f"Strains of the loops swing by up to {float(np.max(ranges)):.3f} a cycle ({where}); how many cycles they "
            "last needs a strain-life law (failure.cyclic)."
        )
    shortest = found["shortest_cycles"]
    text = (
        f"The shortest life of a loop is {written(shortest)} cycles ({where})."
        if np.isfinite(shortest)
        else "No loop swings, so none wears out."
    )
    if found["p_below_required"] is None:
        return text
    parts = found["p_parts"]
    return (
        f"{text} A filament breaks before the required {written(found['required_cycles'])} cycles with probability "
        f"{probability(found['p_below_required'])}: in the first loading with {probability(parts['first_loading'])}, "
        f"by wear with {probability(parts['worn'])}."
    )
