"""What is diagnosed, and what has been run and prepared around it before any effect is looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.observe import Record
from etextile.diagnose.data.points import Points
from etextile.diagnose.infer.whitened import LatticeDoubt, Workbench
from etextile.diagnose.predict.parameters import BaseParameters
from etextile.diagnose.predict.run_tables import BaseRuns, Candidate, Laws, Levels
from etextile.diagnose.predict.table import EffectTable, ParameterGrid
from etextile.types import Array


@dataclass(frozen=True)
class Setting:
    """What is diagnosed: measurements, base parameters (coupons or prior), the case's own laws, coarsening, effects."""

    measured: Measurements
    base: BaseParameters
    case_laws: Laws
    coarsening: float
    candidates: tuple[Candidate, ...]
    seed: int = 0

    @property
    def confused(self) -> dict[str, tuple[str, ...]]:
        """What every effect is confused with, by its card."""
        return {item.card.id: item.card.confused_with for item in self.candidates}


@dataclass(frozen=True)
class Prepared:
    """Runs and tables around one measurement; `jacobian` (n, 9): change of thinned points per base parameter.

    `plans`: the whole grid of every effect; a table stands on few of its nodes until the effect comes into question.
    """

    levels: Levels
    points: Points
    runs: BaseRuns
    lattice: LatticeDoubt
    bench: Workbench
    tables: dict[str, EffectTable]
    anchor: Laws
    jacobian: Array
    slope_runs: tuple[Record, ...]
    plans: Mapping[str, ParameterGrid]

    @property
    def few(self) -> frozenset[str]:
        """Effects whose tables stand on few nodes."""
        return frozenset(name for name, table in self.tables.items() if table.grid.shape != self.plans[name].shape)
