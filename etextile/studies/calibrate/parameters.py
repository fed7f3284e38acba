"""What `--free` names: parameters of the fabric's laws, of the case's effects, and where the measured centre lies.

Unknowns of the search are of order one: logarithms of E, H and sigma_y0 and n, shares of an effect's range, cells of
the registration. Where H and n of a family are both free, ln H is replaced by the logarithm of the stress at a strain
inside the data, which the curve fixes and n hardly changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np

from etextile.errors import BadInput, Problem, nearest
from etextile.identify.calibration import Unknowns
from etextile.types import Array
from etextile.vocabulary import FABRIC_FAMILIES
from loadcases.fabric import Fabric, Family
from loadcases.measured import Measured
from loadcases.schema import Case
from loadcases.schema_parts import Effect


LAW = ("E", "sigma_y0", "H", "n")
CENTRE = ("measured.centre.x", "measured.centre.y")
WIDE, SHAPE, SHIFT = 3.0, 0.5, 10.0
"""Spread of what is allowed before any data: of logarithms of moduli, of ln n, of the centre (mm)."""
TENTH, LEAST = 0.1, 1e-6
"""Shares of the usual range: where a parameter starts that the case has not, the least one that is searched."""
SHARE = 0.6
"""Place of the reference strain within the strain range of a family."""


@dataclass(frozen=True)
class Free:
    """One free parameter: its key; `family` and `name` of a law, or effect and parameter, or the axis of the centre."""

    key: str
    kind: str
    family: str
    name: str


@dataclass(frozen=True)
class Change:
    """A trial: fabric, effects by (id, parameter), and the centre of the measured coordinates, mm."""

    fabric: Fabric
    effects: Mapping[tuple[str, str], float]
    centre: tuple[float, float]


def parse(keys: Sequence[str], case: Case, *, with_field: bool) -> tuple[Free, ...]:
    """Return the free parameters; raises BadInput with all keys that name none, what is allowed, and the nearest."""
    known = {f"fabric.{family}.{name}": Free(f"fabric.{family}.{name}", "law", family, name)
             for family in FABRIC_FAMILIES for name in LAW}  # fmt: skip
    for effect in case.effects:
        for name, value in _numbers(effect).items():
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                known[f"effects.{effect.id}.{name}"] = Free(f"effects.{effect.id}.{name}", "effect", effect.id, name)
    if with_field:
        known |= {key: Free(key, "centre", "", key[-1]) for key in CENTRE}
    problems = [
        Problem(f"no such parameter (got {key!r}), known are {', '.join(known)}{nearest(key, known)}", key="--free")
        for key in keys
        if key not in known
    ]
    problems += [Problem(f"named twice (got {key!r})", key="--free") for key in {k for k in keys if keys.count(k) > 1}]
    if not keys:
        problems.append(Problem(f"no parameter to free, known are {', '.join(known)}", key="--free"))
    if problems:
        raise BadInput(problems)
    return tuple(known[key] for key in keys)


def _numbers(effect: Effect) -> dict[str, Any]:
    """Return the parameters of an effect of the case, with the defaults of those that are not given."""
    from etextile.effects.registry import EFFECTS

    kind = EFFECTS.get(effect.id)
    usual = {} if kind is None else {part.name: part.default for part in kind.card.parameters}
    return {**{name: value for name, value in usual.items() if value is not None}, **effect.parameters}


def _logarithmic(item: Free) -> bool:
    """Tell whether an effect's parameter is searched by its logarithm."""
    from etextile.effects.registry import EFFECTS

    part = EFFECTS[item.family].card.parameter(item.name)
    return part.low >= 0.0 and (part.scale == "log" or part.limits is not None)


