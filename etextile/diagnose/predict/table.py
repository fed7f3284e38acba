"""An effect over its whole physical range: simulated on a grid of parameters, interpolated between.

Interpolation is linear in the simulated curves (cubic Hermite weights per axis), so the weights of a parameter value
are all that is ever needed. Axes run in the parameter's own scale (linear or logarithmic).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from etextile.effects.base import Card, Parameter
from etextile.types import Array, BoolArray


if TYPE_CHECKING:
    from scipy.interpolate import PPoly

Coordinates = Sequence[float] | Array

# Shares of the range, from the neutral value on, at which an effect is simulated.
ONE_SIDED = (0.15, 0.4, 0.7, 1.0)
TWO_SIDED = (0.3, 0.65, 1.0)
LOGARITHMIC = (0.15, 0.35, 0.47, 0.56, 0.64, 0.72, 0.8, 0.95)
SECOND = (0.3, 0.75)
SHAPE = (0.0, 0.15, 0.35, 0.7)
MOST_PARAMETERS = 2
# Weight of runs without equilibrium from which on a point of the table does not count.
INVALID = 1e-3


@dataclass(frozen=True)
class ParameterAxis:
    """One parameter of an effect: nodes (G,) in rising order, in its own coordinate; `neutral` node number or None.

    The coordinate is log x for logarithmic parameters; asinh((x - neutral) / ordinary) for those with a neutral value,
    `ordinary` being an ordinary size of the effect (or `Parameter.proportional`), so that a flat prior is flat up to
    there and falls as 1 / size beyond; and x itself for shapes such as an onset (`ordinary` 0).
    """

    parameter: Parameter
    nodes: Array
    neutral: int | None
    ordinary: float = 0.0

    def to_coordinate(self, value: float | Array) -> Array:
        """Return the coordinate of a parameter value."""
        found = np.asarray(value, dtype=float)
        if self.parameter.scale == "log":
            return np.asarray(np.log(found))
        return np.arcsinh((found - self._zero) / self.ordinary) if self.ordinary else found

    def to_value(self, coordinate: float | Array) -> Array:
        """Return the parameter value at a coordinate."""
        found = np.asarray(coordinate, dtype=float)
        if self.parameter.choice:
            return self._nearer_end(found)
        if self.parameter.scale == "log":
            return np.asarray(np.exp(found))
        return np.asarray(self._zero + self.ordinary * np.sinh(found)) if self.ordinary else found

    def _nearer_end(self, coordinate: Array) -> Array:
        """Return the end of a choice that coordinates stand for."""
        low, high = self.parameter.low, self.parameter.high
        return np.where(coordinate < 0.5 * (low + high), low, high)

    @property
    def _zero(self) -> float:
        found = self.parameter.neutral if self.parameter.neutral is not None else self.parameter.default
        return float(found or 0.0)

    @property
    def bounds(self) -> tuple[float, float]:
        """Coordinates between which the parameter may lie."""
        low, high = self.to_coordinate(self.parameter.low), self.to_coordinate(self.parameter.high)
        return float(low), float(high)

    def weights(self, coordinate: Array, *, linear: bool = False) -> Array:
        """Return interpolation weights (b, G) of coordinates (b,); constant beyond the outermost nodes."""
        coordinate = np.clip(coordinate, self.nodes[0], self.nodes[-1])
        if self.parameter.choice:
            coordinate = self._nearer_end(coordinate)
        if linear or len(self.nodes) == 2:
            return np.stack([np.interp(coordinate, self.nodes, row) for row in np.eye(len(self.nodes))], axis=1)
        return np.asarray(self._spline(coordinate))

    @cached_property
    def _spline(self) -> PPoly:
        """Every node's share along the axis, with slopes from differences of second order.

        On either side of the neutral value by itself: a taut specimen is no continuation of a slack one.
        """
        from scipy.interpolate import CubicHermiteSpline, PPoly

        identity, last = np.eye(len(self.nodes)), len(self.nodes) - 1
        parts = []
        for start, end in pairwise(sorted({0, self.neutral or 0, last})):
            own, values = self.nodes[start : end + 1], identity[start : end + 1]
            slopes = np.gradient(values, own, axis=0, edge_order=2 if len(own) > 2 else 1)
            parts.append(CubicHermiteSpline(own, values, slopes).c)
        return PPoly(np.concatenate(parts, axis=1), self.nodes)

    def thinned(self, ordinary: int) -> ParameterAxis:
        """Return the axis with its ends, the neutral and one `ordinary` node alone; itself for a form or a choice.

        The middle one where the ordinary node is an end.
        """
        if self.parameter.form or self.parameter.choice:
            return self
        last = len(self.nodes) - 1
        inner = ordinary if 0 < ordinary < last else last // 2
        kept = sorted({0, inner, ordinary, last, *(() if self.neutral is None else (self.neutral,))})
        neutral = None if self.neutral is None else kept.index(self.neutral)
        return replace(self, nodes=self.nodes[kept], neutral=neutral)

    def refined(self, coordinate: float) -> ParameterAxis:
        """Return the axis with one more node; itself for a form, a choice, or with a node there (1 % of the range)."""
        low, high = self.bounds
        if self.parameter.form or self.parameter.choice or np.abs(self.nodes - coordinate).min() < 0.01 * (high - low):
            return self
        nodes = np.sort(np.append(self.nodes, coordinate))
        neutral = None if self.neutral is None else int(np.searchsorted(nodes, self.nodes[self.neutral]))
        return ParameterAxis(self.parameter, nodes, neutral, self.ordinary)


def axes_of(card: Card) -> tuple[ParameterAxis, ...]:
    """Return the axes along which an effect is searched.

    The first parameter, and the next one without a default or without a neutral value; others keep their defaults.
    """
    first, *rest = card.parameters
    shapes = [item for item in rest if item.neutral is None or item.default is None]
    chosen = [first, *shapes][:MOST_PARAMETERS]
    sizes = card.example.parameters
    return tuple(
        axis_of(item, item.proportional or sizes.get(item.name, 0.0), first=i == 0) for i, item in enumerate(chosen)
    )


def axis_of(item: Parameter, example: float, *, first: bool) -> ParameterAxis:
    """Return the nodes of one parameter; a neutral value inside the range is a node that needs no run.

    Of a form only both ends are simulated: between them the change is taken to be the mean of theirs, by share. Of a
    choice there is nothing between: every coordinate stands for the nearer end.
    """
    low, high = item.low, item.high
    if item.form or item.choice:
        return ParameterAxis(item, np.array([low, high]), None)
    centre = item.neutral if item.neutral is not None else item.default if low < 0.0 < high else None
    if item.scale == "log" or centre is None or not low <= centre <= high:
        bare = ParameterAxis(item, np.zeros(0), None)
        start, end = bare.bounds
        nodes = start + np.array(LOGARITHMIC if first else SHAPE) * (end - start)
        usual = [bare.to_coordinate(value) for value in (item.default,) if value is not None and low <= value <= high]
        return ParameterAxis(item, np.array(sorted({*nodes, *(float(c) for c in usual if c > nodes[-1])})), None)
    zero = float(centre)
    ordinary = abs(example - zero) or 0.04 * (high - low)
    start, end = (float(np.arcsinh((value - zero) / ordinary)) for value in (low, high))
    one_sided = start == 0.0 or end == 0.0
    shares = (ONE_SIDED if one_sided else TWO_SIDED) if first else SECOND
    up = [share * end for share in shares] if end > 0.0 else []
    down = [share * start for share in shares] if start < 0.0 else []
    nodes = np.array(sorted({0.0, *up, *(down if first else down[1:2])}))
    return ParameterAxis(item, nodes, int(np.searchsorted(nodes, 0.0)) if item.neutral is not None else None, ordinary)


@dataclass(frozen=True)
class ParameterGrid:
    """The nodes of an effect: axes, and the parameters every node stands for (others at their default)."""

    card: Card
    axes: tuple[ParameterAxis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of nodes per axis."""
        return tuple(len(axis.nodes) for axis in self.axes)

    def parameters(self, coordinates: Coordinates) -> dict[str, float]:
        """Return all parameters of the effect at coordinates (one per axis)."""
        values = {item.name: item.default for item in self.card.parameters if item.default is not None}
        for axis, coordinate in zip(self.axes, coordinates, strict=True):
            low, high = axis.parameter.low, axis.parameter.high
            values[axis.parameter.name] = float(np.clip(axis.to_value(coordinate), low, high))
        return {name: float(value) for name, value in values.items()}

    def nodes(self) -> list[tuple[tuple[int, ...], dict[str, float]]]:
        """Return index and parameters of every node that has to be simulated (the neutral ones have not)."""
        found = []
        for index in itertools.product(*(range(size) for size in self.shape)):
            if not self.is_neutral(index):
                found.append(
                    (index, self.parameters([axis.nodes[i] for axis, i in zip(self.axes, index, strict=True)]))
                )
        return found

    def is_neutral(self, index: tuple[int, ...]) -> bool:
        """Tell whether the effect does nothing at a node: all axes with a neutral value are at it."""
        neutral = [(axis.neutral, i) for axis, i in zip(self.axes, index, strict=True)]
        # an effect is neutral when every parameter that has a neutral value is there
        having = [axis.parameter.neutral is not None for axis in self.axes]
        return any(having) and all(
            node is not None and i == node for (node, i), has in zip(neutral, having, strict=True) if has
        )

    @property
    def ordinary(self) -> tuple[int, ...]:
        """Index of the node next to the card's example."""
        found = []
        for axis in self.axes:
            low, high = axis.bounds
            size = self.card.example.parameters.get(axis.parameter.name)
            wanted = 0.5 * (low + high) if size is None else float(axis.to_coordinate(size))
            apart = np.abs(axis.nodes - wanted)
            if axis.neutral is not None:
                apart[axis.neutral] = np.inf
            found.append(int(np.argmin(apart)))
        return tuple(found)

    def thinned(self) -> ParameterGrid:
        """Return the grid with few of its nodes, for a first look: ends, neutral values and the ordinary size."""
        axes = (axis.thinned(i) for axis, i in zip(self.axes, self.ordinary, strict=True))
        return ParameterGrid(self.card, tuple(axes))

    def refined(self, coordinates: Coordinates) -> ParameterGrid:
        """Return the grid with nodes through a point."""
        return ParameterGrid(self.card, tuple(axis.refined(c) for axis, c in zip(self.axes, coordinates, strict=True)))


