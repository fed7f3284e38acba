"""Predictions behind a diagnosis: which runs are needed, on which lattices, and the tables made of them.

All effects are simulated once on the case's own lattice around one anchor fabric, so data sets of one case share the
runs; the base itself is predicted for the fabric at hand, on two finer lattices that do not nest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.data.points import Points
from etextile.diagnose.infer.whitened import LatticeDoubt, lattice_error
from etextile.diagnose.predict.bent import STATIONS
from etextile.diagnose.predict.parameters import BaseParameters, steps
from etextile.diagnose.predict.simulate import EffectSpec, Law, Request
from etextile.diagnose.predict.table import EffectTable, ParameterGrid, axes_of, each_with_its_own, tabulate
from etextile.effects.base import Card
from etextile.types import Array
from etextile.vocabulary import FORCES, PULL


Laws = tuple[Law, Law, Law]
# Finer lattices of the numerics gate: the case's coarsening over these.
GATE = (2.2, 3.1)
# Largest distance from case to coupons, per direction (ln E, ln s, n), up to which tables are made around the case.
NEAR = np.tile(np.array([0.5, 0.10, 0.10]), 3)
# Share of the coupons' largest strain below which a yarn law that changes would have shown in them.
COUPON_SHARE = 0.7
# Spacing of output steps, mm.
SPACING = 1.7
# Output steps of a load that is no displacement.
STEPS = 20
# A pulled clamp is simulated so much further than it was measured: its preload has taken a part of the travel.
PULLED = 1.1


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing; `file`: a user's Python file, empty for the library."""

    card: Card
    file: str = ""

    def spec(self, parameters: Mapping[str, float]) -> EffectSpec:
        """Return the effect at parameters for a request."""
        return EffectSpec.of(self.card.id, parameters, self.file)


def specs_at(tables: Sequence[EffectTable], candidates: Sequence[Candidate], point: Array) -> tuple[EffectSpec, ...]:
    """Return the effects of a hypothesis at a point (d,) of their tables' coordinates."""
    known = {item.card.id: item for item in candidates}
    return tuple(known[table.id].spec(table.grid.parameters(own)) for table, own in each_with_its_own(tables, point))


@dataclass(frozen=True)
class Levels:
    """Lattices of the runs: coarsening of tables and of the gate; travel (mm, or bar) and number of steps.

    `back` (mm): where the way back ends, when that is what is wanted; `stations`: loads at which it is measured, all
    of them output steps; `bent`: a bending test, total in 1/m.
    """

    table: float
    gate: tuple[float, float]
    total: float
    steps: int
    back: float | None = None
    stations: tuple[float, ...] = ()
    bent: bool = False
    solves: int | None = None

    @classmethod
    def for_points(cls, coarsening: float, points: Points, *, back: float | None = None) -> Levels:
        """Return the levels for all that was measured of a case; a pulled clamp is run beyond what its preload took."""
        reach, stations = float(points.displacement.max()), points.stations
        if points.unit == "mm":
            return cls.of(coarsening, (PULLED if points.of(PULL).any() else 1.0) * reach, back=back)
        gate = (coarsening / GATE[0], coarsening / GATE[1])
        if points.unit == "1/m":
            return cls(coarsening, gate, reach, STATIONS, bent=True)
        return cls(coarsening, gate, reach, len(stations) or STEPS, stations=stations)

    @classmethod
    def of(cls, coarsening: float, reach: float, *, back: float | None = None, unit: str = "mm") -> Levels:
        """Return the levels for a case with this coarsening and measurements up to `reach` mm, or from there back."""
        if unit != "mm":
            return cls(coarsening, (coarsening / GATE[0], coarsening / GATE[1]), reach, STEPS)
        total = float(np.ceil(reach * 4.0) / 4.0) if back is None else reach
        gate = (coarsening / GATE[0], coarsening / GATE[1])
        return cls(coarsening, gate, total, max(12, int(np.ceil(total / SPACING))), back)

    def request(
        self, laws: Laws, effects: Sequence[EffectSpec] = (), *, coarsening: float | None = None, finer: int = 1
    ) -> Request:
        """Return the request of one run; `finer` divides the steps."""
        level = coarsening or self.table
        steps = self.steps * finer
        return Request(
            laws, tuple(effects), level, self.total, steps, back=self.back, stations=self._stations(finer),
            bent=self.bent, solves=self.solves if effects else None,
        )  # fmt: skip

    def _stations(self, finer: int) -> tuple[float, ...]:
        """Return the stations, with `finer` - 1 more before each."""
        before = (0.0, *self.stations)
        shares = np.arange(1, finer + 1) / finer
        return tuple(float(a + share * (b - a)) for a, b in pairwise(before) for share in shares)


