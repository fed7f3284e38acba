"""What every wire and loop went through during a run: one object from the increments and the result file to the judge.

Results hold it, criteria look at nothing else; what it means for a wire is the business of `wires`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from etextile.results.wire_layout import WireLayout
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class WireHistory:
    """Strain histories of the wires over S steps, L loops and K embedded wire elements (engineering strains).

    The first step is the undeformed fabric. The displacement may go up and down (load, unload, load again).
    """

    displacement_mm: Array
    """(S,) travel of the punch or of the moved edge."""
    span_strain: Array
    """(S, L) strain of the fabric span from a loop's exit to its entry."""
    wire_strain: Array
    """(S, L) strain of the free wire in the loop after its slack is taken up; 0 while it is slack."""
    element_wire: IntArray
    """(K,) wire of each embedded element."""
    element_warp_mm: Array
    """(K,) warp coordinate of the element's middle."""
    element_strain: Array
    """(S, K) strain of the embedded wire elements."""
    layout: WireLayout
    element_along_mm: Array | None = None
    """(K,) coordinate along its wire of the element's middle; the warp coordinate when it is left out."""
    element_length_mm: Array | None = None
    """(K,) length of path each element covers; rebuilt from the middles when it is left out."""

    @classmethod
    def from_flat(
        cls,
        displacement_mm: Array,
        strains: Mapping[str, Array],
        *,
        layout: WireLayout,
        elements: Mapping[str, Any],
        begins: float | None = None,
    ) -> WireHistory:
        """Return the history of output steps (S,) with the flat fabric as its first step.

        strains: span_strain, wire_strain (S, L), element_strain (S, K); elements: the arrays element_* (K,). The flat
        fabric stands at `begins`: at 0, or where the first step is of a piece that is put on first.
        """
        first = min((0.0, *displacement_mm[:1])) if begins is None else begins
        rows = {name: np.concatenate([np.zeros((1, values.shape[1])), values]) for name, values in strains.items()}
        return cls(displacement_mm=np.concatenate([[first], displacement_mm]), layout=layout, **rows, **elements)

    def __post_init__(self) -> None:
        """Refuse arrays that do not fit together."""
        steps, loops, elements = self.displacement_mm.size, self.layout.n_loops, self.element_wire.size
        expected = {
            "span_strain": (steps, loops),
            "wire_strain": (steps, loops),
            "element_warp_mm": (elements,),
            "element_strain": (steps, elements),
        }
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}, expected {shape}")

    @property
    def n_steps(self) -> int:
        """Number of steps S."""
        return int(self.displacement_mm.size)

    @property
    def max_span_strain(self) -> Array:
        """(L,) greatest span strain over the run."""
        return np.asarray(self.span_strain.max(axis=0, initial=0.0))

    @property
    def max_wire_strain(self) -> Array:
        """(L,) greatest strain of the free wire over the run."""
        return np.asarray(self.wire_strain.max(axis=0, initial=0.0))

    def until(self, displacement_mm: float) -> WireHistory:
        """Return the history up to the first time `displacement_mm` is reached, interpolated to end exactly there.

        The whole history is returned when it is never passed; a value below the start gives the first step alone.
        """
        beyond = np.flatnonzero(self.displacement_mm > displacement_mm)
        if not beyond.size:
            return self
        last = int(beyond[0])
        if last == 0:
            return self._take(slice(0, 1), last, 0.0)
        low, high = self.displacement_mm[last - 1], self.displacement_mm[last]
        return self._take(slice(0, last + 1), last, float((displacement_mm - low) / (high - low)))

    def _take(self, steps: slice, last: int, weight: float) -> WireHistory:
        """Return the given steps, the last one moved to `weight` of the way from its predecessor."""

        def cut(values: Array) -> Array:
            part = values[steps].copy()
            if last > 0:
                part[-1] = (1.0 - weight) * values[last - 1] + weight * values[last]
            return part

        return replace(
            self,
            displacement_mm=cut(self.displacement_mm),
            span_strain=cut(self.span_strain),
            wire_strain=cut(self.wire_strain),
            element_strain=cut(self.element_strain),
        )
