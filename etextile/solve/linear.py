"""Direct solvers for the symmetric tangent: factorise(values) then solve(rhs), symbolic work done once.

Small tangents are factorised within their band (`band`), others by PARDISO (Intel oneMKL) where its wheels exist;
SuperLU of scipy with a nested-dissection ordering is always there. All tell whether the matrix is positive definite.
"""

from __future__ import annotations

import ctypes
import os
import sys
import sysconfig
import weakref
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from etextile.errors import EtextileError, NotPositiveDefinite
from etextile.mechanics import kernels
from etextile.registry import Registry
from etextile.solve.band import BandCholesky, suits
from etextile.solve.dissection import nested_dissection
from etextile.solve.pattern import Pattern
from etextile.types import Array


_ANALYSE, _FACTORISE, _SOLVE, _RELEASE = 11, 22, 33, -1
"""Phases of PARDISO."""
PARALLEL = 20_000
"""Unknowns from which PARDISO may take more than one thread: below, starting them costs more than they gain."""
MIXED = 4_000
"""Unknowns from which factors are in single precision: below, assembly and checks cost more than they gain."""
ALLOWED = 1e-2
"""Residual of an answer in single precision, as a share of its right-hand side, beyond which it is done in double."""
_NO_ORDER = np.zeros(1, dtype=np.int32)
"""PARDISO's argument for an order of the user's own, which is not given."""


class LinearSolver(Protocol):
    """A factorisation that always belongs to the last values given."""

    name: str

    def factorise(self, values: Array) -> None:
        """Factorise the matrix with these upper-triangular values; raises NotPositiveDefinite."""

    def solve(self, rhs: Array) -> Array:
        """Solve for one right-hand side (n,) with the last factorisation."""


class Pardiso:
    """Cholesky of oneMKL PARDISO in double or single precision; one symbolic phase per pattern."""

    name = "pardiso"

    def __init__(self, pattern: Pattern, points: Array, *, single: bool = False) -> None:
        """Analyse the pattern; raises ImportError where oneMKL is missing. `points` is not needed here."""
        routine, self._threads = _library()
        self._size = pattern.size
        self._indptr = (pattern.indptr + 1).astype(np.int32)
        self._indices = (pattern.indices + 1).astype(np.int32)
        self._kind: type[np.float32 | np.float64] = np.float32 if single else np.float64
        self._values: Any = np.ones(len(pattern.indices), self._kind)
        iparm = np.zeros(64, dtype=np.int32)
        # No defaults, parallel nested dissection only for large systems (its sequential form is repeatable),
        # no iterative refinement, no scaling: the matrix is positive definite.
        iparm[[0, 1, 7, 28 - 1, 34 - 1]] = 1, 2, 0, single, 0
        self._nothing = np.zeros(1, self._kind)
        self._pardiso = _Call(routine, np.zeros(64, dtype=np.int64), self._size, iparm)
        self._pattern = (_address(self._indptr), _address(self._indices))
        self._call(_ANALYSE, self._nothing, self._nothing)
        # Not at exit: then the process gives its memory back, and modules this would need are gone.
        weakref.finalize(self, _release, self._pardiso).atexit = False

    def factorise(self, values: Array) -> None:
        """Numerical factorisation; raises NotPositiveDefinite."""
        self._values = np.ascontiguousarray(values, self._kind)
        self._call(_FACTORISE, self._nothing, self._nothing)

    def solve(self, rhs: Array) -> Array:
        """Forward and backward substitution."""
        solution = np.empty(self._size, self._kind)
        self._call(_SOLVE, np.ascontiguousarray(rhs, self._kind), solution)
        return np.asarray(solution, np.float64)

    def _call(self, phase: int, rhs: Any, solution: Any) -> None:
        before = self._threads(1) if self._size < PARALLEL else None
        error = self._pardiso(phase, (_address(self._values), *self._pattern), rhs, solution)
        if before is not None:
            self._threads(before)
        if error == -4:
            raise NotPositiveDefinite("the tangent is not positive definite")
        if error == -2:
            raise EtextileError("not enough memory to factorise the tangent; take a larger fabric.coarsening")
        if error != 0:
            raise EtextileError(f"PARDISO stopped with error {error} in phase {phase}")


