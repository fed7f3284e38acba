"""Arcs of joints in daily life that a case can name as its history, each with its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Arc:
    """Turning points of one cycle, deg, what it is, and where that is from."""

    angle_deg: tuple[float, ...]
    description: str
    source: str


ARCS: Mapping[str, Arc] = {
    "elbow_daily": Arc(
        (130.0, 30.0, 130.0),
        "elbow, most activities of daily living",
        "Morrey, Askew, Chao, J. Bone Joint Surg. Am. 63 (1981) 872: a functional arc of 30 to 130 deg",
    ),
    "knee_gait": Arc((60.0, 0.0, 60.0), "knee, level walking", "about 0 to 60 deg, the swing phase of gait analysis"),
    "knee_sitting": Arc(
        (95.0, 0.0, 95.0), "knee, sitting down", "about 0 to 95 deg, rising from and sitting on a chair"
    ),
}
