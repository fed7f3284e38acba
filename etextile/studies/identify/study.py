"""From tensile curves to a fabric file: read, identify, refine by virtual coupons on request, write with plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from etextile.errors import BadInput
from etextile.identify.curves import CouponSize, TensileCurve
from etextile.identify.modulus import Procedure
from etextile.importers.options import PLAIN, Options
from etextile.studies.identify.bias import BiasIdentification, bias_alone, identify_bias, write_bias
from etextile.studies.identify.found import Identification
from etextile.studies.identify.identify import (
    check_output,
    curves_of,
    identify_curves,
    read_lists,
    write,
)
from etextile.studies.identify.refine import Watch, refined
from loadcases.fabric import DEFAULT_FABRIC, load_base


Tests: TypeAlias = Mapping[str, Sequence[TensileCurve]] | Mapping[str, Sequence[Path]]
"""Curves, or CSV files, of the directions 'warp', 'weft' and 'bias'."""


def identify(
    measured: str | Path | Tests,
    output: str | Path | None = None,
    *,
    title: str | None = None,
    fabric: str | Path = DEFAULT_FABRIC,
    modulus_from: str | Path | None = None,
    procedure: Procedure = "consistent",
    size: CouponSize | None = None,
    columns: Sequence[str] = (),
    options: Options = PLAIN,
    keep_outliers: bool = False,
    refine: bool = False,
    strips: int = 1,
    coarsening: float | None = None,
    force: bool = False,
    watch: Watch | None = None,
) -> Identification | BiasIdentification:
    """Identify a fabric from tensile tests; with `output` write the fabric file and, beside it, check plots.

    `measured`: folder with a measured.yaml, or curves or files by direction (`size`, `columns`, `options`: of files
    that do not say). `fabric` supplies the weave and families without curves, `modulus_from` E where nothing unloads.
    Bias coupons alone, of known size, give a shear law for all sizes (`bias`). `refine`: adjust the laws until virtual
    coupons (a strip of `strips`, at a `coarsening`) return the curves. Raises BadInput.
    """
    place = None if output is None else Path(output)
    if place is not None:
        check_output(place, force=force)
    found, curves = _curves(measured, size=size, options=replace(options, names=tuple(columns)) if columns else options)
    name = title or found or (place.stem if place is not None else "tensile tests")
    if bias_alone(curves) and not refine:
        told = identify_bias(curves["bias"], title=name, fabric=fabric)
        return told if place is None else write_bias(told, place, force=force)
    result = identify_curves(
        curves,
        title=name,
        fabric=fabric,
        modulus_from=modulus_from,
        procedure=procedure,
        keep_outliers=keep_outliers,
    )
    if refine:
        given = [curve.size for specimens in curves.values() for curve in specimens if curve.size is not None]
        strip = (given[0].gauge_length, given[0].width / strips) if given else None
        result = refined(result, load_base(fabric), size=strip, coarsening=coarsening, watch=watch)
    return result if place is None else write(result, place, force=force)


def _curves(
    measured: str | Path | Tests, *, size: CouponSize | None, options: Options
) -> tuple[str, Mapping[str, Sequence[TensileCurve]]]:
    """Return the title of a folder, empty for lists, and the curves by direction."""
    if isinstance(measured, str | Path):
        return curves_of(measured)
    files: dict[str, list[Path]] = {}
    curves: dict[str, Sequence[TensileCurve]] = {}
    for direction, items in measured.items():
        read = [item for item in items if isinstance(item, TensileCurve)]
        files[direction] = [Path(item) for item in items if not isinstance(item, TensileCurve)]
        if read:
            curves[direction] = read
    for direction, found in read_lists(files, size=size, options=options).items():
        curves[direction] = [*curves.get(direction, ()), *found]
    if not curves:
        raise BadInput.of("there are no curves to identify from, give some for warp, weft or bias")
    return "", curves
