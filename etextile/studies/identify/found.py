"""What an identification found: laws and fabric, and how virtual coupons changed them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from etextile.identify.refine import Refined, TargetCurve
from etextile.identify.result import IdentifiedFabric
from etextile.identify.virtual import Coupon
from etextile.types import Array
from loadcases.fabric import Fabric


@dataclass(frozen=True)
class Refinement:
    """What refinement found: coupons by family, targets, refined laws, and the direct use judged over strain.

    `direct`: measured curve as fitted, and relative departure (n,) from it of the coupon with the direct laws.
    """

    coupons: dict[str, Coupon]
    targets: dict[str, TargetCurve]
    refined: Refined
    direct: dict[str, tuple[TargetCurve, Array]]


@dataclass(frozen=True)
class Identification:
    """What `identify` found and wrote: the result, the fabric as a file holds it, title and base fabric, the files."""

    identified: IdentifiedFabric
    fabric: Fabric
    title: str
    base: str
    fabric_file: Path | None = None
    figures: tuple[Path, ...] = ()
    refinement: Refinement | None = None
