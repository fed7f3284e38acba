"""Elements that bear in one sense only: yarns that pull and do not push, bodies that push and do not pull.

The interior-point solver lifts the kink between bearing and idle by giving each element a stretch t > 0 of its own
beside the stretch g(x) of the geometry, and a slack s = t - g(x) >= 0 with force F(t) s = mu; mu = 0 is the law itself.
What it must know of the elements for that is in this file; how they are driven to mu = 0 is the solver's matter.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from etextile.types import Array, IntArray


class OneSided(ABC):
    """The n one-sided elements of a contribution at one trial, in place of its own gradient and tangent.

    stretch (n,) mm: of the geometry, negative where an element is slack or apart; stiffness (n,) N/mm: about F / t.
    """

    stretch: Array
    stiffness: Array

    @abstractmethod
    def bear(self, stretch: Array) -> tuple[Array, Array]:
        """Return force N and its slope N/mm at stretches (n,), all positive."""

    @abstractmethod
    def add_gradient(self, force: Array, gradient: Array) -> None:
        """Add the gradient of the whole contribution when its elements bear `force` (n,) to `gradient` (P, 3)."""

    @abstractmethod
    def add_tangent(
        self, force: Array, along: Array, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float
    ) -> None:
        """Add the tangent at forces (n,) N that grow by `along` (n,) N/mm with the stretch of the geometry."""

    @abstractmethod
    def rate(self, step: Array) -> Array:
        """Return the change (n,) of the stretch along `step` (P, 3), to first order."""

    @abstractmethod
    def bulge(self, step: Array, rate: Array) -> Array:
        """Return what the stretch changes beyond `rate` (n,) along `step`, by the turn of the elements."""

    def add_skew(self, along: Array, step: Array, load: Array) -> bool:
        """Add what the tangent leaves out because it is not symmetric, times `step` (P, 3), to `load` (P, 3).

        Returns whether there is anything of the kind (friction that follows the normal force).
        """
        return False

    def follow(self, before: Any, step: Array) -> None:  # noqa: B027 (most elements remember nothing)
        """Take over from the trial before, `step` (P, 3) ago, what the elements remember within a solve."""
