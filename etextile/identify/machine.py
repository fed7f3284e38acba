r"""What strain taken from the crosshead owes to the machine: found from several gauge lengths, or counted as unknown.

Frame, load cell and grips give by C F. A curve whose strain is crosshead travel over gauge length L shows

    e_seen = e + C F / L,     1 / k_seen = exp(p) / E + C A / (r L (1 + e)),     r = A_n / A_0,

with the slope k of unloading in engineering truss stress over Hencky strain, at the plastic strain p, on the cross
section A of the coupon. One curve cannot tell C from 1 / E; coupons of two gauge lengths can. Where nothing tells it,
C is a half-normal unknown and what it does to E, H and n goes into their covariance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.identify.curves import CouponSize
from etextile.identify.modulus import Procedure, fit_modulus
from etextile.identify.segments import Segments
from etextile.identify.statistics import SCATTER_E
from etextile.types import Array


STIFFNESS = 1000.0
"""Stiffness of machine and grips, N/mm, whose compliance is one deviation where nothing is known of it: a load cell has
16 000 (Beex et al., section 3), a frame for textiles 2 000 to 10 000, grips with rubber or fabric in them some hundred.
"""
COUPON = CouponSize(width=29.0, thickness=0.35, gauge_length=60.0)
"""Coupon taken where a file of strain and stress does not say it: that of Beex et al."""
APART, EVIDENCE = 1.3, 2.0
"""Ratio of A / L from which two gauge lengths tell the compliance; deviations from zero from which it is taken out."""


@dataclass(frozen=True)
class Machine:
    """Compliance taken out of the strains and the deviation of what is left unknown, mm/N; a sentence about it."""

    compliance: float
    std: float
    note: str = ""


def machine_of(parts: Sequence[Segments], area_ratio: float, *, procedure: Procedure = "consistent") -> Machine:
    """Return what the specimens of one direction tell of the machine; `area_ratio` is A_n / A_0."""
    unknown = 1.0 / STIFFNESS
    crosshead = [part for part in parts if not part.on_specimen]
    if not crosshead:
        return Machine(0.0, 0.0)
    fits = [(part, fit_modulus(part, area_ratio, procedure=procedure)) for part in crosshead if part.size is not None]
    rows = np.array(
        [
            (fit.plastic_stretch, strain_per_stress(part, 1.0) / (area_ratio * np.exp(fit.turning)),
             fit.plastic_stretch / fit.E, fit.variance)
            for part, fit in fits if fit is not None
        ]
    ).reshape(-1, 4)  # fmt: skip
    if len(rows) < 2 or rows[:, 1].max() < APART * rows[:, 1].min():
        return Machine(0.0, unknown)
    weight = 1.0 / (rows[:, 2] * np.sqrt(rows[:, 3] + SCATTER_E**2))
    basis = rows[:, :2] * weight[:, None]
    covariance = np.linalg.inv(basis.T @ basis)
    found, std = float((covariance @ basis.T @ (rows[:, 2] * weight))[1]), float(np.sqrt(covariance[1, 1]))
    if found > EVIDENCE * std:
        note = (
            f"the machine gives by {found:.2g} +- {std:.1g} mm/N ({1.0 / found:.0f} N/mm), as unloading at several "
            "gauge lengths tells: taken out of the strains"
        )
        return Machine(found, std, note)
    return Machine(0.0, min(unknown, float(np.hypot(std, max(found, 0.0)))))


def strain_per_stress(part: Segments, compliance: float) -> float:
    """Return the strain that a compliance (mm/N) adds per fabric stress, 1/MPa: C A / L."""
    size = part.size or COUPON
    return compliance * size.width * size.thickness / size.gauge_length


def without_machine(part: Segments, compliance: float) -> Segments:
    """Return a specimen without what the machine gave; strain measured on the specimen stays."""
    if part.on_specimen or compliance == 0.0:
        return part
    rate = strain_per_stress(part, compliance)
    return replace(
        part,
        strain=part.strain - rate * part.stress,
        unloading_strain=part.unloading_strain - rate * part.unloading_stress,
    )


def doubt(
    parts: Sequence[Segments], machine: Machine, parameters: Callable[[Segments], Array]
) -> tuple[Array, tuple[str, ...]]:
    """Return how far one deviation of the machine's compliance moves the mean of (ln E, ln H, n), and a sentence.

    `parameters` fits one specimen. The first one that took its strain from the crosshead stands for all of them.
    """
    own = [part for part in parts if not part.on_specimen]
    said = (machine.note,) if machine.note else ()
    if not own or machine.std == 0.0:
        return np.zeros(3), said
    before = parameters(own[0])
    for share in (1.0, 0.5, 0.25, 0.1):
        try:
            moved = (parameters(without_machine(own[0], share * machine.std)) - before) / share
        except BadInput:  # so soft a machine leaves the specimen no strain
            continue
        moved = moved * len(own) / len(parts)
        return moved, said if machine.note else (*said, _unknown(machine, moved))
    raise BadInput.of(
        f"a machine of {1.0 / machine.std:.0f} N/mm would have done nearly all of the strain: measure it on the "
        "specimen (strain_from: specimen) or state machine_stiffness",
        file=own[0].file,
    )


def _unknown(machine: Machine, moved: Array) -> str:
    """Say what is not known of the machine, and what would tell it."""
    what = f"E {np.expm1(moved[0]):+.0%}, " if moved[0] else ""
    return (
        f"strain not known to be measured on the specimen: a machine of {1.0 / machine.std:.0f} N/mm would move "
        f"{what}n {moved[2]:+.2g}, which is in the intervals; strain_from: specimen, machine_stiffness or coupons of "
        "another gauge length narrow them"
    )
