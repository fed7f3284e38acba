"""Direct solvers for the symmetric tangent: factorise(values) then solve(rhs), symbolic work done once.

PARDISO (Intel oneMKL) is the default where its wheels exist; SuperLU of scipy with a
nested-dissection ordering is always there. Both tell whether the matrix is positive definite.
"""

from __future__ import annotations

import ctypes
import os
import sys
import sysconfig
import weakref
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from etextile.errors import EtextileError
from etextile.registry import Registry
from etextile.solve.dissection import nested_dissection
from etextile.solve.pattern import Pattern
from etextile.types import Array


_ANALYSE, _FACTORISE, _SOLVE, _RELEASE = 11, 22, 33, -1
"""Phases of PARDISO."""
PARALLEL = 20_000
"""Unknowns from which PARDISO may take more than one thread: below, starting them costs more than they gain."""
_NO_ORDER = np.zeros(1, dtype=np.int32)
"""PARDISO's argument for an order of the user's own, which is not given."""


class NotPositiveDefinite(EtextileError):
    """The matrix has a pivot that is not positive; add damping and try again."""


class LinearSolver(Protocol):
    """A factorisation that always belongs to the last values given."""

    name: str

    def factorise(self, values: Array) -> None:
        """Factorise the matrix with these upper-triangular values; raises NotPositiveDefinite."""

    def solve(self, rhs: Array) -> Array:
        """Solve for one right-hand side (n,) with the last factorisation."""


class Pardiso:
    """Cholesky of oneMKL PARDISO; one symbolic phase per pattern."""

    name = "pardiso"

    def __init__(self, pattern: Pattern, points: Array) -> None:
        """Analyse the pattern; raises ImportError where oneMKL is missing. `points` is not needed here."""
        self._routine, self._threads = _library()
        self._handle = np.zeros(64, dtype=np.int64)
        self._size = pattern.size
        self._indptr = (pattern.indptr + 1).astype(np.int32)
        self._indices = (pattern.indices + 1).astype(np.int32)
        self._values = np.ones(len(pattern.indices))
        self._iparm = np.zeros(64, dtype=np.int32)
        # No defaults, parallel nested dissection only for large systems (its sequential form is repeatable),
        # no iterative refinement, no scaling: the matrix is positive definite.
        self._iparm[[0, 1, 7, 34 - 1]] = 1, 2, 0, 0
        self._nothing = np.zeros(1)
        self._call(_ANALYSE, self._nothing, self._nothing)
        # Not at exit: then the process gives its memory back, and modules this would need are gone.
        weakref.finalize(self, _release, self._routine, self._handle, self._size, self._iparm).atexit = False

    def factorise(self, values: Array) -> None:
        """Numerical factorisation; raises NotPositiveDefinite."""
        self._values = np.ascontiguousarray(values)
        self._call(_FACTORISE, self._nothing, self._nothing)

    def solve(self, rhs: Array) -> Array:
        """Forward and backward substitution."""
        solution = np.empty(self._size)
        self._call(_SOLVE, np.ascontiguousarray(rhs), solution)
        return solution

    def _call(self, phase: int, rhs: Array, solution: Array) -> None:
        matrix = (self._values, self._indptr, self._indices)
        before = self._threads(1) if self._size < PARALLEL else None
        error = _pardiso(self._routine, self._handle, phase, self._size, self._iparm, matrix, rhs, solution)
        if before is not None:
            self._threads(before)
        if error == -4:
            raise NotPositiveDefinite("the tangent is not positive definite")
        if error == -2:
            raise EtextileError("not enough memory to factorise the tangent; take a larger fabric.coarsening")
        if error != 0:
            raise EtextileError(f"PARDISO stopped with error {error} in phase {phase}")


@lru_cache(maxsize=1)
def _library() -> tuple[Any, Any]:
    """Return PARDISO and the setting of threads of oneMKL, loaded once; raises ImportError where it is missing."""
    os.environ.setdefault("MKL_CBWR", "AVX2")  # the same digits on one and on two threads
    mkl = _load()
    routine, threads = mkl.pardiso, mkl.MKL_Set_Num_Threads_Local
    routine.restype = None
    threads.argtypes, threads.restype = [ctypes.c_int], ctypes.c_int
    return routine, threads


