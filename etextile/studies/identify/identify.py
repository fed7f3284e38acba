"""From tensile curves to a fabric file: read, identify, write fabric.yaml and check plots, return the summary.

What the curves do not tell (geometry of the weave, families without a curve, E without unloading) comes from a named
fabric, and the fabric file says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.files import write_whole
from etextile.identify.curves import CouponSize, TensileCurve, read_curve
from etextile.identify.fit import NamedLaw
from etextile.identify.modulus import Procedure
from etextile.identify.result import FAMILY_OF, IdentifiedFabric, IdentifiedFamily, area_ratios, identify_fabric
from etextile.importers.options import PLAIN, Options
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.found import Identification
from etextile.types import Array
from loadcases.fabric import DEFAULT_FABRIC, Covariance, Fabric, Family, dump_fabric, has_laws, load_base, load_fabric
from loadcases.measured import Measured
from loadcases.measurements import load_measurements
from loadcases.shipped import measured_folder


HEADER = "# Written by etextile identify"


def identify_curves(
    curves: Mapping[str, Sequence[TensileCurve]],
    *,
    title: str,
    fabric: str | Path = DEFAULT_FABRIC,
    modulus_from: str | Path | None = None,
    procedure: Procedure = "consistent",
    keep_outliers: bool = False,
) -> Identification:
    """Identify the directions 'warp', 'weft', 'bias' that have curves; writes nothing.

    `fabric`: named fabric or file that supplies weave and families without curves. `modulus_from`: the one that lends
    E where no specimen unloads (`fabric` by default).
    """
    base = load_base(fabric)
    own = fabric if has_laws(fabric) else DEFAULT_FABRIC
    name = Path(fabric).stem + ("" if own == fabric else f", laws from {DEFAULT_FABRIC}")
    lender = own if modulus_from is None else modulus_from
    identified = identify_fabric(
        curves,
        weave_of(base),
        named=named_laws(load_fabric(lender), Path(lender).stem),
        procedure=procedure,
        keep_outliers=keep_outliers,
    )
    found = _fabric_of(identified, base, title=title, name=name)
    return Identification(identified, found, title, name)


def write(result: Identification, output: Path, *, force: bool = False, plots: bool = True) -> Identification:
    """Write the fabric file and, beside it, the check plots; returns the result with the paths.

    Raises BadInput, before anything is written, when `output` would overwrite a file that `identify` did not write.
    """
    check_output(output, force=force)
    output.parent.mkdir(parents=True, exist_ok=True)
    write_whole(output, f"{HEADER}\n{dump_fabric(result.fabric)}")
    figures: tuple[Path, ...] = ()
    if plots:
        from viz.identify_plots import save_figures

        figures = save_figures(result.identified, output.parent, prefix=f"{output.stem}_")
    if plots and result.refinement is not None:
        from viz.refine_plots import save_refinement

        found = result.refinement
        path = output.parent / f"{output.stem}_refined.png"
        figures = (*figures, save_refinement(found.targets, found.refined, direct=found.direct, path=path))
    return replace(result, fabric_file=output, figures=figures)


def check_output(output: Path, *, force: bool = False) -> None:
    """Refuse an output that is a folder, or a file that `identify` did not write (unless `force`)."""
    if output.is_dir():
        raise BadInput.of("this is a folder, give the fabric file to write, as in -o fabric.yaml", file=str(output))
    if output.suffix not in (".yaml", ".yml"):
        raise BadInput.of("a fabric file ends with .yaml", file=str(output))
    if output.is_file() and not force and not output.read_text(encoding="utf-8", errors="replace").startswith(HEADER):
        raise BadInput.of("not written by identify, so not overwritten without --force", file=str(output))


def curves_of(folder: str | Path) -> tuple[str, Mapping[str, Sequence[TensileCurve]]]:
    """Return title and tensile curves of a folder, or of shipped measurements by name.

    Raises BadInput when there is no tensile channel.
    """
    measured = load_measurements(measured_folder(str(folder)))
    if not measured.tensile:
        channels = ", ".join(measured.channels)
        message = f"no tensile channel in it (it has {channels}), identification needs tensile curves"
        raise BadInput.of(message, file=str(folder))
    return measured.title, measured.tensile


def read_lists(
    files: Mapping[str, Sequence[Path]],
    *,
    size: CouponSize | None = None,
    options: Options = PLAIN,
    on_specimen: bool = False,
) -> dict[str, tuple[TensileCurve, ...]]:
    """Read lists of files by direction, `on_specimen`: strain was measured there; raises BadInput with all problems."""
    problems: list[Problem] = []
    curves: dict[str, tuple[TensileCurve, ...]] = {}
    for direction in FAMILY_OF:
        found = []
        for path in files.get(direction, ()):
            try:
                found.append(read_curve(path, size=size, options=options, on_specimen=on_specimen))
            except BadInput as error:
                problems.extend(error.problems)
        if found:
            curves[direction] = tuple(found)
    if problems:
        raise BadInput(problems)
    return curves


def weave_of(fabric: Fabric) -> Weave:
    """Return the weave of a fabric file."""
    along_warp, along_weft = fabric.cell
    return Weave(along_warp, along_weft, fabric.thickness, fabric.truss_area, fabric.warp_density, fabric.weft_density)


def named_laws(base: Fabric, name: str) -> dict[str, NamedLaw]:
    """Return the laws from which E is taken where no specimen unloads."""
    ratios = area_ratios(weave_of(base))
    laws = {}
    for family in FAMILY_OF.values():
        item: Family = getattr(base, family)
        law = PowerLaw(item.E.value, item.sigma_y0.value, item.H.value, item.n.value, item.e0)
        laws[family] = NamedLaw(name, law, ratios[family], item.strain_range[1])
    return laws


def _fabric_of(identified: IdentifiedFabric, base: Fabric, *, title: str, name: str) -> Fabric:
    """Return the fabric with the identified families; the others stay as in `base` and say so."""
    families = {}
    for family in FAMILY_OF.values():
        found = identified.families.get(family)
        families[family] = (
            _family_of(found, getattr(base, family).compression_ratio)
            if found is not None
            else getattr(base, family).model_copy(update={"estimated": True, "source": f"not measured, from {name}"})
        )
    text = f"Identified from tensile tests by the {identified.procedure} procedure; weave from {name}."
    return base.model_copy(update={"title": f"Identified: {title}", "description": text, **families})


def _family_of(found: IdentifiedFamily, compression_ratio: float) -> Family:
    """Return one family as it stands in a fabric file, numbers to six digits."""
    estimates = {
        name: Measured(value=rounded(item.value), std=None if item.std is None else rounded(item.std))
        for name, item in found.estimates.items()
    }
    kept = slice(None) if found.modulus_identified else slice(1, None)
    if not found.modulus_identified:
        estimates["E"] = Measured(value=rounded(found.law.E), source=found.fit.modulus_source, estimated=True)
    between = found.between_specimens
    covariance = Covariance(
        parameters=("E", "H", "n") if found.modulus_identified else ("H", "n"),
        matrix=_matrix(found.covariance[kept, kept]),
        between_specimens=None if between is None else _matrix(between[kept, kept]),
    )
    files = ", ".join(fit.name for fit in found.fit.specimens)
    low, high = found.fit.strain_range
    return Family(
        E=estimates["E"],
        H=estimates["H"],
        n=estimates["n"],
        sigma_y0=Measured(value=found.law.sigma_y0),
        e0=found.law.e0,
        compression_ratio=compression_ratio,
        strain_range=(rounded(low), rounded(high)),
        covariance=covariance,
        residual=rounded(found.fit.residual),
        source=f"tensile tests {files}",
    )


def _matrix(values: Array) -> tuple[tuple[float, ...], ...]:
    """Return a symmetric matrix as rows of rounded numbers."""
    return tuple(tuple(rounded(float(value)) for value in row) for row in 0.5 * (values + values.T))


def rounded(value: float) -> float:
    """Return a number with six significant digits."""
    return float(np.format_float_scientific(value, precision=5))
