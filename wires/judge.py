"""The judge: a criterion with its parameters, built once from the case, that says what becomes of wires.

Runs, ensembles, maps, loop sizing and comparisons with observations all ask the same object. From the criterion's
chances given what parts of a garment share it works out probabilities over all scatter, and from these the states
(`wires.chances.WHOLE_BELOW`, `OPEN_FROM`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from etextile.errors import BadInput
from etextile.results.wire_history import WireHistory
from etextile.types import Array, IntArray
from etextile.vocabulary import INTACT, OPEN, PARTIAL, PLASTIC
from wires.chances import OPEN_FROM, WHOLE_BELOW, Chances
from wires.damage import Criterion, FailureResult, JudgedDirectly, WireChances, WovenResult
from wires.dependence import LogGrid, Spread, Survival
from wires.history import first_crossing, running_maximum
from wires.reliability import Reliability, spread_of, survival
from wires.woven import WovenPieces


@dataclass(frozen=True)
class OverSteps:
    """Probabilities over S steps: of loops (S, L), wires (S, W) and any wire of the garment (S,)."""

    loop_failure: Array
    loop_open: Array
    wire_failure: Array
    wire_open: Array
    any_failure: Array
    any_open: Array


@dataclass(frozen=True)
class Judge:
    """A criterion, a value for each of its parameters, and what it cannot know about the calibration."""

    criterion: Criterion
    parameters: Mapping[str, float]
    spread: Spread

    @classmethod
    def of(cls, criterion: Criterion, parameters: Mapping[str, float]) -> Judge:
        """Return the judge for checked parameters (`wires.failure.resolve`)."""
        doubt = getattr(criterion, "doubt", None)
        return cls(
            criterion, dict(parameters), spread_of(parameters, (0.0, 0.0) if doubt is None else doubt(parameters))
        )

    @property
    def strain_kind(self) -> str:
        """Which strain the criterion looks at: `wire`, `fabric`, or that of a criterion of the user's."""
        return str(getattr(self.criterion, "strain_kind", "of the criterion"))

    @property
    def within_garment(self) -> Judge:
        """The judge of one garment whose strength is known: scatter between garments is drawn elsewhere."""
        return replace(self, spread=self.spread.within())

    @property
    def calibrated_here(self) -> Judge:
        """The judge of loops that are those of the calibration: what is not known about them cancels."""
        return replace(self, spread=replace(self.spread, loops=0.0, woven=0.0))

    def verdict(self, history: WireHistory | None) -> FailureResult | None:
        """Return what became of the wires of a run, None of one without wires."""
        return None if history is None else self.judge(history)

    def judge(self, history: WireHistory) -> FailureResult:
        """Return what becomes of loops, woven pieces and wires, step by step, and of the garment at the end."""
        typical = self._evaluated(history)
        grid = self.spread.grid
        loops, woven = self._chances(history, grid)
        layout = history.layout
        pieces = None if woven is None else WovenPieces.of(history)
        broken, opened, share = self._marginal(loops, grid, self.spread.loops)
        state = states(broken, opened, typical.state)
        pieces_result = None if woven is None or pieces is None else self._woven(history, pieces, woven, grid)
        travel = history.displacement_mm
        return replace(
            typical,
            state=state,
            filaments_broken=np.where(state >= PARTIAL, share, 0.0),
            failure_probability=broken[-1],
            open_probability=opened[-1],
            open_mm=first_crossing(travel, opened, OPEN_FROM),
            strain_kind=typical.strain_kind or self.strain_kind,
            woven=pieces_result,
            wires=self._wires(history, loops, woven, pieces, _metal(typical.wire_states, pieces_result), grid),
            reliability=Reliability(
                layout, pieces, _last(loops), None if woven is None else _last(woven), grid, self.spread
            ),
        )

    def over_steps(self, history: WireHistory) -> OverSteps:
        """Return the probabilities after each step, for ensembles."""
        grid, copies = self.spread.grid, history.layout.wire_copies
        loops, woven = self._chances(history, grid)
        pieces = None if woven is None else WovenPieces.of(history)
        wires, some = [], []
        for what in ("broken", "opened"):
            of_loops, of_woven = _survivals(history, loops, woven, pieces, what)
            found = [Survival(of_loops[:, k], of_woven[:, k], grid, self.spread) for k in range(history.n_steps)]
            wires.append(np.stack([item.of_wires() for item in found]))
            some.append(np.array([item.any_wire(copies) for item in found]))
        broken, opened, _ = self._marginal(loops, grid, self.spread.loops)
        return OverSteps(broken, opened, wires[0], wires[1], some[0], some[1])

    def _evaluated(self, history: WireHistory) -> FailureResult:
        """Return what the criterion says of a typical wire; raises BadInput for one of a user that says nothing."""
        found = self.criterion.evaluate(history, self.parameters)
        if not isinstance(found, FailureResult):
            what = f"evaluate of {self.criterion.name} returns {type(found).__name__}"
            raise BadInput.of(f"{what}, it has to return what et.bundle_damage returns", key="failure.criterion")
        return found

    def _chances(self, history: WireHistory, grid: LogGrid) -> tuple[Chances, Chances | None]:
        """Return the chances of loops and woven pieces over the steps, given the grid's factors."""
        if isinstance(self.criterion, JudgedDirectly):
            return self.criterion.chances(history, self.parameters, grid.factors)
        found = [
            [self._evaluated(_weaker(history, step, factor)) for step in range(history.n_steps)]
            for factor in grid.factors
        ]

        def over(name: str) -> Array:
            return np.array([[getattr(item, name) for item in row] for row in found], dtype=float)

        return Chances(over("failure_probability"), over("open_probability"), over("loop_broken")), None

    def _marginal(self, chances: Chances, grid: LogGrid, doubt: float) -> tuple[Array, Array, Array]:
        """Return the chances (S, n) over all scatter of one part."""
        weight = grid.full(float(np.sqrt(self.spread.garment**2 + self.spread.wire**2 + doubt**2)))
        parts = (chances.broken, chances.opened, chances.share)
        broken, opened, share = (np.clip(np.tensordot(weight, part, 1), 0.0, 1.0) for part in parts)
        return broken, opened, share

    def _woven(self, history: WireHistory, pieces: WovenPieces, chances: Chances, grid: LogGrid) -> WovenResult:
        """Return the result of the pieces in the weave."""
        broken, opened, _ = self._marginal(chances, grid, self.spread.woven)
        peak = running_maximum(pieces.peak(history.element_strain))
        plastic = np.where(peak >= self.parameters.get("yield_strain", np.inf), PLASTIC, INTACT)
        return WovenResult(
            pieces=pieces,
            state=states(broken, opened, plastic),
            max_strain=peak[-1],
            failure_probability=broken[-1],
            open_probability=opened[-1],
            first_failure_mm=first_crossing(history.displacement_mm, chances.broken[grid.half], 0.5),
        )

    def _wires(
        self,
        history: WireHistory,
        loops: Chances,
        woven: Chances | None,
        pieces: WovenPieces | None,
        typical: IntArray,
        grid: LogGrid,
    ) -> WireChances:
        """Return states and probabilities of whole wires."""
        broken, opened = (
            np.stack(
                [
                    Survival(of_loops[:, step], of_woven[:, step], grid, self.spread).of_wires()
                    for step in range(history.n_steps)
                ]
            )
            for of_loops, of_woven in (_survivals(history, loops, woven, pieces, what) for what in ("broken", "opened"))
        )
        return WireChances(states(broken, opened, typical), broken[-1], opened[-1])


