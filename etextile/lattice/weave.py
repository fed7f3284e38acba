"""The weave behind the lattice: what one fabric cell is and how much material it stands for.

A fabric cell is `cell_warp` long along the warp and `cell_weft` along the weft; its four sides and two diagonals are
trusses of area `truss_area` (Beex et al., section 4.1). A fabric stress refers to the nominal thickness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


WARP, WEFT, DIAGONAL, WIRE = 0, 1, 2, 3
"""Numbers of the truss families: places in `etextile.vocabulary.FAMILIES`."""
LAND = 4
"""Family of what trusses of the lattice become under a part; results have no place for it."""


@dataclass(frozen=True)
class Weave:
    """Geometry of one fabric cell (mm, mm2) and yarn densities (1/mm)."""

    cell_warp: float
    cell_weft: float
    thickness: float
    truss_area: float
    warp_density: float
    weft_density: float

    @property
    def cell_diagonal(self) -> float:
        """Length of a diagonal, mm."""
        return math.hypot(self.cell_warp, self.cell_weft)

    @property
    def nominal_area(self) -> tuple[float, float, float]:
        """Fabric cross-section that one warp, weft and diagonal truss stands for, mm2 (paper, equation 5).

        The diagonal's spacing is the cell area over the diagonal's length.
        """
        across = self.cell_warp * self.cell_weft / self.cell_diagonal
        return (self.cell_weft * self.thickness, self.cell_warp * self.thickness, across * self.thickness)
