"""One direction of the fabric from all its specimens: the paper's procedure or its consistent form, then statistics.

A direction without any unloading has no modulus of its own: E is then taken from a named fabric, said to be
unidentified, and only H and n are fitted at that E.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.identify.coupon import loading_curve
from etextile.identify.curves import TensileCurve
from etextile.identify.machine import Machine, doubt, machine_of, without_machine
from etextile.identify.modulus import Procedure
from etextile.identify.outliers import SpecimenDistances, scatter
from etextile.identify.segments import Segments, split
from etextile.identify.specimen import GivenModulus, SpecimenFit, fit_specimen, with_shared_doubt
from etextile.identify.statistics import (
    SCATTER_E,
    SCATTER_N,
    SCATTER_STRESS,
    pool,
    sample_covariance,
    with_deviations,
)
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


SIGMA_Y0 = 0.2
# A modulus taken over must stay above the steepest loading slope by this factor, or loading leaves no plastic strain.
MARGIN = 1.25
# Strain, as a share of the largest, at which stress and exponent are nearly uncorrelated.
_REFERENCE = 0.6


@dataclass(frozen=True)
class NamedLaw:
    """Law of the same family in a named fabric, from which E is taken when no specimen unloads."""

    name: str
    law: PowerLaw
    area_ratio: float
    strain_max: float


@dataclass(frozen=True)
class DirectionFit:
    """Parameters of one direction.

    `covariance` (3, 3) of (ln E, ln H, n): uncertainty of the mean over specimens; `between` (3, 3): from one specimen
    to the next, None for one specimen. `modulus_source`: empty when E comes from unloading. `measured` and
    `scatter` are over all specimens, `specimens` holds those that were used.
    """

    law: PowerLaw
    covariance: Array
    between: Array | None
    specimens: tuple[SpecimenFit, ...]
    measured: tuple[Segments, ...]
    scatter: SpecimenDistances
    strain_range: tuple[float, float]
    residual: float
    modulus_source: str
    notes: tuple[str, ...]


def fit_direction(
    curves: Sequence[TensileCurve],
    area_ratio: float,
    *,
    named: NamedLaw | None = None,
    procedure: Procedure = "consistent",
    sigma_y0: float = SIGMA_Y0,
    keep_outliers: bool = False,
) -> DirectionFit:
    """Identify one direction from its specimens; `area_ratio` is A_n / A_0.

    Raises BadInput when a curve cannot be used, or when nothing unloads and no named law is given.
    """
    if not curves:
        raise BadInput.of("no specimens for this direction")
    seen = [split(curve) for curve in curves]
    machine = machine_of(seen, area_ratio, procedure=procedure)
    parts = [without_machine(part, machine.compliance) for part in seen]
    spread = scatter(parts)
    used = [part for part, out in zip(parts, spread.outlier, strict=True) if keep_outliers or not out]
    fits, source = _fit_all(used, area_ratio, named=named, procedure=procedure, sigma_y0=sigma_y0)
    if procedure == "consistent":
        fits = with_shared_doubt(fits)
    law, covariance, between = _combine(fits, identified=not source)
    given = GivenModulus(law.E) if source else None
    moved, said = _doubt_of_machine(used, machine, area_ratio, given=given, procedure=procedure, sigma_y0=sigma_y0)
    covariance = covariance + np.outer(moved, moved)
    low = max(fit.hardening.low for fit in fits)
    high = max(float(np.expm1(np.log1p(fit.segments.strain[-1]) - fit.hardening.datum)) for fit in fits)
    return DirectionFit(
        law, covariance, between, tuple(fits), tuple(parts), spread, (low, high), _residual(law, fits), source,
        (*_notes(parts, spread, fits, kept=keep_outliers), *said),
    )  # fmt: skip


def _fit_all(
    parts: list[Segments], area_ratio: float, *, named: NamedLaw | None, procedure: Procedure, sigma_y0: float
) -> tuple[list[SpecimenFit], str]:
    """Fit each specimen; those without unloading at the modulus of the others or, if none unloads, of the named law."""
    first = [fit_specimen(part, area_ratio, sigma_y0=sigma_y0, procedure=procedure) for part in parts]
    known = [fit for fit in first if fit is not None]
    source = ""
    if known:
        own = pool([np.log(fit.law.E) for fit in known], [fit.covariance[0, 0] for fit in known], scatter=SCATTER_E)
        given = GivenModulus(float(np.exp(own.mean)), own.std**2)
    elif named is None:
        message = "no specimen unloads, so E cannot be identified: add an unloading or name a fabric to take E from"
        raise BadInput.of(message, file=parts[0].file, key="E")
    else:
        given, source = _taken_over(parts, area_ratio, named)
    second = [
        fit or fit_specimen(part, area_ratio, sigma_y0=sigma_y0, procedure=procedure, given=given)
        for fit, part in zip(first, parts, strict=True)
    ]
    return [fit for fit in second if fit is not None], source


def _doubt_of_machine(
    parts: list[Segments],
    machine: Machine,
    area_ratio: float,
    *,
    given: GivenModulus | None,
    procedure: Procedure,
    sigma_y0: float,
) -> tuple[Array, tuple[str, ...]]:
    """Return how far what is unknown of the machine moves (ln E, ln H, n), and what to say; `given`: E taken over."""
    whole = [part for part in parts if part.unloads] or parts

    def parameters(part: Segments) -> Array:
        fit = fit_specimen(part, area_ratio, sigma_y0=sigma_y0, procedure=procedure, given=given)
        if fit is None:
            raise BadInput.of("no unloading is left", file=part.file)
        return fit.parameters

    return doubt(whole, machine, parameters)


def _taken_over(parts: list[Segments], area_ratio: float, named: NamedLaw) -> tuple[GivenModulus, str]:
    """Return the modulus taken from a named fabric, and the sentence that says so.

    A fabric of the same weave lends its E. A fabric of another weave, or an E below the slope of loading (which would
    leave no plastic strain), lends the ratio of its E to its steepest loading slope.
    """
    slope = max(_steepest(np.log1p(part.strain), area_ratio * part.stress) for part in parts)
    same = abs(named.area_ratio / area_ratio - 1.0) < 0.01
    if same and MARGIN * slope < named.law.E:
        return GivenModulus(named.law.E), f"unidentified (no unloading measured), taken from {named.name}"
    hencky = np.linspace(0.0, np.log1p(named.strain_max), 101)
    ratio = named.law.E / _steepest(hencky, loading_curve(named.law, hencky).stress)
    reason = f"whose E, {named.law.E:.4g} MPa, lies below {MARGIN:g} times that slope" if same else "another weave"
    rule = f"{ratio:.2f} times the steepest slope of loading, the ratio in {named.name}"
    return GivenModulus(ratio * slope), f"unidentified (no unloading measured), taken as {rule} ({reason})"


def _steepest(hencky: Array, stress: Array) -> float:
    """Return the steepest slope of true stress over Hencky strain, over a tenth of the curve at a time."""
    true = stress * np.exp(hencky)
    width = max(len(hencky) // 10, 2)
    rise = np.maximum(hencky[width:] - hencky[:-width], 1e-12)
    return float(np.max((true[width:] - true[:-width]) / rise))


def _combine(fits: list[SpecimenFit], *, identified: bool) -> tuple[PowerLaw, Array, Array | None]:
    """Return the mean law, its covariance and the covariance between specimens, both of (ln E, ln H, n).

    The statistics are done on (ln E, ln of the stress at a reference strain, n), which are nearly uncorrelated.
    """
    top = max(float(fit.segments.strain[-1]) for fit in fits)
    reference = float(np.log(_REFERENCE * np.log1p(top)))
    to_stress, to_h = np.eye(3), np.eye(3)
    to_stress[1, 2], to_h[1, 2] = reference, -reference
    values = np.array([to_stress @ fit.parameters for fit in fits])
    within = np.array([to_stress @ fit.covariance @ to_stress.T for fit in fits])
    scales = [SCATTER_E if identified else 0.0, SCATTER_STRESS, SCATTER_N * float(values[:, 2].mean())]
    pooled = []
    for j, scale in enumerate(scales):
        own = [i for i, fit in enumerate(fits) if j > 0 or fit.modulus is not None] or list(range(len(fits)))
        pooled.append(pool(values[own, j].tolist(), within[own, j, j].tolist(), scatter=scale))
    mean = to_h @ np.array([item.mean for item in pooled])
    together = _of_mean(within, np.diag([item.between**2 for item in pooled]))
    covariance = to_h @ with_deviations(together, np.array([item.std for item in pooled])) @ to_h.T
    covariance = covariance + (1.0 - 1.0 / len(fits)) * np.mean([fit.doubt for fit in fits], axis=0)
    law = replace(fits[0].law, E=float(np.exp(mean[0])), H=float(np.exp(mean[1])), n=float(mean[2]))
    if len(fits) < 2:
        return law, covariance, None
    spread = np.diag([item.between**2 for item in pooled])
    if len(fits) > len(spread) + 1:
        spread = with_deviations(sample_covariance(values), np.sqrt(np.diag(spread)))
    return law, covariance, to_h @ spread @ to_h.T


def _of_mean(within: Array, between: Array) -> Array:
    """Return the covariance (k, k) of a mean over specimens: `within` (n, k, k) each, `between` (k, k) them.

    Scatter from one specimen to the next is no more correlated than `between` says, whatever one curve's doubts are.
    """
    return np.asarray(np.linalg.pinv(np.linalg.pinv(within + between, hermitian=True).sum(axis=0), hermitian=True))


def _residual(law: PowerLaw, fits: list[SpecimenFit]) -> float:
    """Return the root mean square difference of all specimens from the mean law in fabric stress, MPa."""
    miss = [
        fit.segments.stress
        - loading_curve(law, fit.hardening.own_strain(np.log1p(fit.segments.strain))).stress / fit.area_ratio
        for fit in fits
    ]
    return float(np.sqrt(np.mean(np.concatenate(miss) ** 2)))


def _notes(parts: list[Segments], spread: SpecimenDistances, fits: list[SpecimenFit], *, kept: bool) -> list[str]:
    """Return one sentence for everything a reader must know about the specimens."""
    notes = []
    for part, out, signed, distance in zip(parts, spread.outlier, spread.signed, spread.distance, strict=True):
        if out:
            side = "above" if signed > 0.0 else "below"
            fate = "kept" if kept else "left out"
            notes.append(f"outlier {part.name}: {distance:.0%} {side} the median curve, {fate}")
    if len(parts) == 2 and 2.0 * spread.distance[0] > 0.10:
        names = " and ".join(part.name for part in parts)
        notes.append(f"{names} differ by {2.0 * spread.distance[0]:.0%}: a third specimen would tell which is off")
    said: dict[str, list[str]] = {}
    for fit in fits:
        for note in fit.notes:
            said.setdefault(note, []).append(fit.name)
    return [*notes, *(f"{', '.join(names)}: {note}" for note, names in said.items())]
