"""The verb layout: what is drawn of wires and parts, listed or written as a drawing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import etextile as et
from etextile.app.options import AllowCode, CaseName, Overrides, Quiet


def layout(
    case: CaseName,
    /,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"], show_default=False)] = None,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    quiet: Quiet = False,
) -> int:
    """List the wires, loops and parts of a case, or write them as a drawing.

    Parameters
    ----------
    output
        Drawing to write, .dxf or .csv; without it the wires and parts are listed.
    force
        Overwrite the drawing.
    """
    loaded = et.load(case, overrides, allow_code=allow_code)
    if output is None:
        from etextile.app.show import show
        from etextile.studies.layout import read_layout
        from etextile.text.layout import layout as tables

        show(tables(read_layout(loaded)))
        return 0
    drawn = et.layout(loaded, output, force=force)
    if not quiet:
        from etextile.text.layout import counts

        print(f"{output}: {counts(drawn)}\na case reads it with wires: {{layout: {output}}}")
    return 0
