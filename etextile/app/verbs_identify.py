"""The verb identify: tensile curves in, fabric file and check plots out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

import etextile as et
from etextile.app.options import Quiet, Verbose
from etextile.app.reading import NOTHING, GaugeLength, MachineStiffness, Said, Thickness, Width, coupon_size
from etextile.errors import BadInput


def _files(direction: str) -> Parameter:
    """Return the option that lists the files of one direction."""
    return Parameter(negative="", consume_multiple=True, show_default=False, help=f"CSV files of coupons {direction}.")


Measured = Annotated[
    Path | None,
    Parameter(name="MEASURED", show_default=False, help="Folder with a measured.yaml that has a tensile channel."),
]
Output = Annotated[Path, Parameter(name=["--output", "-o"], help="Fabric file to write; the check plots go beside it.")]
Warp = Annotated[tuple[Path, ...], _files("pulled along the warp, instead of a folder")]
Weft = Annotated[tuple[Path, ...], _files("pulled along the weft")]
Bias = Annotated[tuple[Path, ...], _files("pulled at 45 degrees; alone, of known size, they give a shear law")]
FabricName = Annotated[
    str, Parameter(help="Named fabric or file with the weave; lends families that were not measured.")
]
ModulusFrom = Annotated[
    str | None,
    Parameter(
        show_default=False, help="Fabric, by name or file, that lends E where nothing unloads [default: the same]."
    ),
]
Way = Annotated[
    Literal["consistent", "paper"],
    Parameter(help="consistent: the law's own curve; paper: its straight-line fits, all strain counted plastic."),
]
KeepOutliers = Annotated[
    bool, Parameter(negative="", show_default=False, help="Use specimens that lie far from the others too.")
]
Refine = Annotated[
    bool,
    Parameter(
        negative="",
        show_default=False,
        help="Adjust the laws until virtual coupons, not single trusses, return the curves.",
    ),
]
StrainFrom = Annotated[
    Literal["specimen", "crosshead"] | None,
    Parameter(
        show_default=False,
        help="Where strain was measured; not said, or crosshead: what the machine gives is in the intervals.",
    ),
]
Strips = Annotated[int, Parameter(help="With --refine: so many strips side by side make up the width of a coupon.")]
Coarsening = Annotated[
    float | None,
    Parameter(show_default=False, help="With --refine: of the virtual coupons [default: 17 cells across, at least 1]."),
]
Force = Annotated[
    bool, Parameter(negative="", show_default=False, help="Overwrite a fabric file that identify did not write.")
]


def identify(
    measured: Measured = None,
    /,
    *,
    output: Output = Path("fabric.yaml"),
    warp: Warp = (),
    weft: Weft = (),
    bias: Bias = (),
    fabric: FabricName = "estimated_mid",
    modulus_from: ModulusFrom = None,
    procedure: Way = "consistent",
    width: Width = None,
    thickness: Thickness = None,
    gauge_length: GaugeLength = None,
    machine_stiffness: MachineStiffness = None,
    strain_from: StrainFrom = None,
    reading: Annotated[Said, Parameter(name="*")] = NOTHING,
    keep_outliers: KeepOutliers = False,
    refine: Refine = False,
    strips: Strips = 1,
    coarsening: Coarsening = None,
    force: Force = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Identify fabric parameters from tensile curves, write a fabric file and check plots.

    Bias coupons alone, of known size, give a shear law, and the curves of other
    sizes that it foretells.
    """
    from etextile.app.progress import Progress
    from etextile.studies.identify.identify import check_output, curves_of, read_lists
    from etextile.studies.identify.refine import work

    check_output(output, force=force)
    _check_refinement(refine, strips=strips, coarsening=coarsening)
    files = {"warp": warp, "weft": weft, "bias": bias}
    if (measured is None) == (not any(files.values())):
        raise BadInput.of("give either a folder of measurements or lists of files with --warp, --weft, --bias")
    if measured is not None:
        if reading != NOTHING or strain_from is not None or machine_stiffness is not None:
            raise BadInput.of("how files of a folder are read stands in its measured.yaml; give these with --warp ...")
        title, curves = curves_of(measured)
    else:
        size = coupon_size(
            width=width, thickness=thickness, gauge_length=gauge_length, machine_stiffness=machine_stiffness
        )
        on_specimen = strain_from == "specimen"
        title = output.stem
        curves = read_lists(files, size=size, options=reading.options(), on_specimen=on_specimen)
    with Progress("refine", total=work(len(curves)), quiet=quiet or not refine) as progress:
        result = et.identify(
            curves,
            output,
            title=title,
            fabric=fabric,
            modulus_from=modulus_from,
            procedure=procedure,
            keep_outliers=keep_outliers,
            refine=refine,
            strips=strips,
            coarsening=coarsening,
            force=force,
            watch=progress.advance,
        )
    if not quiet:
        print(et.summary(result))
    return 0


def _check_refinement(refine: bool, *, strips: int, coarsening: float | None) -> None:
    """Refuse options of the virtual coupons that make no sense, or that nothing would come of."""
    if strips < 1:
        raise BadInput.of(f"out of range (got {strips}), must be 1 or more", key="--strips")
    if coarsening is not None and not 1.0 <= coarsening < float("inf"):
        raise BadInput.of(f"out of range (got {coarsening:g}), must be 1 or more", key="--coarsening")
    if not refine and (strips != 1 or coarsening is not None):
        raise BadInput.of("these belong to virtual coupons: add --refine", key="--strips, --coarsening")
