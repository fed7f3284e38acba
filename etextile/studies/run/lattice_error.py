"""How much of an answer is the lattice: the same case on two other coarsenings, and what changes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.solve.path import advance
from etextile.types import Array
from loadcases.build import Built, build, settings
from loadcases.schema import Case
from wires.strain import wire_strains


FACTORS = (1.5, 1.0 / 1.5)
"""Coarser and finer lattice, chosen so that their lines do not fall on those of the run."""


@dataclass(frozen=True)
class LatticeSolution:
    """One lattice: cells, force at the end N, greatest span strain of every wire (W,)."""

    coarsening: float
    cells: tuple[int, int]
    force: float
    wires: Array


@dataclass(frozen=True)
class LatticeError:
    """The run's lattice (first) and two others; `error` is the change of the force to the finest, as a share."""

    solutions: tuple[LatticeSolution, ...]
    trouble: str = ""

    @property
    def error(self) -> float:
        """Change of the end force from the run's lattice to the finest one; nan when that one broke off."""
        if self.trouble:
            return float("nan")
        own, finest = self.solutions[0], min(self.solutions, key=lambda item: item.coarsening)
        other = finest if finest is not own else self.solutions[1]
        return abs(other.force - own.force) / abs(own.force)

    @property
    def wire_change(self) -> Array:
        """(W,) largest change of a wire's greatest span strain between the run's lattice and the others."""
        own = self.solutions[0].wires
        changes = [np.abs(other.wires - own) for other in self.solutions[1:]]
        return np.max(changes, axis=0) if changes else np.zeros_like(own)

    def as_dict(self) -> dict[str, Any]:
        """Return the block `lattice_error` of report.json."""
        return {
            "coarsening": [item.coarsening for item in self.solutions],
            "cells": [list(item.cells) for item in self.solutions],
            "force_N": [item.force for item in self.solutions],
            "force_change": self.error,
            "wire_strain_change": self.wire_change.tolist(),
            "trouble": self.trouble,
        }


def estimate(case: Case, *, force: float, wires: Array) -> LatticeError:
    """Repeat a case on two other lattices; `force` and `wires` (W,) are the run's own end values."""
    own = build_at(case, case.fabric.coarsening)
    found = [LatticeSolution(case.fabric.coarsening, own.model.lattice.cells, force, wires)]
    factors = FACTORS if case.fabric.coarsening * FACTORS[1] >= 1.0 else (FACTORS[0], FACTORS[0] ** 2)
    for factor in factors:
        coarsening = case.fabric.coarsening * factor
        try:
            found.append(_solve(build_at(case, coarsening), coarsening))
        except NoEquilibrium as error:
            return LatticeError(tuple(found), f"at coarsening {coarsening:.4g}: {error}")
    return LatticeError(tuple(found))


def build_at(case: Case, coarsening: float) -> Built:
    """Return the case built at another coarsening."""
    return build(case.model_copy(update={"fabric": case.fabric.model_copy(update={"coarsening": coarsening})}))


def _solve(built: Built, coarsening: float) -> LatticeSolution:
    wires = built.wires
    greatest = np.zeros(0 if wires is None else wires.layout.n_wires)
    force = 0.0
    for increment in advance(built.model, settings(built.case)):
        force = increment.punch_force_N
        if wires is not None:
            strains = wire_strains(wires, built.model, increment)
            np.maximum.at(greatest, wires.layout.loop_wire, strains["span_strain"])
    return LatticeSolution(coarsening, built.model.lattice.cells, force, greatest)