def states(broken: Array, opened: Array, typical: IntArray) -> IntArray:
    """Return the states that follow from probabilities; `typical` tells plastic from intact below the limit."""
    whole = np.where(typical >= PLASTIC, PLASTIC, INTACT)
    return np.where(opened >= OPEN_FROM, OPEN, np.where(broken >= WHOLE_BELOW, PARTIAL, whole))


def _metal(loops: IntArray, woven: WovenResult | None) -> IntArray:
    """Return the states (S, W) of the metal of typical wires, the worst of their loops and, where judged, the weave."""
    worst = loops.copy()
    if woven is not None:
        np.maximum.at(worst.T, woven.pieces.wire, np.minimum(woven.state, PLASTIC).T)
    return worst


def _survivals(
    history: WireHistory, loops: Chances, woven: Chances | None, pieces: WovenPieces | None, what: str
) -> tuple[Array, Array]:
    """Return the survival (G, S, W) of the loops and of the woven part of each wire."""
    layout = history.layout
    of_loops = survival(getattr(loops, what), layout.loop_wire, layout.loop_copies, layout.n_wires)
    if woven is None or pieces is None:
        return of_loops, np.ones_like(of_loops)
    return of_loops, survival(getattr(woven, what), pieces.wire, pieces.copies, layout.n_wires)


def _last(chances: Chances) -> Chances:
    return Chances(chances.broken[:, -1:], chances.opened[:, -1:], chances.share[:, -1:])


def _weaker(history: WireHistory, step: int, factor: float) -> WireHistory:
    """Return the history up to a step with strains as a wire of that strength feels them."""
    parts: dict[str, Any] = {
        name: getattr(history, name)[: step + 1] / factor for name in ("span_strain", "wire_strain", "element_strain")
    }
    return replace(history, displacement_mm=history.displacement_mm[: step + 1], **parts)