@dataclass(frozen=True)
class BaseRuns:
    """Runs of the base: at the anchor and at the fabric at hand on the table's lattice, and on both gate lattices."""

    anchor: Record
    coarse: Record
    half_step: Record
    fine: Record
    finer: Record

    def lattice_error(self, points: Points) -> LatticeDoubt:
        """Return the base at points with what the lattice leaves open."""
        runs = (self.coarse, self.fine, self.finer)
        sizes = [run.cell for run in runs]
        return lattice_error([observe(run, points) for run in runs], sizes, observe(self.half_step, points))


def anchor_laws(base: BaseParameters, case_laws: Laws) -> Laws:
    """Return the fabric around which tables are made: the case's, or the coupons' where that is far from it."""
    near = bool(np.all(np.abs(base.shift_from(case_laws)) <= NEAR))
    return case_laws if near else base.laws


def base_requests(levels: Levels, laws: Laws, anchor: Laws) -> list[Request]:
    """Return the runs of `BaseRuns`, in its order."""
    coarse = [levels.request(anchor), levels.request(laws), levels.request(laws, finer=2)]
    return coarse + [levels.request(laws, coarsening=level) for level in levels.gate]


def slope_requests(levels: Levels, base: BaseParameters, anchor: Laws) -> list[Request]:
    """Return the runs for the derivatives by the nine base parameters."""
    around = BaseParameters(anchor, base.covariance, base.reference, base.ranges, base.sources)
    return [levels.request(around.moved(row)) for row in np.diag(steps())]


def slopes_of(anchor: Array, moved: Sequence[Array]) -> Array:
    """Return the derivatives (n, 9) of all points by the nine base parameters."""
    return np.stack([(run - anchor) / step for run, step in zip(moved, steps(), strict=True)], axis=1)


def turned_request(levels: Levels, laws: Laws) -> Request:
    """Return the run of a specimen that is clamped along its weft."""
    warp, weft, diagonal = laws
    return levels.request((weft, warp, diagonal))


def freedom(base: BaseParameters, anchor: Array, moved: Sequence[Array]) -> Array:
    """Return columns (n, 9): change of all points for one standard deviation along the principal axes of the prior."""
    jacobian = slopes_of(anchor, moved)
    values, vectors = np.linalg.eigh(base.covariance)
    return np.asarray(jacobian @ (vectors * np.sqrt(np.maximum(values, 0.0))))


def grids(candidates: Sequence[Candidate], *, yarns_seen_to: float = 0.0) -> dict[str, ParameterGrid]:
    """Return the grid of every candidate; onsets that coupons up to `yarns_seen_to` would have shown are left out."""
    cards = [_unseen(item.card, round(COUPON_SHARE * yarns_seen_to, 2)) for item in candidates]
    return {card.id: ParameterGrid(card, axes_of(card)) for card in cards}


def _unseen(card: Card, low: float) -> Card:
    """Return the card with the range of onsets that begins at `low`, if it lies within."""
    parameters = tuple(
        replace(item, low=max(item.low, low)) if item.coupons_show and low < item.high else item
        for item in card.parameters
    )
    return replace(card, parameters=parameters)


def table_requests(levels: Levels, candidate: Candidate, grid: ParameterGrid, anchor: Laws) -> list[Request]:
    """Return the runs behind one table, in the order of the grid's nodes."""
    return [levels.request(anchor, [candidate.spec(parameters)]) for _, parameters in grid.nodes()]


def doubt_requests(
    levels: Levels, candidates: Sequence[Candidate], plans: Mapping[str, ParameterGrid], anchor: Laws
) -> list[Request]:
    """Return the runs on a finer lattice that show how far tables depend on theirs: the anchor, then every effect."""
    specs = []
    for item in candidates:
        grid = plans[item.card.id]
        parameters = grid.parameters([axis.nodes[i] for axis, i in zip(grid.axes, grid.ordinary, strict=True)])
        specs.append([item.spec(parameters)])
    return [levels.request(anchor, effects, coarsening=levels.gate[0]) for effects in ([], *specs)]


def change(points: Points, run: Array, reference: Array, base: Array) -> Array:
    """Return the change (n,) by an effect, carried over to another base: forces in proportion, motions as they are."""
    force = np.any([points.of(name) for name in FORCES], axis=0)
    ratio = np.where(force & (np.abs(reference) > 0.0), base / np.where(reference == 0.0, 1.0, reference), 1.0)
    return np.asarray((run - reference) * np.clip(ratio, 0.8, 1.25))


def make_table(
    grid: ParameterGrid,
    runs: Sequence[Record],
    points: Points,
    *,
    anchor: Array,
    base: Array,
    thin: object,
    tolerance: Array,
) -> EffectTable:
    """Return the table of one effect on thinned points from its runs."""
    curves = {}
    for (index, _), run in zip(grid.nodes(), runs, strict=True):
        curves[index] = thin.average(change(points, observe(run, points), anchor, base))  # type: ignore[attr-defined]
    return tabulate(grid, curves, tolerance)
