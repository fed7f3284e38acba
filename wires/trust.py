"""Whether a run may be believed: the limits that are looked at after every run, with the numbers found.

A verdict on the wires is withheld as soon as one limit is exceeded (exit code 4 of the command line).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass


ENERGY_LIMIT = 0.05
"""Allowed gap between external work and stored plus dissipated energy, as a share of the external work (of the energy
that strains the whole fabric by 0.1 % where the work is less)."""
FORCE_LIMIT = 1e-3
"""Allowed gap between punch and clamp force, as a share of the greatest punch force."""
SOFTENING_LIMIT = 0.02
"""Allowed share of taut trusses past their force peak: beyond it strain may localise in a row of cells."""
CUT_LIMIT = 0.1
"""Allowed depth of the lattice in the body between its nodes, as a share of the body's radius of curvature there: the
force on spheres, elbows and knees is too low by about 0.6 of that share (`theory/contact.md`)."""
PROVISIONAL = "provisional: a trust limit is exceeded"
"""What titles of pictures and tables say of numbers whose verdict is withheld."""
LATTICE_LIMIT = 0.05
"""Allowed change of the punch force from one lattice to the next finer one."""


@dataclass(frozen=True)
class TrustCheck:
    """One limit: what was found, what is allowed, and what to do when it is exceeded."""

    name: str
    value: float
    limit: float
    unit: str
    remedy: str

    @property
    def ok(self) -> bool:
        """True when the value is a number within its limit."""
        return math.isfinite(self.value) and self.value <= self.limit

    @property
    def sentence(self) -> str:
        """The finding in words."""
        unit = f" {self.unit}" if self.unit else ""
        if self.ok:
            return f"{self.name} {self.value:.3g}{unit} (limit {self.limit:.3g}{unit})"
        return f"{self.name} {self.value:.3g}{unit} exceeds its limit of {self.limit:.3g}{unit}: {self.remedy}"


def check_run(
    *,
    max_penetration_mm: float,
    allowed_penetration_mm: float,
    energy_error: float,
    force_imbalance: float | None,
    unconverged_increments: int,
    softening_share: float = 0.0,
    body_in_clamp_mm: float = 0.0,
    increments_without_force: int = 0,
    lattice_error: float | None = None,
    headline_flips: int = 0,
    cut_share: float = 0.0,
) -> tuple[TrustCheck, ...]:
    """Return the checks of a run; shares are plain numbers, the lattice error only when it was estimated,
    the force imbalance only where a body or clamp travels (the moment of a joint is held to the energy alone).

    Limits are constants: none depends on what the run itself leaves in doubt. `headline_flips`: continuations of the
    laws beyond their range under which the headline is another.
    """
    checks = [
        TrustCheck(
            "penetration", max_penetration_mm, allowed_penetration_mm, "mm", "lower contact.max_penetration or refine"
        ),
        TrustCheck("energy error", energy_error, ENERGY_LIMIT, "", "raise motion.steps"),
        TrustCheck(
            "unconverged increments", unconverged_increments, 0, "", "raise motion.steps or solver.max_iterations"
        ),
        TrustCheck(
            "softening share",
            softening_share,
            SOFTENING_LIMIT,
            "",
            "yarns are past their force peak: shorten motion.total",
        ),
    ]
    if force_imbalance is not None:
        checks.insert(2, TrustCheck("force imbalance", force_imbalance, FORCE_LIMIT, "", "lower solver.tolerance"))
    if body_in_clamp_mm > 0.0:
        remedy = "the body reaches a clamp: shorten motion.total or enlarge fabric.size"
        checks.append(TrustCheck("body in the clamp", body_in_clamp_mm, allowed_penetration_mm, "mm", remedy))
    if increments_without_force > 0:
        remedy = "the body slipped between the nodes: lower fabric.coarsening or raise motion.steps"
        checks.append(TrustCheck("pushing increments without force", increments_without_force, 0, "", remedy))
    if cut_share > 0.0:
        remedy = (
            "the lattice is too coarse for the body: lower fabric.coarsening, or give sharp edges of the body a radius"
        )
        checks.append(TrustCheck("lattice cut over the radius of the body", cut_share, CUT_LIMIT, "", remedy))
    if headline_flips > 0:
        remedy = "the headline hangs on laws beyond their range: identify the fabric further or shorten motion.total"
        checks.append(TrustCheck("continuations of the laws with another headline", headline_flips, 0, "", remedy))
    if lattice_error is not None:
        checks.append(TrustCheck("lattice error", lattice_error, LATTICE_LIMIT, "", "lower fabric.coarsening"))
    return tuple(checks)


def trusted(checks: Sequence[TrustCheck]) -> bool:
    """Tell whether no limit is exceeded."""
    return all(check.ok for check in checks)


def exceeded(checks: Iterable[TrustCheck]) -> list[str]:
    """Return the sentences about the limits that are exceeded."""
    return [check.sentence for check in checks if not check.ok]


def withheld(sentences: Sequence[str]) -> str:
    """Return the sentence that withholds a verdict, wherever one stands; nothing where no limit is exceeded."""
    return f"Verdict withheld: {'; '.join(sentences)}." if sentences else ""


def as_provisional(title: str, *, passed: bool) -> str:
    """Return the title of numbers that still stand where a verdict is withheld; `passed`: a limit was."""
    return f"{title} ({PROVISIONAL})" if passed else title