@dataclass(frozen=True)
class EffectTable:
    """Simulated change of all points against the base at the nodes of a grid.

    basis (n, q) and amplitudes (q, N): curves of the N nodes (row-major) as basis @ amplitudes; `valid` (N,): runs
    that reached the whole range; `doubt`, `loose` (n, n): covariances of what the lattice leaves open in the
    change and of what the card calls undetermined, None for next to nothing.
    """

    grid: ParameterGrid
    basis: Array
    amplitudes: Array
    valid: BoolArray
    doubt: Array | None = None
    loose: Array | None = None

    @property
    def id(self) -> str:
        """Name of the effect."""
        return self.grid.card.id

    def coefficients(self, coordinates: Array) -> tuple[Array, BoolArray]:
        """Return amplitudes (b, q) of the basis at coordinates (b, axes), and whether all runs behind are valid.

        Where a run beside the own cell found no equilibrium the interpolation is linear.
        """
        weights = self._weights(coordinates, linear=False)
        lost = np.abs(weights[:, ~self.valid]).sum(axis=1) >= INVALID
        if lost.any():
            weights[lost] = self._weights(coordinates[lost], linear=True)
        usable = np.abs(weights[:, ~self.valid]).sum(axis=1) < INVALID
        return weights @ self.amplitudes.T, usable

    def _weights(self, coordinates: Array, *, linear: bool) -> Array:
        """Return interpolation weights (b, N) of the nodes; linear ones reach the corners of the own cell alone."""
        weights = np.ones((len(coordinates), 1))
        for axis, column in zip(self.grid.axes, coordinates.T, strict=True):
            own = axis.weights(column, linear=linear)
            weights = (weights[:, :, None] * own[:, None, :]).reshape(len(coordinates), -1)
        return weights

    def curve(self, coordinates: Coordinates) -> Array:
        """Return the change (n,) at one point of the parameter space."""
        return np.asarray(self.basis @ self.coefficients(np.array([coordinates], dtype=float))[0][0])

    @property
    def bounds(self) -> Array:
        """Lower and upper coordinates (axes, 2)."""
        return np.array([axis.bounds for axis in self.grid.axes])

    def corrected(self, coordinates: Coordinates, curve: Array, *, share: float = 1.0) -> EffectTable:
        """Return the table that gives `curve` (n,) at a point and changes in proportion elsewhere.

        The basis gains (curve - basis a) a^T / |a|^2 with the amplitudes a of the point, so nothing stays nothing;
        a `share` of that is taken over.
        """
        amplitudes = self.coefficients(np.array([coordinates], dtype=float))[0][0]
        size = float(amplitudes @ amplitudes)
        if size == 0.0:
            return self
        missing = share * (curve - self.basis @ amplitudes)
        return replace(self, basis=self.basis + np.outer(missing, amplitudes) / size)


