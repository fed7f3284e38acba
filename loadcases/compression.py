"""How much compressed yarns carry: one share for all trusses, or one for each family.

The trusses of the paper carry nothing (0). A bonded fabric carries compression like tension (1), and in a bias test
yarns between their crossings keep their length while the diagonals, which stand for shear, go slack.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from loadcases.schema_numbers import Share, Strict


class PerFamily(Strict):
    """Compression ratio of each truss family."""

    warp: Share = Field(default=0.0, description="Ratio of the warp trusses.")
    weft: Share = Field(default=0.0, description="Ratio of the weft trusses.")
    diagonal: Share = Field(default=0.0, description="Ratio of the diagonal trusses.")


def _kind(value: Any) -> str:
    """Tell the two forms apart."""
    return "families" if isinstance(value, (dict, PerFamily)) else "all"


Compression = Annotated[Annotated[Share, Tag("all")] | Annotated[PerFamily, Tag("families")], Discriminator(_kind)]


def ratios(compression: float | PerFamily) -> tuple[float, float, float]:
    """Return the compression ratios of warp, weft and diagonal."""
    if isinstance(compression, PerFamily):
        return (compression.warp, compression.weft, compression.diagonal)
    return (compression, compression, compression)
