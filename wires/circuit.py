"""Nets over several wires: parts and joints as nodes, the wire between them as resistors that can be interrupted.

Nets are those of the whole specimen: a wire is made of modelled ones and their mirror images (`wires.portion.Image`).

A section of wire between two nodes has the resistance of its woven-in elements and loops,
rho l / (N A) * (1 + e)^2 * N / (N - k) (`wires.resistance`), and is open when a loop on it is; a loop at a node belongs
to both sections. The net's resistance is that between its first and its last part, by the conductance matrix of the
network. The net is lost when a part is no longer connected to the first one. Sections that share the scatter of a
garment and of a wire open together: where every one of them is needed the probability is that of the garment's wires
(`wires.reliability`) on these sections; where there are ways round, its wires are taken to share all of their scatter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.types import Array, IntArray
from wires.damage import FailureResult
from wires.dependence import EventProbability
from wires.history import running_maximum
from wires.layout import WireLayout
from wires.portion import Image
from wires.reliability import Reliability, WireStretch
from wires.resistance import Conductors, opening_mm, typical_broken
from wires.woven import WovenPieces, element_lengths, element_places


_TINY_MM = 1e-6


@dataclass(frozen=True)
class Node:
    """A place where a net is tapped or joined: name of the wire, coordinate along it, number of the node."""

    wire: str
    along_mm: float
    node: int


@dataclass(frozen=True)
class Circuit:
    """A net by name: its nodes on wires, the nodes of its parts (the source first), names for the report.

    images: what each of its wires is made of.
    """

    name: str
    wires: tuple[str, ...]
    parts: tuple[str, ...]
    nodes: tuple[Node, ...]
    part_nodes: tuple[int, ...]
    images: Mapping[str, tuple[Image, ...]]


@dataclass(frozen=True)
class Section:
    """Wire between two nodes: the modelled wire it is made of, loops and elements with how much of each is on it.

    places: the loops on it, each with its coordinate; ranges: stretches of the modelled wire, from low to high.
    """

    ends: tuple[int, int]
    name: str
    wire: int
    loops: Array
    elements: Array
    places: frozenset[tuple[int, float]]
    ranges: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class CircuitResult:
    """What became of a net: loss (mm, None: kept), its probability, resistance before and at the end, ohm."""

    circuit: Circuit
    lost_at_mm: float | None
    loss: EventProbability
    before_ohm: float
    after_ohm: float


def circuit_result(
    history: WireHistory, damage: FailureResult, conductors: Conductors, circuit: Circuit, *, ohm_per_mm: Array
) -> CircuitResult:
    """Return what became of a net; ohm_per_mm (W,) of unstretched wire."""
    parts = sections(history, circuit)
    first, last = circuit.part_nodes[0], circuit.part_nodes[-1]
    now = [_resistance(part, history, damage, conductors, ohm_per_mm) for part in parts]
    before = resistance_between([(part.ends, pair[0]) for part, pair in zip(parts, now, strict=True)], first, last)
    after = resistance_between([(part.ends, pair[1]) for part, pair in zip(parts, now, strict=True)], first, last)
    opened = opening_mm(damage)
    times = [float(np.nanmin(np.append(opened[part.loops > 0.0], np.inf))) for part in parts]
    lost_at = _lost_at(parts, times, circuit.part_nodes)
    return CircuitResult(circuit, lost_at, _loss(damage, parts, circuit.part_nodes), before, after)


def loss_of_circuit(history: WireHistory, damage: FailureResult, circuit: Circuit) -> EventProbability:
    """Return that a part of a net is cut off from its first one, with its interval."""
    return _loss(damage, sections(history, circuit), circuit.part_nodes)


def _loss(damage: FailureResult, parts: Sequence[Section], terminals: Sequence[int]) -> EventProbability:
    """Return the loss of a net with the interval that the doubt about the calibration gives it."""
    known = damage.reliability
    if known is None:
        lost = damage.open_probability
        kept = [(part.ends, float(np.prod((1.0 - lost) ** _counts([part], len(lost))))) for part in parts]
        alone = float(1.0 - reliability(kept, terminals))
        return EventProbability(alone, alone, alone)
    needed = [part for part in parts if not _joined(terminals, [other for other in parts if other is not part])]
    if _joined(terminals, needed):
        return known.series(
            [_stretch([part for part in needed if part.name == name], known) for name in _names(needed)]
        )
    every = [(part.ends, known.survival_of(_stretch([part], known))) for part in parts]
    return known.shared(1.0 - np.asarray(reliability(every, terminals)))


def _joined(terminals: Sequence[int], parts: Sequence[Section]) -> bool:
    return set(terminals) <= _reached(terminals[0], [part.ends for part in parts])


def _names(parts: Sequence[Section]) -> list[str]:
    return list(dict.fromkeys(part.name for part in parts))


def _stretch(parts: Sequence[Section], known: Reliability) -> WireStretch:
    """Return how much of a modelled wire some sections of one wire are made of."""
    loops = _counts(parts, known.layout.n_loops)
    woven = None if known.pieces is None else np.sum([_on(part, known.pieces) for part in parts], axis=0)
    return WireStretch(parts[0].wire, loops, woven)


def _counts(parts: Sequence[Section], loops: int) -> IntArray:
    """Return how many loops of the whole specimen each modelled loop (L,) is on sections of one wire."""
    places = frozenset().union(*(part.places for part in parts))
    return np.bincount(np.array([loop for loop, _ in places], dtype=np.int64), minlength=loops)


def _on(part: Section, pieces: WovenPieces) -> Array:
    """Return how much of each woven-in piece (P,) lies on a section, as shares of a piece of the whole specimen."""
    common = np.zeros(pieces.count)
    for low, high in part.ranges:
        common += np.clip(np.minimum(pieces.end_mm, high) - np.maximum(pieces.start_mm, low), 0.0, None)
    return np.where(pieces.wire == part.wire, common / pieces.length_mm, 0.0)


def sections(history: WireHistory, circuit: Circuit) -> list[Section]:
    """Return the wire between neighbouring nodes of a net."""
    found = []
    for name in circuit.wires:
        own = sorted((node.along_mm, node.node) for node in circuit.nodes if node.wire == name)
        for (low, a), (high, b) in pairwise(own):
            found.append(_section(history, name, circuit.images[name], (low, high), (a, b)))
    return found


def _section(
    history: WireHistory, name: str, images: Sequence[Image], reach: tuple[float, float], ends: tuple[int, int]
) -> Section:
    """Return the wire from one coordinate to another, gathered from the images it is made of."""
    layout, (low, high) = history.layout, reach
    middle, length = element_places(history), element_lengths(history)
    loops, elements = np.zeros(layout.n_loops), np.zeros(len(middle))
    places: set[tuple[int, float]] = set()
    ranges = []
    for image in images:
        centre = image.onto(0.5 * (layout.loop_exit_mm + layout.loop_entry_mm))
        on = (layout.loop_wire == image.wire) & (centre >= low - _TINY_MM) & (centre <= high + _TINY_MM)
        at_end = (np.abs(centre - low) < _TINY_MM) | (np.abs(centre - high) < _TINY_MM)
        loops += np.where(on, np.where(at_end, 0.5, 1.0), 0.0)
        places |= {(int(loop), round(float(centre[loop]), 6)) for loop in np.flatnonzero(on)}
        along = image.onto(middle)
        common = np.minimum(along + length / 2, high) - np.maximum(along - length / 2, low)
        elements += np.where(history.element_wire == image.wire, np.clip(common / length, 0.0, 1.0), 0.0)
        there = (image.sign * (low - image.offset), image.sign * (high - image.offset))
        ranges.append((min(there), max(there)))
    return Section(ends, name, images[0].wire, loops, elements, frozenset(places), tuple(ranges))


def _resistance(
    part: Section, history: WireHistory, damage: FailureResult, conductors: Conductors, ohm_per_mm: Array
) -> tuple[float, float]:
    """Return the resistance of a section before and at the end, ohm; infinite when it is open."""
    layout = history.layout
    count = damage.loop_filaments
    left = count - typical_broken(damage)[-1]
    thinner = np.where(left > 0, count / np.maximum(left, 1), np.inf)
    loop = part.loops * conductors.loop_mm * ohm_per_mm[layout.loop_wire]
    woven = part.elements * conductors.element_mm * ohm_per_mm[history.element_wire]
    in_loops = (1.0 + running_maximum(np.maximum(history.wire_strain, 0.0))[-1]) ** 2
    in_weave = (1.0 + running_maximum(np.maximum(history.element_strain, 0.0))[-1]) ** 2
    on = part.loops > 0.0
    after = ((loop * in_loops)[on] * thinner[on]).sum() + (woven * in_weave).sum()
    return float(loop.sum() + woven.sum()), float(after)


def resistance_between(resistors: Sequence[tuple[tuple[int, int], float]], first: int, last: int) -> float:
    """Return the resistance between two nodes of a network; infinite when they are not connected."""
    live = [(ends, ohm) for ends, ohm in resistors if np.isfinite(ohm)]
    reached = _reached(first, [ends for ends, _ in live])
    if last not in reached:
        return float("inf")
    if first == last:
        return 0.0
    number = {node: index for index, node in enumerate(sorted(reached))}
    matrix = np.zeros((len(number), len(number)))
    for (a, b), ohm in live:
        if a in number and a != b:
            i, j, siemens = number[a], number[b], 1.0 / max(ohm, 1e-12)
            matrix[[i, j], [i, j]] += siemens
            matrix[[i, j], [j, i]] -= siemens
    keep = [index for node, index in number.items() if node != first]
    current = np.zeros(len(number))
    current[number[last]] = 1.0
    return float(np.linalg.solve(matrix[np.ix_(keep, keep)], current[keep])[keep.index(number[last])])


def reliability(edges: Sequence[tuple[tuple[int, int], float | Array]], terminals: Sequence[int]) -> float | Array:
    """Return the probability that terminals are connected by edges that hold with given probabilities.

    Probabilities may be arrays of one shape, for as many cases. Conditioned on one edge after the other; what no longer
    matters is not followed, so that a tree takes one step each.
    """
    wanted = set(terminals)
    if not wanted <= _reached(terminals[0], [ends for ends, kept in edges if np.any(kept > 0.0)]):
        return 0.0
    if wanted <= _reached(terminals[0], [ends for ends, kept in edges if np.all(kept >= 1.0)]):
        return 1.0
    index = next(k for k, (_, kept) in enumerate(edges) if np.any(kept > 0.0) and not np.all(kept >= 1.0))
    ends, kept = edges[index]
    others = list(edges)
    others[index] = (ends, 1.0)
    with_it = reliability(others, terminals)
    others[index] = (ends, 0.0)
    return kept * with_it + (1.0 - kept) * reliability(others, terminals)


def _lost_at(parts: Sequence[Section], times: Sequence[float], terminals: Sequence[int]) -> float | None:
    """Return when a part is first cut off, given when each section opens; None when none is."""
    for time in sorted(time for time in times if np.isfinite(time)):
        live = [part.ends for part, opens in zip(parts, times, strict=True) if opens > time]
        if not set(terminals) <= _reached(terminals[0], live):
            return time
    return None


def _reached(start: int, edges: Sequence[tuple[int, int]]) -> set[int]:
    """Return the nodes that edges connect to a node."""
    reached, fresh = {start}, [start]
    while fresh:
        node = fresh.pop()
        for a, b in edges:
            for here, there in ((a, b), (b, a)):
                if here == node and there not in reached:
                    reached.add(there)
                    fresh.append(there)
    return reached


def linear_ohm_per_m(layout: WireLayout, conductors: Conductors, history: WireHistory, ohm_per_mm: Array) -> Array:
    """Return the linear electrical resistance (W,) of the tracks as made, ohm per metre of track (EN 16812)."""
    length = np.bincount(history.element_wire, conductors.element_mm, layout.n_wires)
    length = length + np.bincount(layout.loop_wire, conductors.loop_mm, layout.n_wires)
    track = layout.length_mm - np.bincount(layout.loop_wire, layout.modelled_rigid_mm, layout.n_wires)
    return np.asarray(1e3 * ohm_per_mm * length / track)
