"""The limit of ever finer lattices: the case on three of them, each half as coarse, and where their answers go.

A smooth answer of a lattice with cells of the size h is f + c h^2, so two lattices give the limit f and a third one
tells whether they are in the range where that holds: its differences fall by (h0^2 - h1^2) / (h1^2 - h2^2), which is 4
for halved cells (L. F. Richardson, Phil. Trans. A 210 (1911) 307; P. J. Roache, J. Fluids Eng. 116 (1994) 405). Where
they do not, no limit is given but the reason. The doubt of a limit is the larger of its change from the coarser two
lattices to the finer two and a quarter of what was extrapolated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.results.wire_history import WireHistory
from etextile.solve.path import Increment, advance
from etextile.studies.run.lattice_error import build_at
from etextile.types import Array, IntArray
from etextile.vocabulary import STATES
from loadcases.build import settings
from loadcases.schema import Case
from wires.judge import Judge
from wires.strain import wire_strains


LEAST_ORDER, MOST_ORDER = 1.5, 2.5
"""The differences of the force curve fall as a power of h between these."""
BEARING = 0.1
"""Share of the largest force from which a force counts in that: before, single yarns turn taut."""
MISFIT = 0.25
"""How far the differences may be from those that are due, as a share of them."""
LEAST_STRAIN_ORDER, ALIKE = 1.0, 0.5
"""Least power of h for the loops' greatest strains, and least correlation of their differences: where a loop begins and
ends within a cell is another thing on each lattice, so that they fall less regularly."""
SETTLED = 1e-3
"""Difference of the two finest lattices, as a share of the value, below which there is no order to speak of."""
CORRECTION = 0.25
"""Share of what was extrapolated that a limit is doubted by at least."""


@dataclass(frozen=True)
class Level:
    """One lattice: cells along warp and weft, their size h, force (S,) N, span and wire strains of the loops (S, L)."""

    cells: tuple[int, int]
    size: float
    force: Array
    span: Array
    wire: Array


@dataclass(frozen=True)
class Limit:
    """Values at the limit (any shape), by how much they may be off, and the power of h their differences fall by."""

    values: Array
    doubt: Array
    order: float


@dataclass(frozen=True)
class LatticeExtrapolation:
    """Three lattices and where they lead; `reason` says why they lead nowhere, then there is nothing else."""

    levels: tuple[Level, ...]
    reason: str = ""
    force: Limit | None = None
    span: Limit | None = None
    wire: Limit | None = None
    states: tuple[IntArray, IntArray, IntArray] | None = None
    """States of the loops (L,) with strains lower by their doubt, at the limit, higher by their doubt."""


def richardson(values: list[Array], sizes: list[float]) -> Limit:
    """Return the limit of values on three lattices with cells of these sizes, coarsest first."""
    squares = np.square(sizes)
    coarse, fine = (
        values[k + 1] + (values[k + 1] - values[k]) * squares[k + 1] / (squares[k] - squares[k + 1]) for k in (0, 1)
    )
    doubt = np.maximum(np.abs(fine - coarse), CORRECTION * np.abs(fine - values[2]))
    first, second = (math.sqrt(float(np.square(values[k + 1] - values[k]).sum())) for k in (0, 1))
    expected = (squares[0] - squares[1]) / (squares[1] - squares[2])
    order = 2.0 * math.log(first / second) / math.log(expected) if first > 0.0 and second > 0.0 else math.nan
    return Limit(fine, doubt, order)


def extrapolate_case(
    case: Case, own: Level, judge: Judge | None, *, watch: Callable[[Increment], None]
) -> LatticeExtrapolation:
    """Run a case on lattices half and a quarter as coarse as its `own` and return the limit, or why there is none."""
    levels, history = [own], None
    for factor in (0.5, 0.25):
        try:
            level, history = solve_at(case, case.fabric.coarsening * factor, watch)
        except NoEquilibrium as error:
            return LatticeExtrapolation(
                tuple(levels), f"no equilibrium at coarsening {case.fabric.coarsening * factor:.4g}: {error}"
            )
        levels.append(level)
    return limit_of(levels, judge, history)


def limit_of(levels: list[Level], judge: Judge | None, history: WireHistory | None) -> LatticeExtrapolation:
    """Return the limit of three lattices; `history` is that of the finest one, whose woven pieces are judged as is."""
    sizes = [level.size for level in levels]
    if len({level.span.shape for level in levels}) > 1 or len({level.force.shape for level in levels}) > 1:
        return LatticeExtrapolation(tuple(levels), "the lattices do not have the same loops and steps")
    force = richardson([level.force for level in levels], sizes)
    greatest = [level.span.max(axis=0, initial=0.0) for level in levels]
    strains = richardson(greatest, sizes)
    bearing = np.abs(levels[-1].force) >= BEARING * np.abs(levels[-1].force).max(initial=0.0)
    curve = [level.force[bearing] for level in levels]
    order = richardson(curve, sizes).order
    reason = _off_force(curve, sizes, order) or _off_strain(greatest, strains.order)
    if reason:
        return LatticeExtrapolation(tuple(levels), reason)
    span = richardson([level.span for level in levels], sizes)
    wire = _of_wires([level.wire for level in levels], levels[-1], span, sizes)
    force = replace(force, order=order)
    found = LatticeExtrapolation(tuple(levels), "", force, replace(span, order=strains.order), wire)
    if judge is None or history is None:
        return found
    low, at, high = (_judged(judge, history, span, wire, side) for side in (-1.0, 0.0, 1.0))
    return replace(found, states=(low, at, high))


def limit_block(found: LatticeExtrapolation, displacement: Array, layout: Any) -> dict[str, Any]:
    """Return the block `limit` of report.json; `layout` is that of the wires, None without."""
    levels = {
        "cells": [list(level.cells) for level in found.levels],
        "force_N": [float(level.force[-1]) for level in found.levels],
        "reached": not found.reason,
        "reason": found.reason,
    }
    if found.force is None or found.span is None or found.wire is None:
        return levels
    loops: list[dict[str, Any]] = []
    if layout is not None and found.states is not None:
        low, at, high = found.states
        for loop in range(layout.n_loops):
            step = int(np.argmax(found.span.values[:, loop]))
            loops.append(
                {
                    "wire": int(layout.loop_wire[loop]),
                    "loop": int(layout.loop_index[loop]),
                    "max_span_strain": float(found.span.values[step, loop]),
                    "span_strain_doubt": float(found.span.doubt[step, loop]),
                    "max_wire_strain": float(found.wire.values[:, loop].max()),
                    "state": STATES[at[loop]],
                    "state_at_least": STATES[low[loop]],
                    "state_at_most": STATES[high[loop]],
                }
            )
    return levels | {
        "order_force": found.force.order,
        "order_strain": found.span.order,
        "displacement_mm": displacement.tolist(),
        "punch_force_N": found.force.values.tolist(),
        "punch_force_doubt_N": found.force.doubt.tolist(),
        "loops": loops,
    }


def _off_force(curve: list[Array], sizes: list[float], order: float) -> str:
    """Return why forces are not in the range where errors fall as h^2, nothing where they are."""
    first, second = curve[1] - curve[0], curve[2] - curve[1]
    scale = SETTLED * float(np.linalg.norm(curve[2]))
    if np.linalg.norm(second) <= scale and np.linalg.norm(first) <= 4.0 * scale:
        return ""
    squares = np.square(sizes)
    due = second * (squares[0] - squares[1]) / (squares[1] - squares[2])
    misfit = float(np.linalg.norm(first - due) / np.linalg.norm(first))
    if LEAST_ORDER <= order <= MOST_ORDER and misfit <= MISFIT:
        return ""
    return (
        f"the force at the end goes {first[-1]:+.4g} N and then {second[-1]:+.4g} N from lattice to lattice; over the "
        f"curve that is the power {order:.1f} of the cell's size where the power 2 is due, and {100 * misfit:.0f} % "
        "off its shape; begin at a finer fabric.coarsening"
    )


def _off_strain(greatest: list[Array], order: float) -> str:
    """Return why the loops' greatest strains are not in that range, nothing where they are."""
    if not greatest[0].size:
        return ""
    first, second = greatest[1] - greatest[0], greatest[2] - greatest[1]
    if float(np.abs(second).max()) <= SETTLED * float(np.abs(greatest[2]).max()):
        return ""
    alike = float(first @ second) / max(float(np.linalg.norm(first) * np.linalg.norm(second)), 1e-300)
    if order >= LEAST_STRAIN_ORDER and alike >= ALIKE:
        return ""
    return (
        f"the loops' strains change by {np.sqrt(np.mean(second**2)):.2g} (root mean square) between the two finer "
        f"lattices, as the power {order:.1f} of the cell's size, and {100 * alike:.0f} % alike to the change between "
        "the coarser two; begin at a finer fabric.coarsening"
    )


