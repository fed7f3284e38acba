"""Cholesky of small tangents within their band: LAPACK goes through one dense array, a sparse solver through lists.

Nodes are numbered along the piece, so that only nodes of neighbouring rows are coupled. With n unknowns and the
half-width b of the band it takes n b^2 operations, more than a nested dissection needs, but up to some ten million of
them the bookkeeping of a sparse factorisation costs more than it saves.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import sparse
from scipy.linalg import lapack
from scipy.sparse.csgraph import reverse_cuthill_mckee

from etextile.errors import EtextileError, NotPositiveDefinite
from etextile.solve.pattern import Pattern
from etextile.types import Array, IntArray


WORTH = 1.2e7
"""Operations n b^2 of a factorisation up to which a band is quicker than a sparse solver."""
LARGEST = 4_000
"""Unknowns beyond which no band is looked for."""
ROOM = 1e9
"""Bytes that a band may take."""


class BandCholesky:
    """Cholesky of LAPACK within the band of a small tangent, its nodes numbered along the piece."""

    name = "band"

    def __init__(self, pattern: Pattern, points: Array) -> None:
        """Number the nodes at `points` (N, 3); raises EtextileError where the band is too wide for the memory."""
        self._order, width = _narrowest(pattern, points)
        if 8.0 * pattern.size * (width + 1) > ROOM:
            raise EtextileError(
                f"solver.linear: band: {pattern.size} unknowns have a band of {width}, more than the memory is for; "
                "take pardiso or superlu"
            )
        self._band = np.zeros((pattern.size, width + 1))
        self._places = _places(pattern, self._order, width)
        self._factor: Array = self._band

    def factorise(self, values: Array) -> None:
        """Numerical factorisation; raises NotPositiveDefinite."""
        self._band.fill(0.0)
        self._band.ravel()[self._places] = values
        self._factor, failed = lapack.dpbtrf(self._band.T, lower=1, overwrite_ab=1)
        if failed:
            raise NotPositiveDefinite("the tangent is not positive definite")

    def solve(self, rhs: Array) -> Array:
        """Forward and backward substitution."""
        numbered = np.empty_like(rhs)
        numbered[self._order] = rhs
        found, _ = lapack.dpbtrs(self._factor, numbered, lower=1, overwrite_b=1)
        return np.asarray(found[self._order])


def suits(pattern: Pattern, points: Array) -> bool:
    """Whether a band is quicker than a sparse solver."""
    return pattern.size <= LARGEST and pattern.size * _narrowest(pattern, points)[1] ** 2 <= WORTH


def _narrowest(pattern: Pattern, points: Array) -> tuple[IntArray, int]:
    """Return the numbers (n,) of the unknowns in the order with the narrowest band, and its half-width."""
    found = [(_unknowns(nodes), nodes) for nodes in _orders(pattern, points)]
    widths = [_width(pattern, order) for order, _ in found]
    best = int(np.argmin(widths))
    return found[best][0], widths[best]


def _orders(pattern: Pattern, points: Array) -> Iterator[IntArray]:
    """Yield orders of the nodes: line by line along x and along y, and from neighbour to neighbour."""
    x, y, _ = np.round(points, 6).T
    yield np.lexsort((y, x))
    yield np.lexsort((x, y))
    yield reverse_cuthill_mckee(sparse.csr_matrix(pattern.neighbours), symmetric_mode=True)


def _unknowns(nodes: IntArray) -> IntArray:
    """Return the number of every unknown (3 N,) for nodes (N,) in order."""
    number = np.empty(len(nodes), dtype=np.int64)
    number[nodes] = np.arange(len(nodes))
    return np.asarray((3 * number[:, None] + np.arange(3)).ravel())


def _ends(pattern: Pattern, order: IntArray) -> tuple[IntArray, IntArray]:
    """Return the lower and the higher number of every entry's row and column."""
    rows = np.repeat(order, np.diff(pattern.indptr))
    columns = order[pattern.indices]
    return np.minimum(rows, columns), np.maximum(rows, columns)


def _width(pattern: Pattern, order: IntArray) -> int:
    low, high = _ends(pattern, order)
    return int((high - low).max(initial=0))


def _places(pattern: Pattern, order: IntArray, width: int) -> IntArray:
    """Return where the values go in the band (n, width + 1): the lower triangle, column by column."""
    low, high = _ends(pattern, order)
    return low * (width + 1) + high - low