@dataclass(frozen=True)
class Space:
    """The unknowns of a search around a case and its fabric."""

    free: tuple[Free, ...]
    case: Case
    fabric: Fabric
    centre: tuple[float, float]
    prior: bool = True

    def unknowns(self) -> Unknowns:
        """Return start, steps, what is known before and bounds."""
        rows = [self._row(item) for item in self.free]
        start, step, known, spread, low, high = (np.array(column) for column in zip(*rows, strict=True))
        return Unknowns(tuple(item.key for item in self.free), start, step, known, spread, low, high)

    def _row(self, item: Free) -> tuple[float, float, float, float, float, float]:
        """Return start, step, mean and spread of what is known, and bounds of one unknown."""
        if item.kind == "centre":
            value = self.centre["xy".index(item.name)]
            return value, 0.5, value, SHIFT, value - 3.0 * SHIFT, value + 3.0 * SHIFT
        if item.kind == "effect":
            value, low, high, logarithmic = self._effect(item)
            if logarithmic:
                return log(value), 0.02, log(value), WIDE, log(low), log(high)
            width = high - low
            return value, 0.02 * width, value, width, low, high
        family, value = getattr(self.fabric, item.family), self._law(item)
        start = float(np.log(value))
        if item.name == "H":
            start += family.n.value * np.log(self.reference(family))
        spread = SHAPE if item.name == "n" else WIDE
        stated = self.stated(item)
        spread = min(spread, stated) if stated is not None else spread
        wide = (1.5, 1.5) if item.name == "n" else (7.0, 7.0)
        return start, 0.02, start, spread, start - wide[0], start + wide[1]

    def stated(self, item: Free) -> float | None:
        """Return the relative standard deviation that the fabric states for a parameter, None without one."""
        number: Measured = getattr(getattr(self.fabric, item.family), item.name)
        known = self.prior and number.std is not None and number.std > 0.0 and not number.estimated
        return float(number.std) / number.value if known and number.std is not None else None

    def _law(self, item: Free) -> float:
        value = float(getattr(getattr(self.fabric, item.family), item.name).value)
        if value <= 0.0:
            raise BadInput.of(f"starts from {value:g}, give the fabric a positive value to start from", key=item.key)
        return value

    def _effect(self, item: Free) -> tuple[float, float, float, bool]:
        """Return an effect's parameter in the case, its bounds, and whether it is searched by its logarithm.

        So are those that are never negative and may be far beyond their usual range. Where one of them starts from
        nothing, an ordinary size is taken.
        """
        from etextile.effects.registry import EFFECTS

        effect = next(effect for effect in self.case.effects if effect.id == item.family)
        kind = EFFECTS.get(item.family)
        known = {} if kind is None else {part.name: part for part in kind.card.parameters}
        if kind is None or item.name not in known:
            raise BadInput.of("only effects of the library have bounds to search in", key=item.key)
        value, part = float(_numbers(effect)[item.name]), known[item.name]
        low, high = part.possible
        if not _logarithmic(item):
            return value, part.low, part.high, False
        value = value or kind.card.example.parameters.get(item.name) or TENTH * part.high
        return value, max(low, LEAST * part.high), high, True

    @staticmethod
    def reference(family: Family) -> float:
        """Return the plastic strain at which the stress of a family stands for H."""
        return float(SHARE * np.log1p(family.strain_range[1]))

    def change(self, y: Array) -> Change:
        """Return what a point of the search stands for."""
        values = self.values(y)
        families: dict[str, dict[str, Measured]] = {}
        effects: dict[tuple[str, str], float] = {}
        centre = list(self.centre)
        for item, value in zip(self.free, values, strict=True):
            if item.kind == "centre":
                centre["xy".index(item.name)] = float(value)
            elif item.kind == "effect":
                effects[item.family, item.name] = float(value)
            else:
                families.setdefault(item.family, {})[item.name] = Measured(value=float(value))
        update = {name: getattr(self.fabric, name).model_copy(update=laws) for name, laws in families.items()}
        return Change(self.fabric.model_copy(update=update), effects, (centre[0], centre[1]))

    def values(self, y: Array) -> Array:
        """Return the parameters in their own units (p,)."""
        own = {item.key: float(value) for item, value in zip(self.free, y, strict=True)}
        found = []
        for item in self.free:
            value = own[item.key]
            if item.kind == "effect" and _logarithmic(item):
                value = float(np.exp(value))
            if item.kind == "law":
                if item.name == "H":
                    family = getattr(self.fabric, item.family)
                    log_n = own.get(f"fabric.{item.family}.n")
                    n = family.n.value if log_n is None else float(np.exp(log_n))
                    value -= n * np.log(self.reference(family))
                value = float(np.exp(value))
            found.append(value)
        return np.array(found)

    def derivatives(self, y: Array) -> Array:
        """Return the derivatives (p, p) of the parameters by the unknowns."""
        step = 1e-6
        columns = [(self.values(y + step * row) - self.values(y - step * row)) / (2.0 * step) for row in np.eye(len(y))]
        return np.stack(columns, axis=1)
