"""The verb calibrate: parameters of a case from any test it describes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import etextile as et
from etextile.app.options import AllowCode, CaseName, Overrides, Quiet, Verbose


Measured = Annotated[str, Parameter(help="Folder with measured.yaml, or the name of a shipped one.")]
Free = Annotated[
    str, Parameter(help="Parameters to fit, separated by commas: fabric.warp.H, effects.ID.NAME, measured.centre.x.")
]
Output = Annotated[Path, Parameter(name=["--output", "-o"], help="Fabric file to write; .json and .png go beside it.")]


def calibrate(
    case: CaseName,
    /,
    *,
    measured: Measured,
    free: Free,
    output: Output = Path("fabric.yaml"),
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    prior: bool = True,
    held_out: bool = True,
    finer: bool = True,
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Fit parameters of a case to measurements of the test that it describes.

    Parameters
    ----------
    prior
        Count standard deviations that the fabric states as known before.
    held_out
        Leave out specimens (or the upper third of the loads of one) in turn and predict them.
    finer
        Repeat on a finer lattice and put what it changes into the covariance.
    force
        Overwrite a fabric file that calibrate did not write.
    """

    def tell(text: str) -> None:
        if not quiet:
            print(text, file=sys.stderr)

    keys = tuple(key.strip() for key in free.split(",") if key.strip())
    found = et.calibrate(
        et.load(case, overrides, allow_code=allow_code), measured, free=keys, output=output, prior=prior,
        held_out=held_out, finer=finer, force=force, tell=tell,
    )  # fmt: skip
    if not quiet:
        print(et.summary(found))
    return 0
