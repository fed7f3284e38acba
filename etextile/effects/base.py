"""What an effect is: a mechanism the base model leaves out, as a pure change of the model, with a card about it.

A new effect is one frozen dataclass: its fields are the parameters, `card` says what it is and how it shows, and
`transform` returns the changed model. At the neutral parameters the model comes back untouched, to the last bit.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from enum import IntEnum
from typing import ClassVar, Literal

from etextile.errors import BadInput
from etextile.mechanics.model import Model


class Stage(IntEnum):
    """When an effect acts; a case's effects are sorted by it, so the order of the list does not matter."""

    LAW = 0
    REST = 1
    NODES = 2
    ELEMENTS = 3
    COUPLING = 4
    SUPPORT = 5
    BODY = 6
    MACHINE = 7


@dataclass(frozen=True)
class Parameter:
    """A number of an effect: usual range [low, high] in `unit` and the value without effect.

    `limits`: what can be at all, where that is more than the usual range; None where the usual range is the physical
    one. A diagnosis searches the usual range, and goes on to the limits when the leading explanation stands at its end.

    `neutral` None: a shape (an onset) that has no neutral value, then `default` must stand in when it is not given.
    A neutral value outside of the range is allowed beside it (a limit of 0 stands for none). `scale`: how to search.
    `coupons_show`: a strain from which on yarns differ; coupons that reach it would show that.
    `proportional`: the size up to which its change grows in proportion, where that is less than the card's example.
    `form`: a form that the mechanism may have, between those at both ends; a diagnosis averages over it.
    `choice`: one of two forms, those at both ends, and nothing between; a diagnosis weighs one against the other.
    """

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    neutral: float | None = 0.0
    default: float | None = None
    scale: Literal["linear", "log"] = "linear"
    coupons_show: bool = False
    limits: tuple[float, float] | None = None
    form: bool = False
    choice: bool = False
    proportional: float | None = None

    @property
    def possible(self) -> tuple[float, float]:
        """The physical limits: `limits`, or the usual range where that is all."""
        return (self.low, self.high) if self.limits is None else self.limits

    def allows(self, value: float) -> bool:
        """Tell whether a value is physically possible or neutral."""
        low, high = self.possible
        return low <= value <= high or value == self.neutral


Channel = Literal["punch_force", "free_edge", "tensile", "strain_field", "clamp_line"]
"""Where a mechanism may show."""


@dataclass(frozen=True)
class Signature:
    """How a channel changes for the card's example: sign of the change, from which displacement on, in words.

    sign: +1, -1, or 0 for a change of either sign or none; `onset_mm` 0 for gradual changes from the start on.
    """

    channel: Channel
    sign: int
    onset_mm: float
    words: str


QUANTITIES = {
    "free_edge": ("warp", "weft", "height"),
    "strain_field": ("strain_warp", "strain_weft"),
    "clamp_line": ("slip",),
}
"""Quantities of every channel that a mechanism may leave undetermined."""


@dataclass(frozen=True)
class Undetermined:
    """What the mechanism leaves open of a quantity: largest standard deviation `size` (channel unit), smooth."""

    channel: Literal["free_edge", "strain_field", "clamp_line"]
    quantity: str
    size: float


@dataclass(frozen=True)
class Example:
    """An effect of ordinary size in the paper's punch test, as computed by `tests/benchmarks/effect_signatures.py`.

    force_percent: change of the punch force at 10, 20, 25, 30 and 40 mm; edge_mm: change of the largest draw-in of the
    free edge there. Quarter of 9 x 16 cells, estimated_mid, no wires.
    """

    parameters: dict[str, float]
    force_percent: tuple[float, ...] = ()
    edge_mm: tuple[float, ...] = ()


@dataclass(frozen=True)
class Card:
    """All that is said about an effect in listings, reports and verdicts.

    `off_axis`: parameters that a diagnosis searches, in this order, where yarns run at an angle to the piece.
    """

    id: str
    mechanism: str
    parameters: tuple[Parameter, ...]
    example: Example
    signature: tuple[Signature, ...] = ()
    confused_with: tuple[str, ...] = ()
    separate: str = ""
    literature: str = ""
    limits: str = field(default="")
    undetermined: tuple[Undetermined, ...] = ()
    off_axis: tuple[str, ...] = ()

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of that name; raises KeyError."""
        return {item.name: item for item in self.parameters}[name]


class Effect(ABC):
    """A mechanism with its parameters; subclasses are frozen dataclasses whose fields are the card's parameters."""

    card: ClassVar[Card]
    stage: ClassVar[Stage] = Stage.ELEMENTS

    @property
    def values(self) -> dict[str, float]:
        """Parameters by name."""
        return {item.name: float(getattr(self, item.name)) for item in self.card.parameters}

    @property
    def is_neutral(self) -> bool:
        """Whether all parameters that have a neutral value are at it."""
        values = self.values
        return all(values[item.name] == item.neutral for item in self.card.parameters if item.neutral is not None)

    def apply(self, model: Model) -> Model:
        """Return the model with this mechanism, or the model itself at the neutral parameters.

        Raises BadInput when the mechanism makes no sense in the model (a punch that is not there).
        """
        changed = model if self.is_neutral else self.transform(model)
        if not isinstance(changed, Model):
            message = (
                f"transform of {self.card.id} returns {type(changed).__name__}, it has to return the changed model"
            )
            raise BadInput.of(message, key="id")
        return changed

    @abstractmethod
    def transform(self, model: Model) -> Model:
        """Return the changed model; `model` itself stays as it is."""
