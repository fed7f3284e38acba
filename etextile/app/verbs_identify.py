"""The verb identify: tensile curves in, fabric file and check plots out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from etextile.app.options import Quiet, Verbose
from etextile.errors import BadInput


Curves = Annotated[tuple[Path, ...], Parameter(negative="", consume_multiple=True, show_default=False)]
Length = Annotated[str | None, Parameter(show_default=False)]


def identify(
    measured: Annotated[Path | None, Parameter(name="MEASURED", show_default=False)] = None,
    /,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("fabric.yaml"),
    warp: Curves = (),
    weft: Curves = (),
    bias: Curves = (),
    fabric: str = "estimated_mid",
    modulus_from: Annotated[str | None, Parameter(show_default=False)] = None,
    procedure: Literal["consistent", "paper"] = "consistent",
    width: Length = None,
    thickness: Length = None,
    gauge_length: Length = None,
    columns: Annotated[str | None, Parameter(show_default=False)] = None,
    keep_outliers: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Identify fabric parameters from tensile curves, write a fabric file and check plots.

    Parameters
    ----------
    measured
        Folder with measured.yaml that has a tensile channel.
    output
        Fabric file to write; the check plots go beside it.
    warp
        CSV files (strain,stress_MPa or displacement_mm,force_N) of coupons pulled along the warp, instead of a folder.
    weft
        The same along the weft.
    bias
        The same at 45 degrees.
    fabric
        Named fabric or file with the weave; lends families that were not measured.
    modulus_from
        Named fabric or file that lends E where nothing unloads [default: the fabric].
    procedure
        consistent: the law's own curve; paper: the straight-line fits of the paper, all strain counted plastic.
    width
        Width of the coupons, for force and displacement.
    thickness
        Thickness of the coupons, for force and displacement.
    gauge_length
        Gauge length of the coupons, for force and displacement.
    columns
        Columns of files without a header line, as in displacement_mm,force_N.
    keep_outliers
        Use specimens that lie far from the others too.
    force
        Overwrite a fabric file that identify did not write.
    """
    from etextile.app.identify import check_output, curves_of, read_lists, write
    from etextile.app.identify import identify as run

    check_output(output, force=force)
    files = {"warp": warp, "weft": weft, "bias": bias}
    if (measured is None) == (not any(files.values())):
        raise BadInput.of("give either a folder of measurements or lists of files with --warp, --weft, --bias")
    if measured is not None:
        title, curves = curves_of(measured)
    else:
        size = _size(width=width, thickness=thickness, gauge_length=gauge_length)
        names = tuple(columns.split(",")) if columns else ()
        title, curves = output.stem, read_lists(files, size=size, columns=names)
    result = write(
        run(
            curves,
            title=title,
            fabric=fabric,
            modulus_from=modulus_from,
            procedure=procedure,
            keep_outliers=keep_outliers,
        ),
        output,
        force=force,
    )
    if not quiet:
        print(result.text)
        print("\n".join(f"wrote {path}" for path in (result.fabric_file, *result.figures)))
    return 0


def _size(*, width: str | None, thickness: str | None, gauge_length: str | None):  # type: ignore[no-untyped-def]
    """Return the size of the coupons from options with units, or None when there are none."""
    from etextile.identify.curves import CouponSize
    from etextile.units import to_number

    given = {"--width": width, "--thickness": thickness, "--gauge-length": gauge_length}
    if not any(given.values()):
        return None
    missing = [name for name, text in given.items() if text is None]
    if missing:
        raise BadInput.of(f"width, thickness and gauge length belong together, {', '.join(missing)} is missing")
    values = []
    for name, text in given.items():
        try:
            values.append(to_number(text or "", "mm"))
        except ValueError as error:
            raise BadInput.of(str(error), key=name) from error
        if values[-1] <= 0.0:
            raise BadInput.of(f"out of range (got {text}), must be above 0 mm", key=name)
    return CouponSize(*values)
