"""Wires of different makes in one garment: each is judged by the same criterion with the numbers of its own filaments.

What all share (the calibration, scatter between garments) stays one; filaments, their diameter, elongation and scatter
are those of the wire. Wires are known by their names, so that any portion of the specimen is judged alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.types import Array, BoolArray
from wires.chances import Chances
from wires.damage import Criterion, CriterionParameter, FailureResult, JudgedDirectly
from wires.layout import WireLayout
from wires.woven import WovenPieces


@dataclass(frozen=True)
class Make:
    """Wires of a make of their own, by name, and the criterion's numbers that are theirs."""

    wires: frozenset[str]
    parameters: Mapping[str, float]

    def among(self, layout: WireLayout) -> BoolArray:
        """Return which wires (W,) of a layout are of this make."""
        return np.array([name in self.wires for name in layout.names], dtype=bool)


@dataclass(frozen=True)
class ByMake:
    """A criterion with numbers of their own for some wires; the others have those that the judge holds."""

    base: Criterion
    makes: tuple[Make, ...]

    @property
    def name(self) -> str:
        """Name of the criterion that is applied."""
        return self.base.name

    @property
    def summary(self) -> str:
        """The criterion in a line."""
        return self.base.summary

    @property
    def parameters(self) -> tuple[CriterionParameter, ...]:
        """The numbers of the criterion."""
        return self.base.parameters

    @property
    def strain_kind(self) -> str:
        """Which strain the criterion looks at."""
        return str(getattr(self.base, "strain_kind", "of the criterion"))

    @property
    def limit(self) -> Callable[[Mapping[str, float]], float] | None:
        """The strain at which a typical loop of the common make breaks, where the criterion has one."""
        return getattr(self.base, "limit", None)

    def doubt(self, parameters: Mapping[str, float]) -> tuple[float, float]:
        """Return the doubt about the calibration, which is one for all makes."""
        own = getattr(self.base, "doubt", None)
        return (0.0, 0.0) if own is None else own(parameters)

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage, each wire by its own numbers."""
        layout = history.layout
        found = self.base.evaluate(history, parameters)
        filaments = np.full(layout.n_wires, parameters.get("filaments", 1.0))
        for make in self.makes:
            other = self.base.evaluate(history, {**parameters, **make.parameters})
            filaments[make.among(layout)] = other.parameters.get("filaments", 1.0)
            found = _merged(found, other, make.among(layout)[layout.loop_wire])
        return replace(found, filaments=filaments)


@dataclass(frozen=True)
class ByMakeDirectly(ByMake):
    """The same for a criterion that gives probabilities over all steps itself."""

    def chances(
        self, history: WireHistory, parameters: Mapping[str, float], factors: Array
    ) -> tuple[Chances, Chances | None]:
        """Return the chances of loops and woven pieces, each wire by its own numbers."""
        if not isinstance(self.base, JudgedDirectly):
            raise TypeError(f"{self.name} gives no probabilities itself")
        layout = history.layout
        loops, woven = self.base.chances(history, parameters, factors)
        pieces = None if woven is None else WovenPieces.of(history)
        for make in self.makes:
            own_loops, own_woven = self.base.chances(history, {**parameters, **make.parameters}, factors)
            among = make.among(layout)
            loops = _chosen(loops, own_loops, among[layout.loop_wire])
            if woven is not None and own_woven is not None and pieces is not None:
                woven = _chosen(woven, own_woven, among[pieces.wire])
        return loops, woven


def by_make(criterion: Criterion, makes: tuple[Make, ...]) -> Criterion:
    """Return the criterion with numbers of their own for some wires; itself where there are none."""
    if not makes:
        return criterion
    return (ByMakeDirectly if isinstance(criterion, JudgedDirectly) else ByMake)(criterion, makes)


def _chosen(common: Chances, own: Chances, chosen: BoolArray) -> Chances:
    return Chances(
        *(np.where(chosen, getattr(own, name), getattr(common, name)) for name in ("broken", "opened", "share"))
    )


def _merged(common: FailureResult, own: FailureResult, chosen: BoolArray) -> FailureResult:
    """Return results whose chosen loops (L,) are those of `own`."""
    names = ("state", "filaments_broken", "first_failure_mm", "max_strain", "failure_probability", "open_probability")
    found = {name: np.where(chosen, getattr(own, name), getattr(common, name)) for name in names}
    if common.exit_strain is not None and own.exit_strain is not None:
        found["exit_strain"] = np.where(chosen, own.exit_strain, common.exit_strain)
    if common.broken_counts is not None and own.broken_counts is not None:
        size = max(common.broken_counts.shape[1], own.broken_counts.shape[1])
        counts = [
            np.pad(item, ((0, 0), (0, size - item.shape[1]))) for item in (own.broken_counts, common.broken_counts)
        ]
        found["broken_counts"] = np.where(chosen[:, None], *counts)
    return replace(common, **found)
