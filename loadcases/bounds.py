"""How large a case may become, found from its numbers before anything is allocated.

The bound of the memory is the machine's own; the others are far beyond any specimen and only keep a slip of the pen
(a length in m, a step of 1e-7 mm) from filling the machine.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from etextile.environment import memory_bytes
from etextile.errors import BadInput, Problem
from etextile.vocabulary import PORTIONS
from loadcases.schema_numbers import MOST_STEPS


if TYPE_CHECKING:
    from loadcases.fabric import Fabric
    from loadcases.schema import Case

NODE_BYTES = 8_000
"""Memory per node of the lattice: 3 kB measured at 14 000 nodes, more where the factors of the stiffness fill."""
STEP_BYTES = 400
"""Memory per step and lattice cell along a wire, for the histories that reports are made from."""
MOST_WAY = 3.0
"""Way of a body or clamp in longest sides of the piece: no fabric stretches to six times its length."""
MOST_LOAD = {"pressure": 1000.0, "weight": 1e6}
"""Largest pressure, bar, and weight, g/m2."""
LEAST_LOAD = 1e-6
"""Smallest pressure, bar, and weight, g/m2."""
LEAST_MM, MOST_SIZE = 1e-3, 100.0
"""Dimensions of a body: from a micron to so many longest sides of the piece, to which it is a plane then."""
NO_LENGTHS = frozenset({"rotation", "flexion", "scale", "dimensions", "axis"})
MAY_BE_NOTHING = frozenset({"position", "tip_height"})
USABLE = 0.8
"""Share of the machine's memory that a run may ask for."""


def require_bounded(case: Case, fabric: Fabric) -> None:
    """Raise BadInput for a case that would have more steps, or take more memory, than can be had."""
    problems = [
        *_too_many_steps(case),
        *_too_far(case),
        *_no_such_body(case),
        *_no_such_comb(case, fabric),
        *_too_much_memory(case, fabric),
    ]
    if problems:
        raise BadInput(problems)


def _too_far(case: Case) -> list[Problem]:
    """Return what is wrong with a motion that no fabric could follow, a load that none could bear."""
    motion, side = case.motion, max(case.pattern)
    if motion.target == "joint":
        return []
    most = MOST_LOAD.get(motion.target, MOST_WAY * side)
    least = LEAST_LOAD if motion.target in MOST_LOAD else LEAST_MM
    if motion.reach < least:
        message = f"the motion reaches {motion.reach:g} {motion.unit}, at least {least:g} {motion.unit} are run"
        return [Problem(message, key="motion.total")]
    if motion.reach <= most:
        return []
    why = "" if motion.target in MOST_LOAD else f", {MOST_WAY:g} times the longest side of the piece ({side:g} mm)"
    message = f"the motion reaches {motion.reach:g} {motion.unit}, at most {most:g} {motion.unit} are run{why}"
    return [Problem(message, key="motion.total")]


def _no_such_body(case: Case) -> list[Problem]:
    """Return what is wrong with dimensions of a body (mm) beside which the piece, or the body, is nothing."""
    if case.body is None:
        return []
    side = max(case.pattern)
    found = [
        (name, abs(float(value)))
        for name, stated in case.body
        if name not in NO_LENGTHS and isinstance(stated, float | tuple)
        for value in (stated if isinstance(stated, tuple) else (stated,))
    ]
    return [
        Problem(
            f"the body has {value:g} mm there, from {LEAST_MM:g} mm to {MOST_SIZE:g} times the longest side of the "
            f"piece ({side:g} mm) is run",
            key=f"body.{name}",
        )
        for name, value in found
        if value > MOST_SIZE * side or (value < LEAST_MM and name not in MAY_BE_NOTHING)
    ]


def _no_such_comb(case: Case, fabric: Fabric) -> list[Problem]:
    """Return what is wrong with wires or loops in a row that begins beside the piece, or of which it has no second."""
    if case.wires is None:
        return []
    side, loops = max(case.pattern), case.wires.loops
    apart = {"every_warp_yarns": case.wires.every_warp_yarns / fabric.warp_density}
    shifts = {"first_offset": case.wires.first_offset}
    if loops is not None:
        apart["loops.spacing"], shifts["loops.offset"] = loops.spacing, loops.offset
    far = [(name, "they stand", value, MOST_SIZE, "apart") for name, value in apart.items()]
    far += [(name, "the first stands", abs(value), 1.0, "from the centre") for name, value in shifts.items()]
    return [
        Problem(
            f"{who} {value:g} mm {what}, at most {most * side:g} mm ({_times(most)}the longest side) is run",
            key=f"wires.{name}",
        )
        for name, who, value, most, what in far
        if value > most * side
    ]


def _times(factor: float) -> str:
    return "" if factor == 1.0 else f"{factor:g} times "


def _too_many_steps(case: Case) -> list[Problem]:
    """Return what is wrong with the number of points on the path of the motion."""
    count = _steps(case)
    if count <= MOST_STEPS:
        return []
    message = f"the path makes {count:.3g} steps, at most {MOST_STEPS} are run; take fewer steps or a shorter path"
    return [Problem(message, key="motion.steps")]


def _steps(case: Case) -> float:
    """Return the number of output points on the path of a motion, without making them."""
    motion = case.motion
    stations = (0.0, *(motion.path or (motion.reach,)))
    return sum(max(1.0, abs(b - a) / motion.reach * motion.steps) for a, b in pairwise(stations))


def _too_much_memory(case: Case, fabric: Fabric) -> list[Problem]:
    """Return what is wrong with the number of cells: memory asked against what the machine has."""
    length, width = case.pattern
    share = 0.5 ** sum(PORTIONS[case.fabric.portion])
    along, across = (
        max(1.0, size / (case.fabric.coarsening * cell))
        for size, cell in zip((length, width), fabric.cell, strict=True)
    )
    nodes = (along + 1.0) * (across + 1.0) * share
    wires = case.wires
    lines = 0.0 if wires is None else width * fabric.warp_density / wires.every_warp_yarns + len(wires.paths)
    asked = NODE_BYTES * nodes + STEP_BYTES * _steps(case) * lines * along * share
    had = memory_bytes()
    if asked <= USABLE * had:
        return []
    coarser = case.fabric.coarsening * (asked / (USABLE * had)) ** 0.5
    message = (
        f"a piece of {length:g} x {width:g} mm at coarsening {case.fabric.coarsening:g} has {nodes:.3g} nodes, which "
        f"take about {asked / 1e9:.3g} GB of memory; this machine has {had / 1e9:.3g} GB, of which "
        f"{100 * USABLE:.0f} % may be asked for; take a smaller piece or a coarsening of {coarser:.3g}"
    )
    return [Problem(message, key="fabric.size")]
