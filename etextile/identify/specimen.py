"""All parameters of one specimen with their covariance: modulus, then hardening at that modulus, then both together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from etextile.identify.hardening import HardeningFit, fit_hardening
from etextile.identify.joint import describes, fit_jointly
from etextile.identify.least_squares import CurveData
from etextile.identify.modulus import ModulusFit, Procedure, fit_modulus
from etextile.identify.rivals import weights
from etextile.identify.segments import Segments
from etextile.identify.toe import hidden_toe, toe_note
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


@dataclass(frozen=True)
class GivenModulus:
    """A modulus that does not come from the specimen itself, MPa, with the variance of its logarithm."""

    E: float
    variance: float = 0.0


@dataclass(frozen=True)
class SpecimenFit:
    """Fit of one specimen; `covariance` (3, 3) of (ln E, ln H, n); `modulus` None when E was given.

    `doubt` (3, 3): the part of it that comes from what the start of the curve is taken for. Specimens of a direction
    are mounted and set to zero in one way, so it does not average out.
    """

    segments: Segments
    area_ratio: float
    modulus: ModulusFit | None
    hardening: HardeningFit
    covariance: Array
    said: tuple[str, ...] = ()
    doubt: Array = field(default_factory=lambda: np.zeros((3, 3)))

    @property
    def law(self) -> PowerLaw:
        """The fitted law."""
        return self.hardening.law

    @property
    def name(self) -> str:
        """Name of the specimen."""
        return self.segments.name

    @property
    def parameters(self) -> Array:
        """(ln E, ln H, n)."""
        return np.array([np.log(self.law.E), np.log(self.law.H), self.law.n])

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out, moved or does not fit, one sentence each."""
        return (*self.segments.notes, *self.hardening.notes, *(self.modulus.notes if self.modulus else ()), *self.said)


def fit_specimen(
    segments: Segments,
    area_ratio: float,
    *,
    sigma_y0: float,
    procedure: Procedure = "consistent",
    given: GivenModulus | None = None,
) -> SpecimenFit | None:
    """Return the fit of one specimen, or None when it has no unloading and no modulus is given.

    `area_ratio` is A_n / A_0; `given` is used only where the specimen does not unload. Raises BadInput.
    """
    modulus = fit_modulus(segments, area_ratio, procedure=procedure)
    if modulus is None and given is None:
        return None
    E = modulus.E if modulus is not None else given.E if given is not None else 0.0
    hardening = fit_hardening(segments, area_ratio, E=E, sigma_y0=sigma_y0, procedure=procedure)
    if modulus is not None and procedure == "consistent" and not modulus.notes and describes(hardening, segments):
        modulus, hardening, covariance = fit_jointly(modulus, hardening, segments, area_ratio=area_ratio)
        return _with_start(SpecimenFit(segments, area_ratio, modulus, hardening, covariance))
    variance = modulus.variance if modulus is not None else given.variance if given is not None else 0.0
    found = SpecimenFit(segments, area_ratio, modulus, hardening, _in_two_steps(variance, hardening))
    return found if procedure == "paper" else _with_start(found)


def _with_start(found: SpecimenFit) -> SpecimenFit:
    """Return the fit with the doubt of its start: a toe in the noise or left in, a preload that was set to zero."""
    part, ratio, rivals = found.segments, found.area_ratio, found.hardening.rivals
    hidden, toe = np.zeros((3, 3)), 0.0
    if found.hardening.datum == 0.0:
        data = CurveData(np.log1p(part.strain), part.stress * ratio, part.noise * ratio)
        hidden, toe = hidden_toe(found.law, data, slack_limit=part.slack_limit)
    by_toe = hidden
    if "toe" in rivals.added:
        left_in = weights([rivals])["toe"] * rivals.added["toe"]
        by_toe, toe = hidden + left_in, max(toe, float(np.sqrt(left_in[0, 0])))
    found = replace(found, covariance=found.covariance + _of_law(found, hidden))
    found = _doubted(found, weights([rivals]))
    return replace(found, said=(*found.said, *toe_note(found.law.n, by_toe, toe)))


def with_shared_doubt(fits: Sequence[SpecimenFit]) -> list[SpecimenFit]:
    """Return the fits with the doubt of their starts as all of them together leave it."""
    weight = weights([fit.hardening.rivals for fit in fits])
    return [_doubted(fit, weight) for fit in fits]


def _doubted(found: SpecimenFit, weight: dict[str, float]) -> SpecimenFit:
    doubt = _of_law(found, found.hardening.rivals.doubt(weight))
    return replace(found, covariance=found.covariance - found.doubt + doubt, doubt=doubt)


def _of_law(found: SpecimenFit, added: Array) -> Array:
    """Return what is added to the covariance (3, 3); a modulus that was given does not move."""
    own = added.copy()
    if found.modulus is None:
        own[0] = own[:, 0] = 0.0
    return own


def _in_two_steps(variance: float, hardening: HardeningFit) -> Array:
    """Return the covariance of (ln E, ln H, n) when hardening was fitted at a modulus of its own variance."""
    along = np.concatenate([[1.0], hardening.by_log_E])
    covariance = variance * np.outer(along, along)
    covariance[1:, 1:] += hardening.covariance
    return covariance