class MixedPardiso:
    """PARDISO in single precision, which takes half the memory traffic; every answer is checked in double.

    Directions of a Newton method may be a little off as long as its residual, always in double, falls. An answer whose
    residual is more than `ALLOWED` of its right-hand side, or a matrix that only rounding makes indefinite, is done
    again in double. Once double agrees that a matrix is indefinite, the next refusals are believed.
    """

    name = "pardiso"

    def __init__(self, pattern: Pattern, points: Array) -> None:
        """Analyse the pattern; raises ImportError where oneMKL is missing."""
        self._pattern, self._points = pattern, points
        self._single = Pardiso(pattern, points, single=True)
        self._double: Pardiso | None = None
        self._values = np.empty(0)
        self._exact = self._agreed = False

    def factorise(self, values: Array) -> None:
        """Numerical factorisation; raises NotPositiveDefinite."""
        self._values = values
        self._exact = False
        try:
            self._single.factorise(values)
        except NotPositiveDefinite:
            if self._agreed:
                raise
            self._in_double()
        self._agreed = False

    def solve(self, rhs: Array) -> Array:
        """Forward and backward substitution."""
        if self._exact and self._double is not None:
            return self._double.solve(rhs)
        answer = self._single.solve(rhs)
        pattern = self._pattern
        left = kernels.unsolved(pattern.indptr, pattern.indices, self._values, answer, rhs)
        if left <= ALLOWED**2 * float(rhs @ rhs):
            return answer
        return self._in_double().solve(rhs)

    def _in_double(self) -> Pardiso:
        """Factorise the present values in double."""
        self._double = self._double or Pardiso(self._pattern, self._points)
        try:
            self._double.factorise(self._values)
        except NotPositiveDefinite:
            self._agreed = True
            raise
        self._exact = True
        return self._double


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


class _Call:
    """The arguments of oneMKL's PARDISO for one factorisation: what stays as it is is looked up once.

    The addresses of a dozen arrays take longer to find than a small system takes to be solved.
    """

    def __init__(self, routine: Any, handle: NDArray[np.int64], size: int, iparm: NDArray[np.int32]) -> None:
        """Take the arrays that every call shares."""
        number = ctypes.c_int32
        self._routine, self._kept = routine, (handle, iparm)
        self._phase, self._error = number(0), number(0)
        one, of = ctypes.byref(number(1)), ctypes.byref
        self._begin = (_address(handle), one, one, of(number(2)), of(self._phase), of(number(size)))
        self._end = (_address(_NO_ORDER), one, _address(iparm), of(number(0)))

    def __call__(self, phase: int, matrix: Any, rhs: Any, solution: Any) -> int:
        """Call oneMKL with the addresses of values, row starts and columns; return its error code."""
        self._phase.value = phase
        self._error.value = 0
        self._routine(*self._begin, *matrix, *self._end, _address(rhs), _address(solution), ctypes.byref(self._error))
        return self._error.value


def _address(values: Any) -> ctypes.c_void_p:
    """Return where an array begins."""
    return ctypes.c_void_p(values.ctypes.data)


def _release(call: _Call) -> None:
    """Give oneMKL's memory of one factorisation back."""
    none, nothing = np.zeros(1, dtype=np.int32), np.zeros(1)
    call(_RELEASE, (_address(nothing), _address(none), _address(none)), nothing, nothing)


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


def _pardiso_for(pattern: Pattern, points: Array) -> LinearSolver:
    """Return PARDISO with the precision that suits the size; raises ImportError where oneMKL is missing."""
    return MixedPardiso(pattern, points) if pattern.size >= MIXED else Pardiso(pattern, points)


LINEAR_SOLVERS: Registry[Callable[[Pattern, Array], LinearSolver]] = Registry("linear solver")
LINEAR_SOLVERS.register("band", BandCholesky)
LINEAR_SOLVERS.register("pardiso", _pardiso_for)
LINEAR_SOLVERS.register("superlu", SuperLU)


def make_linear_solver(name: str, pattern: Pattern, points: Array) -> LinearSolver:
    """Return the named solver; `auto` takes what is quickest: a band, PARDISO, or SuperLU where oneMKL is missing."""
    if name != "auto":
        return LINEAR_SOLVERS[name](pattern, points)
    if suits(pattern, points):
        return BandCholesky(pattern, points)
    try:
        return _pardiso_for(pattern, points)
    except (ImportError, OSError):  # no oneMKL, or one that does not load
        return SuperLU(pattern, points)
