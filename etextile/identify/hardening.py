r"""Hardening parameters H and n of a truss family from the loading of one specimen (Beex et al., section 4.3).

Yield stress sigma_y = sigma_y0 + H eps_p^n with a small, fixed sigma_y0; E is known from unloading.

* `paper`: true stress sigma = s lambda (all strain plastic), eps_p = eps - sigma / E, straight line of
  log(sigma - sigma_y0) on log eps_p. Stresses below a tenth of the peak are left out: there noise becomes bias under
  the logarithm. Counting all strain as plastic overrates sigma by the elastic strain, which makes n 3 to 4 % and H 15
  to 20 % too large when curves of the law itself are put in.
* `consistent`: nonlinear least squares of the law's own loading curve on the measured stress. Nothing is assumed about
  lambda_p and additive noise stays unbiased; the straight line is where it starts from.

The datum of strain is moved only where the test demands it: a preload at the first point means that the specimen was
strained when the strain was set to zero; a slack specimen shows no stress at first; yarns that straighten one after the
other make a toe that is taken up progressively (`toe`), which no datum removes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from etextile.errors import BadInput
from etextile.identify.coupon import loading_curve, straightened
from etextile.identify.least_squares import N_LIMITS, CurveData, LawSolution, solve
from etextile.identify.modulus import Procedure
from etextile.identify.rivals import Rivals, half_akaike, rivals_of
from etextile.identify.segments import Segments
from etextile.identify.statistics import is_noise, residual_variance
from etextile.identify.toe import is_better, left_in_note, progressive, progressive_note
from etextile.identify.zeroed import is_seen, set_to_zero, zeroed_note
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array, BoolArray


# Share of the peak stress below which the logarithmic fit leaves points out.
LOWER_CUT = 0.1
# Slack is taken out only when it differs from zero by this many standard deviations.
SLACK_EVIDENCE = 5.0
# Hencky strain from which a slack or a toe is one.
LEAST_DATUM = 2e-4
# Yield stress builds up over this plastic strain (`PowerLaw.e0`); H and n hardly depend on it.
E0 = 1e-3


@dataclass(frozen=True)
class HardeningFit:
    """Hardening of one specimen at a given modulus.

    `covariance` (2, 2) of (ln H, n) at that modulus; `by_log_E` (2,): how (ln H, n) move with ln E. `datum`: Hencky
    strain taken off the measured one (> 0 slack, < 0 preload), at once or, with `over` > 0, progressively over this
    engineering truss stress, MPa (`coupon.straightened`). `low`: engineering strain where the fitted range starts.
    `residuals` (n,): measured minus fitted fabric stress, MPa, over the loading. `zeroed`: strain and stress were set
    to zero at a preload. `rivals`: other explanations of the start.
    """

    law: PowerLaw
    covariance: Array
    by_log_E: Array
    datum: float
    low: float
    residuals: Array
    notes: tuple[str, ...] = ()
    zeroed: bool = False
    over: float = 0.0
    rivals: Rivals = field(default_factory=Rivals)

    def own_strain(self, hencky: Array) -> Array:
        """Return the Hencky strains (n,) of the fabric itself in a test whose Hencky strains are `hencky` (n,)."""
        return straightened(self.law, hencky, toe=self.datum, over=self.over)


def fit_hardening(
    segments: Segments, area_ratio: float, *, E: float, sigma_y0: float, procedure: Procedure = "consistent"
) -> HardeningFit:
    """Return H and n of one specimen; `area_ratio` is A_n / A_0. Raises BadInput when E leaves no plastic strain."""
    data = CurveData(np.log1p(segments.strain), segments.stress * area_ratio, segments.noise * area_ratio)
    line = fit_log_line(data.hencky, data.stress, E=E, sigma_y0=sigma_y0, file=segments.file)
    if procedure == "paper":
        return _from_line(line, data, segments, area_ratio)
    return _least_squares(line.law, data, segments, area_ratio)


@dataclass(frozen=True)
class LogLine:
    """Straight line through log(sigma - sigma_y0) over log eps_p: plastic strain and true stress of the points used."""

    law: PowerLaw
    covariance: Array
    plastic_strain: Array
    true_stress: Array
    used: BoolArray


def fit_log_line(hencky: Array, stress: Array, *, E: float, sigma_y0: float, file: str = "") -> LogLine:
    """Fit the paper's straight line to Hencky strain and engineering truss stress (n,) of loading.

    Raises BadInput when too few points have a plastic strain: the modulus is then below the slope of loading.
    """
    true = stress * np.exp(hencky)
    plastic = hencky - true / E
    above = np.flatnonzero(true < LOWER_CUT * true.max())
    first = int(above[-1]) + 1 if len(above) else 0
    used = (np.arange(len(true)) >= first) & (plastic > 0.0) & (true > 2.0 * sigma_y0)
    if np.count_nonzero(used) < 5 or plastic[-1] <= 0.0:
        needed = float(np.max(true[first:] / np.maximum(hencky[first:], 1e-12)))
        message = f"E = {E:.4g} MPa leaves no plastic strain in the loading, which needs E above {needed:.4g} MPa"
        raise BadInput.of(message, file=file, key="E")
    x, y = np.log(plastic[used]), np.log(true[used] - sigma_y0)
    basis = np.column_stack([np.ones_like(x), x])
    (log_h, n), *_ = np.linalg.lstsq(basis, y, rcond=None)
    variance = residual_variance(y - basis @ np.array([log_h, n]), parameters=2)
    law = PowerLaw(E=E, sigma_y0=sigma_y0, H=float(np.exp(log_h)), n=float(np.clip(n, *N_LIMITS)), e0=E0)
    return LogLine(law, variance * np.linalg.inv(basis.T @ basis), plastic, true, used)


def _from_line(line: LogLine, data: CurveData, segments: Segments, area_ratio: float) -> HardeningFit:
    """Return the paper's fit with its dependence on E by a small change of E."""
    step = 1e-3
    moved = fit_log_line(
        data.hencky, data.stress, E=line.law.E * np.exp(step), sigma_y0=line.law.sigma_y0, file=segments.file
    ).law
    by_log_e = np.array([np.log(moved.H / line.law.H), moved.n - line.law.n]) / step
    residuals = (data.stress - loading_curve(line.law, data.hencky).stress) / area_ratio
    low = float(segments.strain[np.flatnonzero(line.used)[0]])
    return HardeningFit(line.law, line.covariance, by_log_e, 0.0, low, residuals)


