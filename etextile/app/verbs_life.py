"""The verb life: how long specimens last, from what was seen of their failures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

import etextile as et
from etextile.app.options import Quiet
from etextile.errors import BadInput


LifeFile = Annotated[Path, Parameter(name="LIFE", help="CSV with lives, or with readings of resistance over cycles.")]


def life(
    file: LifeFile,
    /,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("out/life"),
    required_cycles: Annotated[float | None, Parameter(show_default=False)] = None,
    confidence: Annotated[float, Parameter(validator=Number(gte=0.5, lt=1))] = 0.95,
    mode: Annotated[str | None, Parameter(show_default=False)] = None,
    limit_ratio: Annotated[float | None, Parameter(show_default=False, validator=Number(gt=1))] = None,
    limit_ohm: Annotated[float | None, Parameter(show_default=False, validator=Number(gt=0))] = None,
    confirm: Annotated[int, Parameter(validator=Number(gte=1))] = 3,
    agreed: Annotated[Path | None, Parameter(show_default=False)] = None,
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    quiet: Quiet = False,
) -> int:
    """Fit lives per area: Weibull and lognormal with censoring, B10 with bounds, survival without a distribution.

    Columns: specimen, cycles_low (last seen whole), cycles_high (first seen failed; the same when the cycle is known,
    empty when it never failed), and area, event, mode if any. Or readings: specimen, cycle, resistance_ohm.

    Parameters
    ----------
    output
        Folder for life.json and life.png.
    required_cycles
        Cycles the product must last; gives P(life below it).
    confidence
        Of all bounds, by the likelihood ratio.
    mode
        The failure mode to judge; failures of other modes count as lives that go on.
    limit_ratio
        Event rule for readings: resistance above so many times the first reading.
    limit_ohm
        Event rule for readings: resistance above so many ohm.
    confirm
        So many readings in a row confirm the event.
    agreed
        YAML file with what user and supplier agreed on (conditioning, event, sample size, ...).
    force
        Overwrite the results in the folder.
    """
    from etextile.life.events import EventRule

    rule = None
    if limit_ratio is not None or limit_ohm is not None:
        if limit_ratio is not None and limit_ohm is not None:
            raise BadInput.of("give one of --limit-ratio and --limit-ohm")
        rule = EventRule(limit_ohm, limit_ratio, confirm)
    found = et.life(
        file, output, required_cycles=required_cycles, confidence=confidence, mode=mode, rule=rule, agreed=agreed,
        force=force,
    )  # fmt: skip
    if not quiet:
        print(et.summary(found))
    return 0
