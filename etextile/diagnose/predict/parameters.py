"""Base parameters of the fabric: what the coupons (or a stated prior) allow them to be.

Each family is described by (ln E, ln s, n): modulus, yield stress at a plastic strain inside the identified range, and
exponent. These are nearly uncorrelated, and a step along one of them stays a sensible law; sigma_y0 is kept.
In a diagnosis the parameters move only within this covariance: left free on the punch curve they would eat any effect.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.predict.simulate import Law
from etextile.identify.result import IdentifiedFamily
from etextile.types import Array
from etextile.vocabulary import FABRIC_FAMILIES


NAMES = tuple(f"{family} {name}" for family in FABRIC_FAMILIES for name in ("ln E", "ln s", "n"))
# Stated prior where neither coupons nor the fabric file say more: relative for E and stress, relative for n.
PRIOR_E, PRIOR_STRESS, PRIOR_N = 0.10, 0.03, 0.015
# What the way of identification leaves open (bias coupon at 45 deg for diagonals at 29 deg, one truss per curve).
METHOD_STRESS = {"warp": 0.003, "weft": 0.003, "diagonal": 0.01}
# Steps of the finite differences along each direction.
STEPS = (0.10, 0.04, 0.04)
_REFERENCE = 0.6


@dataclass(frozen=True)
class BaseParameters:
    """Laws of the three families, their covariance (9, 9) in the order of `NAMES`, and where each comes from.

    `reference` (3,): plastic strain at which the stress s of each family is taken; `ranges`: identified engineering
    strain per family; `coupons` (3,): whether it was identified from coupons of this test.
    """

    laws: tuple[Law, Law, Law]
    covariance: Array
    reference: tuple[float, float, float]
    ranges: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    sources: tuple[str, str, str]
    coupons: tuple[bool, bool, bool] = (False, False, False)

    @property
    def yarns_seen_to(self) -> float:
        """Engineering strain up to which coupons show both yarn families; 0 when one has none."""
        return min(self.ranges[0][1], self.ranges[1][1]) if self.coupons[0] and self.coupons[1] else 0.0

    def moved(self, shift: Array) -> tuple[Law, Law, Law]:
        """Return the laws after a shift (9,) along (ln E, ln s, n) of each family."""
        moved = [_moved(law, shift[3 * i : 3 * i + 3], self.reference[i]) for i, law in enumerate(self.laws)]
        return moved[0], moved[1], moved[2]

    def shift_from(self, laws: tuple[Law, Law, Law]) -> Array:
        """Return the shift (9,) that leads from `laws` to these."""
        rows = []
        for (E0, _, H0, n0), (E1, _, H1, n1), p in zip(laws, self.laws, self.reference, strict=True):
            stress = np.log(H1) - np.log(H0) + (n1 - n0) * np.log(p)
            rows.append([np.log(E1 / E0), stress, n1 - n0])
        return np.array(rows).ravel()


def _moved(law: Law, shift: Array, reference: float) -> Law:
    modulus, yield0, factor, exponent = law
    log_h = np.log(factor) + shift[1] - shift[2] * np.log(reference)
    return (float(modulus * np.exp(shift[0])), yield0, float(np.exp(log_h)), float(exponent + shift[2]))


def reference_strain(strain_max: float) -> float:
    """Return the plastic strain at which the stress of a family is taken: 60 % of the identified range."""
    return _REFERENCE * float(np.log1p(strain_max))


def prior_covariance(n: float) -> Array:
    """Return the stated prior (3, 3) of (ln E, ln s, n) of a family."""
    return np.diag([PRIOR_E**2, PRIOR_STRESS**2, (PRIOR_N * n) ** 2])


def combine(
    laws: Mapping[str, Law], covariances: Mapping[str, Array | None], ranges: Mapping[str, tuple[float, float]],
    identified: Mapping[str, IdentifiedFamily],
) -> BaseParameters:  # fmt: skip
    """Return base parameters: identified families from their coupons, the others from the case's fabric.

    `covariances`: (3, 3) of (ln E, ln s, n) where the fabric file states one, else the stated prior is taken.
    """
    found_laws, blocks, reference, spans, sources = [], [], [], [], []
    for name in FABRIC_FAMILIES:
        family = identified.get(name)
        span = ranges[name] if family is None else family.fit.strain_range
        p = reference_strain(span[1])
        if family is None:
            stated = covariances.get(name)
            blocks.append(prior_covariance(laws[name][3]) if stated is None else stated)
            found_laws.append(laws[name])
            sources.append("the case's fabric, " + ("stated prior" if stated is None else "its own covariance"))
        else:
            law = family.law
            found_laws.append((law.E, law.sigma_y0, law.H, law.n))
            blocks.append(_of_coupons(family, p, METHOD_STRESS[name]))
            sources.append(f"{len(family.fit.specimens)} coupons")
        reference.append(p)
        spans.append(span)
    covariance = np.zeros((9, 9))
    for i, block in enumerate(blocks):
        covariance[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = block
    return BaseParameters(
        (found_laws[0], found_laws[1], found_laws[2]), covariance, (reference[0], reference[1], reference[2]),
        (spans[0], spans[1], spans[2]), (sources[0], sources[1], sources[2]),
        ("warp" in identified, "weft" in identified, "diagonal" in identified),
    )  # fmt: skip


def _of_coupons(family: IdentifiedFamily, reference: float, method: float) -> Array:
    """Return the covariance of (ln E, ln s, n) of the mean over specimens, with what the method itself leaves open."""
    turn = np.eye(3)
    turn[1, 2] = np.log(reference)
    covariance = turn @ family.fit.covariance @ turn.T
    if not family.modulus_identified:
        covariance[0, 0] += PRIOR_E**2
    covariance[1, 1] += method**2
    return np.asarray(covariance)


def steps() -> Array:
    """Return the finite-difference steps (9,)."""
    return np.tile(np.array(STEPS), 3)
