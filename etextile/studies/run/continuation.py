"""What the laws say beyond the range they were identified in, and which verdicts hang on it.

A fabric file states a low and a high continuation of each law (`loadcases.continuation`). When trusses pass their range
the load path is followed twice more, from the last state in which none had, with every law continued low and with every
law continued high. A loop whose verdict is the same three times is decided by geometry: the body and the supports
prescribe its strain, whatever the law. One whose verdict differs is open to the law.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from etextile.effects.change import lattice_block, plastic_part, with_laws
from etextile.errors import NoEquilibrium
from etextile.lattice.weave import DIAGONAL, WARP, WEFT
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.results.reader import Results
from etextile.results.wire_history import WireHistory
from etextile.solve.path import Increment, Snapshot, advance
from etextile.types import Array
from loadcases.build import Built, settings
from wires.damage import FailureResult
from wires.judge import Judge
from wires.strain import wire_strains


FAMILIES = {"warp": WARP, "weft": WEFT, "diagonal": DIAGONAL}
Way = Literal["low", "high"]
WAYS: tuple[Way, ...] = ("low", "high")


@dataclass(frozen=True)
class Inside:
    """The last output state in which no truss was beyond its range, and the number of outputs up to it."""

    snapshot: Snapshot | None = None
    steps: int = 0


@dataclass(frozen=True)
class Continued:
    """One continuation: force at the end N, what becomes of the wires (None when it ended early), why it did."""

    force: float
    damage: FailureResult | None
    trouble: str = ""


def identified_to(built: Built) -> Array:
    """Return the engineering strains (3,) up to which warp, weft and diagonal are identified."""
    return np.array([getattr(built.fabric, name).strain_range[1] for name in FAMILIES])


def reached(model: Model, strain: Array) -> Array:
    """Return the largest engineering strains (3,) of warp, weft and diagonal that the laws see.

    `strain` (M, ...): of all trusses over their length in the flat piece; a piece mounted taut is at more.
    """
    block = lattice_block(model)
    own = (1.0 + strain[: len(block.span)]) * block.span / block.rest_length - 1.0
    return np.array([own[block.family == family].max(initial=0.0) for family in FAMILIES.values()])


def still_inside(built: Built, increment: Increment) -> bool:
    """Tell whether no truss of the fabric is beyond its range."""
    return bool(np.all(reached(built.model, increment.truss_strain) <= identified_to(built)))


def reached_in(results: Results, built: Built) -> Array:
    """Return the largest strains (S, 3) of the families over the output steps so far."""
    found = [reached(built.model, results.array("strain", step)) for step in range(results.steps)]
    return np.maximum.accumulate(np.array(found).reshape(-1, len(FAMILIES)), axis=0)


def continued_law(law: PowerLaw, slope: float | str, onset: float) -> PowerLaw:
    """Return the law with another slope of hardening beyond the engineering strain `onset`.

    A law that an effect has given a tail of its own keeps it: there the effect says what the law is.
    """
    if law.tail_factor != 0.0:
        return law
    straight = isinstance(slope, str)
    factor = 0.0 if isinstance(slope, str) else slope - 1.0
    return replace(law, tail_onset=plastic_part(law, onset), tail_factor=factor, tail_straight=straight)


def continued_model(built: Built, way: Way) -> Model:
    """Return the model with every law continued `low` or `high`."""
    model = built.model
    for name, family in FAMILIES.items():
        of = getattr(built.fabric, name)

        def change(law: PowerLaw, slope: float | str = getattr(of.beyond, way), end: float = of.strain_range[1]) -> Any:
            return continued_law(law, slope, end)

        model = with_laws(model, (family,), change)
    return model


@dataclass(frozen=True)
class Followed:
    """A path with the laws continued: force at its end N, history of the wires (None when it ended early), why."""

    force: float
    history: WireHistory | None
    trouble: str = ""


def follow(built: Built, results: Results, judge: Judge, *, way: Way, inside: Inside) -> Continued:
    """Follow the load path from the last state inside the range with the laws continued, and judge the wires."""
    found = followed(built, results, way=way, inside=inside)
    damage = None if found.history is None else judge.judge(found.history)
    return Continued(found.force, damage, found.trouble)


def followed(built: Built, results: Results, *, way: Way, inside: Inside) -> Followed:
    """Follow the load path from the last state inside the range with the laws continued."""
    model = continued_model(built, way)
    travel, strains, trouble = [], [], ""
    force = float(results.curves.punch_force_N[-1])
    try:
        for increment in advance(model, settings(built.case), snapshot=inside.snapshot, first_index=inside.steps):
            if increment.output and built.wires is not None:
                travel.append(increment.displacement_mm)
                strains.append(wire_strains(built.wires, model, increment))
            force = increment.punch_force_N
    except NoEquilibrium as error:
        trouble = str(error)
    history = results.wires
    if history is None or trouble:
        return Followed(force, None, trouble)
    return Followed(force, _spliced(history, inside.steps, travel, strains))


def _spliced(history: WireHistory, steps: int, travel: list[float], strains: list[dict[str, Array]]) -> WireHistory:
    """Return a history up to its first `steps` outputs, followed by others."""
    kept = slice(0, 1 + steps)

    def joined(name: str) -> Array:
        before = getattr(history, name)[kept]
        return np.concatenate([before, np.reshape([item[name] for item in strains], (len(strains), before.shape[1]))])

    return replace(
        history,
        displacement_mm=np.concatenate([history.displacement_mm[kept], travel]),
        span_strain=joined("span_strain"),
        wire_strain=joined("wire_strain"),
        element_strain=joined("element_strain"),
    )