def _of_wires(values: list[Array], finest: Level, span: Limit, sizes: list[float]) -> Limit:
    """Return the limit of the wires' own strains, which have a kink where slack is taken up.

    Where a wire is taut on all lattices its strain is extrapolated; where it becomes so in between it follows the span
    of the finest lattice, (1 + w) / (1 + s) being what it is there, and is doubted by the whole correction.
    """
    found = richardson(values, sizes)
    taut = np.all([value > 0.0 for value in values], axis=0)
    carried = (1.0 + finest.wire) * (1.0 + span.values) / (1.0 + finest.span) - 1.0
    carried = np.where(finest.wire > 0.0, np.maximum(carried, 0.0), 0.0)
    doubt = np.where(finest.wire > 0.0, np.abs(carried - finest.wire) + span.doubt, 0.0)
    return Limit(
        np.where(taut, np.maximum(found.values, 0.0), carried), np.where(taut, found.doubt, doubt), found.order
    )


def _judged(judge: Judge, history: WireHistory, span: Limit, wire: Limit, side: float) -> IntArray:
    """Return the states (L,) at the end when all strains are off by their doubt to one side."""

    def shifted(limit: Limit, *, least: float) -> Array:
        values = np.maximum(limit.values + side * limit.doubt, least)
        return np.concatenate([np.zeros((1, *values.shape[1:])), values])

    moved = replace(history, span_strain=shifted(span, least=-1.0), wire_strain=shifted(wire, least=0.0))
    return judge.judge(moved).loop_state


def solve_at(case: Case, coarsening: float, watch: Callable[[Increment], None]) -> tuple[Level, WireHistory | None]:
    """Run the case on another lattice and return its answers, and the history of its wires."""
    built = build_at(case, coarsening)
    wires, lattice = built.wires, built.model.lattice
    steps: list[float] = []
    forces: list[float] = []
    strains: dict[str, list[Array]] = {"span_strain": [], "wire_strain": [], "element_strain": []}
    for increment in advance(built.model, settings(built.case)):
        watch(increment)
        if not increment.output:
            continue
        steps.append(increment.displacement_mm)
        forces.append(increment.punch_force_N)
        if wires is not None:
            for name, values in wire_strains(wires, built.model, increment).items():
                strains[name].append(values)
    size = math.sqrt(lattice.coarsening[0] * lattice.coarsening[1])
    if wires is None:
        nothing = np.zeros((len(steps), 0))
        return Level(lattice.cells, size, np.array(forces), nothing, nothing), None
    rows = {name: np.array(values) for name, values in strains.items()}
    level = Level(lattice.cells, size, np.array(forces), rows["span_strain"], rows["wire_strain"])
    return level, wires.history(np.array(steps), rows)