def tabulate(grid: ParameterGrid, curves: Mapping[tuple[int, ...], Array], tolerance: Array) -> EffectTable:
    """Return the table of simulated changes, (n,) each by node; NaN where a run did not reach.

    `tolerance` (n,) is the noise: the basis leaves out what is less than a twentieth of it.
    """
    size = len(tolerance)
    columns, valid = [], []
    for index in itertools.product(*(range(count) for count in grid.shape)):
        curve = np.zeros(size) if grid.is_neutral(index) else curves.get(index, np.full(size, np.nan))
        valid.append(bool(np.all(np.isfinite(curve))))
        columns.append(np.nan_to_num(curve) if valid[-1] else np.zeros(size))
    matrix = np.stack(columns, axis=1)
    scaled = matrix / tolerance[:, None]
    u, s, vt = np.linalg.svd(scaled, full_matrices=False)
    keep = max(1, int(np.count_nonzero(s > 0.05 * np.sqrt(size))))
    return EffectTable(grid, tolerance[:, None] * u[:, :keep], s[:keep, None] * vt[:keep], np.array(valid))


def each_with_its_own(
    tables: Sequence[EffectTable], coordinates: NDArray[Any]
) -> Iterator[tuple[EffectTable, NDArray[Any]]]:
    """Yield every table with its own part (..., axes) of coordinates (..., d), in which effects follow one another."""
    start = 0
    for table in tables:
        end = start + len(table.grid.axes)
        yield table, coordinates[..., start:end]
        start = end


def superposed(tables: Sequence[EffectTable], coordinates: Array) -> Array:
    """Return the superposed change (n,) of several effects at coordinates (d,), one after the other."""
    changes = (table.curve(own) for table, own in each_with_its_own(tables, coordinates))
    return np.asarray(sum(changes, np.zeros(len(tables[0].basis))))