def _load() -> ctypes.CDLL:
    """Load oneMKL from where the user says or its wheel is, else search the installation, which takes half a second."""
    said = os.environ.get("PYPARDISO_MKL_RT")
    if said:
        return ctypes.CDLL(said)
    data = Path(sysconfig.get_path("data"))
    for folder in (data / "lib", data / "Library" / "bin", Path(sys.prefix) / "lib"):
        for file in sorted(folder.glob("*mkl_rt.*"), reverse=True):
            with suppress(OSError):
                return ctypes.CDLL(str(file))
    from pypardiso import PyPardisoSolver

    found: ctypes.CDLL = PyPardisoSolver(mtype=2).libmkl
    return found


def _pardiso(
    routine: Any,
    handle: NDArray[np.int64],
    phase: int,
    size: int,
    iparm: NDArray[np.int32],
    matrix: tuple[Array, NDArray[np.int32], NDArray[np.int32]],
    rhs: Array,
    solution: Array,
) -> int:
    """Call oneMKL and return its error code."""
    number = ctypes.c_int32
    error = number(0)
    integers = ctypes.POINTER(number)
    values, indptr, indices = matrix
    routine(
        handle.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
        ctypes.byref(number(1)),
        ctypes.byref(number(1)),
        ctypes.byref(number(2)),
        ctypes.byref(number(phase)),
        ctypes.byref(number(size)),
        values.ctypes.data_as(ctypes.c_void_p),
        indptr.ctypes.data_as(integers),
        indices.ctypes.data_as(integers),
        _NO_ORDER.ctypes.data_as(integers),
        ctypes.byref(number(1)),
        iparm.ctypes.data_as(integers),
        ctypes.byref(number(0)),
        rhs.ctypes.data_as(ctypes.c_void_p),
        solution.ctypes.data_as(ctypes.c_void_p),
        ctypes.byref(error),
    )
    return int(error.value)


def _release(routine: Any, handle: NDArray[np.int64], size: int, iparm: NDArray[np.int32]) -> None:
    """Give oneMKL's memory of one factorisation back."""
    none, nothing = np.zeros(1, dtype=np.int32), np.zeros(1)
    _pardiso(routine, handle, _RELEASE, size, iparm, (nothing, none, none), nothing, nothing)


class SuperLU:
    """scipy's SuperLU in symmetric mode on a nested-dissection order of the node graph."""

    name = "superlu"

    def __init__(self, pattern: Pattern, points: Array) -> None:
        """Order the nodes at `points` (N, 3) once."""
        nodes = nested_dissection(points, pattern.adjacency)
        self._order = (3 * nodes[:, None] + np.arange(3)).ravel()
        self._pattern = pattern
        self._factor: Any = None

    def factorise(self, values: Array) -> None:
        """Factorise; raises NotPositiveDefinite when a pivot is not positive or had to be exchanged."""
        from scipy.sparse.linalg import splu

        upper = self._pattern.matrix(values)
        full = (upper + sparse.triu(upper, 1).T).tocsc()
        ordered = full[self._order][:, self._order]
        try:
            factor = splu(ordered, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise NotPositiveDefinite(str(error)) from error
        if np.any(factor.U.diagonal() <= 0.0) or np.any(factor.perm_r != factor.perm_c):
            raise NotPositiveDefinite("the tangent is not positive definite")
        self._factor = factor

    def solve(self, rhs: Array) -> Array:
        """Forward and backward substitution."""
        solution = np.empty_like(rhs)
        solution[self._order] = self._factor.solve(rhs[self._order])
        return solution


LINEAR_SOLVERS: Registry[type[Pardiso] | type[SuperLU]] = Registry("linear solver")
LINEAR_SOLVERS.register("pardiso", Pardiso)
LINEAR_SOLVERS.register("superlu", SuperLU)


def make_linear_solver(name: str, pattern: Pattern, points: Array) -> LinearSolver:
    """Return the named solver; `auto` takes PARDISO and falls back to SuperLU where oneMKL is missing."""
    if name != "auto":
        return LINEAR_SOLVERS[name](pattern, points)
    try:
        return Pardiso(pattern, points)
    except (ImportError, OSError):  # no oneMKL, or one that does not load
        return SuperLU(pattern, points)
