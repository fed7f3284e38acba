"""Measurements that a laboratory can make next: what of the case is other in them, what they cost, how they are noisy.

Costs are relative to one more specimen in the set-up that is there: a mark and a rule, a photograph from the side, two
cameras with a pattern, another punch. Noise is that of an ordinary instrument.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from etextile.diagnose.workflow import Diagnosis
from etextile.studies.diagnose.ordinary import COST, NOISE
from etextile.vocabulary import CLAMP, EDGE, FORCE, STRAIN
from loadcases.schema import Case


UNLOADING = "punch_unloading"
RADII = (25.0, 15.0, 8.0)
"""Radii of spheres that laboratories have, mm: the first that differs enough from the case's and fits is taken."""
UNLIKE, FITS = 1.5, 0.5
"""Least ratio of two radii that are other, and largest share of the half specimen that a sphere may take."""
SLOWER = 0.1
DOWN_TO = 0.6
"""Share of the largest displacement down to which a way back is measured."""


@dataclass(frozen=True)
class CatalogueTest:
    """A measurement of the catalogue.

    `case`: what is other in the case; `without`: effects that cannot act; `noise`: standard deviation, None for what
    the force was measured with; `back`: the way back; `other`: whether the force itself has to be run anew.
    """

    id: str
    channel: str
    words: str
    cost: float
    noise: float | None = None
    case: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    back: bool = False


def catalogue(case: Case, diagnosis: Diagnosis, ids: Sequence[str]) -> tuple[CatalogueTest, ...]:
    """Return the measurements that can be made and have not been; `ids`: effects that are to be told apart."""
    done = {item.test for item in diagnosis.rounds}
    have = {*diagnosis.bench.points.channels, *(channel for item in diagnosis.rounds for channel in item.channels)}
    return tuple(item for item in _all(case, ids) if item.id not in done and item.channel not in have - {FORCE})


def _all(case: Case, ids: Sequence[str]) -> Iterator[CatalogueTest]:
    yield CatalogueTest("unloading", UNLOADING, "record the force on the way back of the punch as well", 1.0, back=True)
    if "x_max" in case.supports.clamped:
        yield CatalogueTest(
            "clamp_line", CLAMP, "a mark at the clamp line, read with a rule", COST[CLAMP], NOISE[CLAMP]
        )
    if "y_max" not in case.supports.clamped:
        yield CatalogueTest("free_edge", EDGE, "photographs of the free edge from the side", COST[EDGE], NOISE[EDGE])
    yield CatalogueTest(
        "strain_field", STRAIN, "the strain field by two cameras and a pattern", COST[STRAIN], NOISE[STRAIN]
    )
    radius = other_radius(case)
    if radius is not None:
        yield CatalogueTest(
            "second_radius", FORCE, f"a punch of {radius:g} mm radius", 3.0, case=(f"body.radius={radius:g} mm",)
        )
    if "punch_friction" in ids:
        yield CatalogueTest("lubricated", FORCE, "a lubricated punch", 1.5, without=("punch_friction",))
    if "rate_dependence" in ids:
        speed = SLOWER * case.motion.speed
        yield CatalogueTest("slower", FORCE, f"the same test at {speed:g} mm/s", 1.5, case=(f"motion.speed={speed:g}",))


def other_radius(case: Case) -> float | None:
    """Return the radius of another sphere that fits the specimen, mm; None where the body is no sphere."""
    own = getattr(case.body, "radius", None) if case.body is not None and case.body.type == "sphere" else None
    if own is None:
        return None
    most = FITS * 0.5 * min(case.pattern) * 1.0001
    fitting = [r for r in RADII if r <= most and not 1.0 / UNLIKE < r / float(own) < UNLIKE]
    return fitting[0] if fitting else None
