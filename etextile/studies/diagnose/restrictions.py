"""What a comparison or diagnosis was kept from looking at: a verdict holds within these limits and no further."""

from __future__ import annotations

from collections.abc import Sequence

from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.predict.run_tables import Candidate


def restrictions(
    every: Sequence[Candidate], among: Sequence[str], unusable: Sequence[str], *, own_fabric: bool, tensile: bool
) -> tuple[str, ...]:
    """Return one sentence per limit, empty when there is none.

    `every`: all effects there are; `among`: names a person chose from them, all when empty; `unusable`: sentences on
    effects that make no sense in the case; `tensile`: coupons were measured.
    """
    found = []
    if among and every:
        out = [item.card.id for item in every if item.card.id not in among]
        names = ", ".join(dict.fromkeys(among))
        left = f"; {', '.join(out)} could not be named, whatever they would explain" if out else ""
        found.append(f"only {names} could be named (--among){left}")
    if own_fabric and tensile:
        found.append("the coupons that were measured are not used, the fabric is the case's own (--fabric case)")
    return (*found, *unusable)


def unused_tests(measured: Measurements) -> tuple[str, ...]:
    """Return one sentence when there is more than the test of the case, which is all that is looked at."""
    names = [f"{test.name!r}" for test in measured.tests]
    names += ["the ways back of the punch"] if measured.punch_unloading else []
    return (f"only the test of the case is looked at, not {', '.join(names)}",) if names else ()
