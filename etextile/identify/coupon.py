r"""The coupon as a single truss in closed form: what the identification fits and what synthetic tests are made of.

In a coupon pulled along a family only that family carries (Beex et al., section 4), so the fabric's curve is that of
one truss. With Hencky strain eps, plastic strain p and yield stress Y(p) = sigma_y0 p / (p + e0) + H p^n the loading
curve solves p + Y(p) / E = eps; the engineering stress of the truss is s = Y exp(-p), that of the fabric s A_0 / A_n.
Unloading keeps p, so s = k (eps - p) is a straight line in Hencky strain with slope k = E exp(-p).

The kernels of the solver find p point by point; what is added here are whole curves and their derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.compiled import njit
from etextile.laws.powerlaw import PowerLaw, plastic_strain
from etextile.types import Array


# Order of the columns of slopes: derivatives by ln E, ln H, n and the Hencky strain.
D_LOG_E, D_LOG_H, D_N, D_STRAIN = range(4)


@dataclass(frozen=True)
class LoadingCurve:
    """Loading curve of a truss at given Hencky strains (n,).

    `plastic_strain` (n,) is a Hencky strain, `true_stress` and `stress` (engineering, on A_0) are MPa, all (n,).
    `slopes`, `plastic_slopes` (n, 4): derivatives of `stress` and `plastic_strain` by ln E, ln H, n and Hencky strain.
    """

    plastic_strain: Array
    true_stress: Array
    stress: Array
    slopes: Array
    plastic_slopes: Array


def loading_curve(law: PowerLaw, hencky: Array) -> LoadingCurve:
    """Return the loading curve of a virgin truss at rising Hencky strains (n,); not positive strains give zero."""
    p = _plastic_strains(law.row(), np.ascontiguousarray(hencky, dtype=np.float64))
    loaded = p > 0.0
    log_p = np.log(p, out=np.zeros_like(p), where=loaded)
    power = np.where(loaded, law.H * np.exp(law.n * log_p), 0.0)
    yield_stress = law.sigma_y0 * p / (p + law.e0) + power
    hardening = law.sigma_y0 * law.e0 / (p + law.e0) ** 2 + np.divide(
        law.n * power, p, out=np.zeros_like(p), where=loaded
    )
    shrink = np.exp(-p)
    flow = np.where(loaded, 1.0 / (1.0 + hardening / law.E), 0.0)
    plastic_slopes = np.column_stack(
        [flow * yield_stress / law.E, -flow * power / law.E, -flow * power * log_p / law.E, flow]
    )
    slopes = (shrink * (hardening - yield_stress))[:, None] * plastic_slopes
    slopes[:, D_LOG_H] += shrink * power
    slopes[:, D_N] += shrink * power * log_p
    return LoadingCurve(p, yield_stress, yield_stress * shrink, slopes, plastic_slopes)


def straightened(law: PowerLaw, hencky: Array, *, toe: float, over: float) -> Array:
    """Return the Hencky strains x (n,) of the fabric where its yarns straighten first, by `toe` in all.

    x + toe (1 - exp(-s(x) / over)) = eps with the engineering truss stress s: all at once for `over` = 0, a shift that
    `toe` < 0 may be too, and yarn by yarn as the stress rises for `over` > 0, MPa. Newton within the bracket.
    """
    if over == 0.0:
        return np.asarray(hencky - toe)
    low, high = hencky - toe, hencky.copy()
    x = high.copy()
    for _ in range(60):
        curve = loading_curve(law, x)
        left = np.exp(-curve.stress / over)
        miss = x + toe * (1.0 - left) - hencky
        low, high = np.where(miss < 0.0, x, low), np.where(miss > 0.0, x, high)
        after = x - miss / (1.0 + toe / over * left * curve.slopes[:, D_STRAIN])
        after = np.where((after >= low) & (after <= high), after, 0.5 * (low + high))
        if np.all(np.abs(after - x) <= 1e-13 + 1e-10 * np.abs(x)):
            break
        x = after
    return np.asarray(x)


@njit
def _plastic_strains(c, hencky):  # type: ignore[no-untyped-def]
    """Return plastic strains (n,) on the loading curve for the parameter row c, by the kernel of the solver."""
    p = np.zeros_like(hencky)
    for i in range(hencky.shape[0]):
        if hencky[i] > 0.0:
            p[i] = plastic_strain(c, hencky[i], 0.0)
    return p


def unloading_line(law: PowerLaw, hencky: Array, *, from_hencky: float) -> tuple[Array, Array]:
    """Return engineering truss stress (MPa) at Hencky strains (n,) while unloading from `from_hencky`, and its slopes.

    Plastic strain stays at its value there: s = E exp(-p) (eps - p), and nothing once the truss is slack. Slopes (n, 4)
    are by ln E, ln H, n and by a common shift of all Hencky strains.
    """
    turning = loading_curve(law, np.array([from_hencky]))
    p = float(turning.plastic_strain[0])
    k = law.E * np.exp(-p)
    taut = hencky > p
    stress = np.where(taut, k * (hencky - p), 0.0)
    slopes = -k * (1.0 + hencky - p)[:, None] * turning.plastic_slopes
    slopes[:, D_LOG_E] += stress
    slopes[:, D_STRAIN] += k
    return stress, np.where(taut[:, None], slopes, 0.0)


def true_stress(hencky: Array, stress: Array, *, E: float) -> Array:
    """Return true stress (n,) of a loading curve given as Hencky strain and engineering truss stress, at modulus E.

    sigma = s exp(eps - sigma / E) has the closed form sigma = E W(s exp(eps) / E) with Lambert's W.
    """
    from scipy.special import lambertw

    return np.asarray(E * lambertw(np.maximum(stress, 0.0) * np.exp(hencky) / E).real, dtype=np.float64)


def pull(
    law: PowerLaw, strain_max: float, *, area_ratio: float, loading: int = 100, unloading: int = 40
) -> tuple[Array, Array]:
    """Return engineering strain and fabric engineering stress (MPa) of a noise-free test, in time order.

    `area_ratio` is A_n / A_0. The strain rises in `loading` equal steps to `strain_max`, then falls in `unloading`
    equal steps to where the truss is slack (none: loading only).
    """
    top = float(np.log1p(strain_max))
    up = np.log1p(np.linspace(0.0, strain_max, loading + 1))
    p = float(loading_curve(law, np.array([top])).plastic_strain[0])
    down = np.log1p(np.linspace(strain_max, float(np.expm1(p)), unloading + 1)[1:])
    stress = np.concatenate([loading_curve(law, up).stress, unloading_line(law, down, from_hencky=top)[0]])
    return np.expm1(np.concatenate([up, down])), stress / area_ratio
