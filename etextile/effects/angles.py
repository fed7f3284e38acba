r"""Elements whose energy depends on the angle between two vectors of the lattice: shear of cells, bending of lines.

The vectors w and v of an element are weighted sums of its node positions (weights per component, so that an arm may be
the mirror image of the other at a symmetry plane). With s = w.v / (|w| |v|), unit vectors W, V and an energy U(s)

    dU/dw = U' (V - s W) / |w|,    d2s/dw2 = -(W (V - s W)^T + (V - s W) W^T + s (I - W W^T)) / |w|^2,
    d2s/dwdv = (I - W W^T) (I - V V^T) / (|w| |v|)

so a contribution is its geometry and one function of s, the potential.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from etextile.effects import kernels
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class AngleResult:
    """A potential at given cosines: dU/ds and d2U/ds2 (n,) in N mm, state to keep, energies in N mm."""

    slope: Array
    curvature: Array
    state: Any
    energy: Energy


class AnglePotential(Protocol):
    """Energy as a function of the cosine of the angle, with history if it dissipates."""

    def initial_state(self) -> Any:
        """Return the virgin state."""

    def evaluate(self, cosine: Array, state: Any) -> AngleResult:
        """Return energy and derivatives at the cosines (n,) of all elements."""


@dataclass(frozen=True)
class AngleBlock(Contribution):
    """Elements (n, k) with w = sum_a first_a x_a and v = sum_a second_a x_a; first and second (k, 3)."""

    name: str
    nodes: IntArray
    first: Array
    second: Array
    potential: AnglePotential

    def initial_state(self) -> Any:
        """Return the virgin state of the potential."""
        return self.potential.initial_state()

    def respond(self, x: Array, travel: float, state: Any) -> AngleResponse:
        """Evaluate all elements at positions x (P, 3)."""
        count = len(self.nodes)
        w, v, w_size, v_size, cosine = (np.empty(size) for size in ((count, 3), (count, 3), count, count, count))
        kernels.angle_vectors(self.nodes, self.first, self.second, x, w, v, w_size, v_size, cosine)
        return AngleResponse(self, w, v, w_size, v_size, cosine, self.potential.evaluate(cosine, state))


@dataclass(frozen=True)
class AngleResponse(Response):
    """Angle elements at a trial: unit vectors w, v (n, 3), their lengths (n,) mm, cosine (n,), potential there."""

    block: AngleBlock
    w: Array
    v: Array
    w_size: Array
    v_size: Array
    cosine: Array
    result: AngleResult

    @property
    def state(self) -> Any:
        """State of the potential to carry over."""
        return self.result.state

    def energy(self) -> Energy:
        """Return the energies of the potential, N mm."""
        return self.result.energy

    def add_gradient(self, gradient: Array) -> None:
        """Add the nodal gradients to gradient (P, 3)."""
        block = self.block
        kernels.add_angle_gradient(
            block.nodes, block.first, block.second, self.w, self.v, self.w_size, self.v_size, self.cosine,
            self.result.slope, gradient,
        )  # fmt: skip

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent; `exact` False keeps the positive part of each element's in the space of w and v."""
        block = self.block
        active = np.flatnonzero((self.result.slope != 0.0) | (self.result.curvature != 0.0))
        small = np.empty((len(active), 6, 6))
        kernels.angle_hessian(
            active, self.w, self.v, self.w_size, self.v_size, self.cosine, self.result.slope, self.result.curvature,
            small,
        )  # fmt: skip
        if not exact:
            size, axes = np.linalg.eigh(small)
            small = (axes * np.maximum(size, 0.0)[:, None, :]) @ axes.transpose(0, 2, 1)
        kernels.add_angle_tangent(active, block.nodes, block.first, block.second, small, rows, pairs, values)


def isotropic(weights: list[int]) -> Array:
    """Return the same weights (k, 3) for all three components."""
    return np.tile(np.array(weights, dtype=float)[:, None], (1, 3))


FIRST_ARM = isotropic([-1, 1, 0])
SECOND_ARM = isotropic([-1, 0, 1])


def corners(cells: IntArray) -> IntArray:
    """Return corner, end of its warp arm and end of its weft arm (4 n, 3) of all corners of cells (n, 4).

    Cells list origin, warp end, far corner, weft end; corners come cell by cell. Where the yarns of a cell turn by
    gamma, the cosine between the arms is sin(gamma) at its first and third corner and -sin(gamma) at the others.
    """
    order = np.array([[0, 1, 3], [1, 0, 2], [2, 3, 1], [3, 2, 0]])
    return np.ascontiguousarray(cells[:, order].reshape(-1, 3))


def arm_lengths(points: Array, nodes: IntArray) -> tuple[Array, Array]:
    """Return the lengths (n,) mm of both arms at positions (P, 3)."""
    warp, weft = (np.linalg.norm(points[nodes[:, end]] - points[nodes[:, 0]], axis=1) for end in (1, 2))
    return np.asarray(warp), np.asarray(weft)
