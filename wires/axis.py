"""What a report runs over: the displacement of a punch or clamp and its force, or the angle of a joint and its moment.

Whoever shows a report asks here, so that no page speaks of millimetres where a joint bends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Axis:
    """Names, units and keys of a motion and of what it works against; `block` is their place in the report."""

    block: str
    name: str
    unit: str
    key: str
    response: str
    response_unit: str
    response_key: str
    failure_key: str
    """Key of where the first filament of a loop, piece or wire breaks."""

    def values(self, report: Mapping[str, Any]) -> list[float]:
        """Return the motion of every step."""
        return list(report[self.block][self.key])

    def responses(self, report: Mapping[str, Any]) -> list[float]:
        """Return force or moment of every step."""
        return list(report[self.block][self.response_key])


PUNCH = Axis("punch", "displacement", "mm", "displacement_mm", "force", "N", "force_N", "first_failure_mm")
JOINT = Axis("joint", "angle", "deg", "angle_deg", "moment", "N mm", "moment_Nmm", "first_failure_deg")


def axis_of(report: Mapping[str, Any]) -> Axis:
    """Return what a report runs over."""
    return JOINT if "joint" in report else PUNCH


def of_block(block: Mapping[str, Any]) -> Axis:
    """Return what a block with one place on the axis runs over."""
    return JOINT if JOINT.key in block else PUNCH
