"""Cyclic life of the loops by Coffin and Manson, with coefficients that only the user can give.

    strain range / 2 = coefficient (2 cycles)^exponent

Thin copper has exponents of about -0.5 to -0.7; no coefficient for the wires of such fabrics is published, so there is
no default. The range is the whole swing of the wire's strain in a loop, as if the wire were pushed back as far as it
was pulled: an upper bound, since a thin wire buckles instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from etextile.types import Array
from wires.history import WireHistory


@dataclass(frozen=True)
class CoffinManson:
    """Coefficient (fatigue ductility) and exponent (negative), and where they come from."""

    coefficient: float
    exponent: float
    source: str

    def cycles(self, strain_range: Array) -> Array:
        """Return the cycles to failure (n,); infinite where nothing swings."""
        with np.errstate(divide="ignore"):
            reversals = (0.5 * np.asarray(strain_range) / self.coefficient) ** (1.0 / self.exponent)
        return np.asarray(0.5 * reversals)


def repeats(displacement_mm: Array) -> bool:
    """Tell whether a path goes back somewhere."""
    return bool((np.diff(displacement_mm) < 0.0).any())


def strain_range(history: WireHistory) -> Array:
    """Return the swing (L,) of the wire's strain after the path's first turn; its greatest strain without a turn."""
    turn = int(np.argmax(np.append(np.diff(history.displacement_mm) < 0.0, True)))
    part = history.wire_strain[turn:] if repeats(history.displacement_mm) else history.wire_strain
    return np.asarray(part.max(axis=0, initial=0.0) - part.min(axis=0, initial=np.inf))


def cyclic_life(history: WireHistory, law: CoffinManson) -> dict[str, Any]:
    """Return the entry of the report: the law with its source, and range and cycles of every loop."""
    layout = history.layout
    ranges = strain_range(history)
    cycles = law.cycles(ranges)
    loops = [
        {
            "wire": layout.loop_wire[loop],
            "loop": layout.loop_index[loop],
            "strain_range": ranges[loop],
            "cycles": cycles[loop],
        }
        for loop in range(layout.n_loops)
    ]
    return {
        "coefficient": law.coefficient,
        "exponent": law.exponent,
        "source": law.source,
        "measured_on": "the path's own cycles" if repeats(history.displacement_mm) else "loading to depth and back",
        "shortest_cycles": cycles.min(initial=np.inf),
        "loops": loops,
    }
