"""The verb inspect: what would be read of a measured file or a mesh, with a picture."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

import etextile as et
from etextile.app.options import Quiet
from etextile.app.reading import NOTHING, GaugeLength, Said, Thickness, Width, coupon_size
from etextile.errors import BadInput


Channel = Annotated[
    str | None,
    Parameter(show_default=False, help="Channel of measured.yaml it is meant for [default: found by its columns]."),
]
Picture = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], show_default=False, help="Picture (PNG) of what is read; '-o none' draws none "
              "[default: FILE_read.png here]."),
]  # fmt: skip


def inspect(
    file: Annotated[
        Path, Parameter(name="FILE", help="Measured file, mesh (.stl, .obj, .ply, .3mf), or measured folder.")
    ],
    /,
    *,
    output: Picture = None,
    channel: Channel = None,
    width: Width = None,
    thickness: Thickness = None,
    gauge_length: GaugeLength = None,
    scale: Annotated[float, Parameter(help="Of a mesh: factor to millimetres.")] = 1.0,
    reading: Annotated[Said, Parameter(name="*")] = NOTHING,
    format_: Annotated[Literal["text", "json"], Parameter(name="--format")] = "text",
    quiet: Quiet = False,
) -> int:
    """Show what would be read of a machine's export or of a mesh: dialect, columns, rows left out and why, a picture.

    Of a folder with a measured.yaml: every file in it, read as it says there. The exit code is 2, with the reason, when
    identify, compare, diagnose or run would refuse the file.
    """
    if file.is_dir():
        return _folder(file, as_json=format_ == "json", quiet=quiet)
    picture = None if output == Path("none") else output or Path(f"{file.stem or 'file'}_read.png")
    size = coupon_size(width=width, thickness=thickness, gauge_length=gauge_length)
    found = et.inspect(file, picture, channel=channel, options=reading.options(), size=size, scale=scale)
    if format_ == "json":
        from etextile.studies.inspect import as_json

        print(json.dumps(as_json(found), indent=2, ensure_ascii=False))
    elif not quiet:
        from etextile.app.show import show
        from etextile.text.inspect import inspection

        show(inspection(found))
        if picture is not None and picture.is_file():
            print(f"wrote {picture}")
    sys.stdout.flush()
    if found.problems:
        raise BadInput(found.problems)
    return 0


def _folder(folder: Path, *, as_json: bool, quiet: bool) -> int:
    """Print what would be read of a folder of measurements."""
    found = et.inspect_folder(folder)
    if as_json:
        from etextile.studies.inspect_folder import folder_as_json

        print(json.dumps(folder_as_json(found), indent=2, ensure_ascii=False))
    elif not quiet:
        from etextile.app.show import show
        from etextile.text.inspect import folder_inspection

        show(folder_inspection(found))
    sys.stdout.flush()
    if found.problems:
        raise BadInput(found.problems)
    return 0