@dataclass(frozen=True)
class _Start:
    """A fit with notes about what the start of the curve is taken for."""

    fit: LawSolution
    notes: tuple[str, ...] = ()


def _least_squares(law: PowerLaw, data: CurveData, segments: Segments, area_ratio: float) -> HardeningFit:
    """Fit the law's loading curve, with the datum of strain free where the test may need it."""
    begun = _datum(solve(law, data), data, segments)
    fits = {"law": begun.fit}
    toe = progressive(begun.fit.law, data) if segments.preload == 0.0 else None
    if toe is not None and toe.datum > 0.0:
        fits["toe"] = toe
    if not begun.notes:
        fits["zeroed"] = set_to_zero(begun.fit, data)
    half = half_akaike(fits, data.noise)
    name = _taken(fits, half, data.noise)
    best = fits[name]
    left_in = "toe" in fits and name == "law"
    said = left_in_note(best, fits["toe"], data.noise, area_ratio) if left_in else ()
    own = {"law": begun.notes, "toe": (progressive_note(best, area_ratio),), "zeroed": (zeroed_note(best, area_ratio),)}
    return HardeningFit(
        best.law, best.covariance[1:3, 1:3], best.by_log_E, best.datum, 0.0, best.residuals / area_ratio,
        (*own[name], *said), name == "zeroed", best.over, rivals_of(fits, half, name, data.noise),
    )  # fmt: skip


def _taken(fits: dict[str, LawSolution], half: dict[str, float], noise: float) -> str:
    """Return which explanation of the start is taken: the law alone unless another is much better and leaves noise."""
    held, toe, zeroed = fits["law"], fits.get("toe"), fits.get("zeroed")
    found = []
    if toe is not None and toe.datum > LEAST_DATUM and is_noise(toe.residuals, noise) and is_better(toe, held):
        found.append("toe")
    if zeroed is not None and is_seen(zeroed, held, noise):
        found.append("zeroed")
    return min(found, key=half.__getitem__, default="law")


def _datum(held: LawSolution, data: CurveData, segments: Segments) -> _Start:
    """Return the fit with the datum moved where there is a preload or slack and the fit gains by it."""
    if segments.preload > 0.0:
        free = solve(held.law, data, free_datum=True, datum=-0.05 * float(data.hencky[-1]))
        if free.datum < 0.0 and is_better(free, held):
            return _Start(free, (f"preload of {segments.preload:.3g} MPa: strain there taken as {-free.datum:.4f}",))
    elif segments.slack_limit > 0.0:
        free = solve(held.law, data, free_datum=True)
        spread = float(np.sqrt(free.covariance[3, 3]))
        far_enough = max(SLACK_EVIDENCE * spread, LEAST_DATUM) < free.datum <= np.log1p(segments.slack_limit)
        if far_enough and is_better(free, held):
            return _Start(free, (f"slack of {free.datum:.4f} taken out",))
    return _Start(held)
