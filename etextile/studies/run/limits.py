"""Every trust limit of a path, from one place: of a run, of sized loops, of ensembles and designs that are compared.

What a single increment tells is checked of every sample (`check_path`); continuations of the laws beyond their range
take two more paths and are followed once per case (`limits_of`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.mechanics.model import Model
from etextile.results.reader import Results
from etextile.studies.run.extrapolation import LawExtrapolation, examine
from etextile.studies.run.lattice_error import LatticeError
from etextile.studies.run.pressing import lattice_cut
from etextile.studies.run.simulate import Simulation
from etextile.types import Array, IntArray
from loadcases.build import Built
from loadcases.schema import Case
from wires.damage import FailureResult
from wires.judge import Judge
from wires.trust import TrustCheck, check_run


WHIFF = 1e-3
"""Strain of the whole fabric whose energy is the least that an energy error is a share of."""


@dataclass(frozen=True)
class Course:
    """Increments (n,) of a path: travel, forces of punch and clamp N, penetration mm, trusses past their force peak.

    work, energy_gap: external work and what of it is not found again, N mm; `unconverged`: number of increments, or a
    path that broke off; `cut_share`: depth of the lattice in the body over its radius, at the end.
    """

    displacement_mm: Array
    force_N: Array
    clamp_force_N: Array
    penetration_mm: Array
    softening: Array | IntArray
    work: Array
    energy_gap: Array
    unconverged: int
    cut_share: float


def limits_of(
    done: Simulation, case: Case, judge: Judge, *, damage: FailureResult | None, lattice: LatticeError | None = None
) -> tuple[LawExtrapolation, tuple[TrustCheck, ...]]:
    """Return what hangs on laws beyond their range, and every trust limit with what was found."""
    laws = examine(done, judge, damage)
    return laws, check(done, case, lattice=lattice, headline_flips=laws.headline_flips)


def check(
    done: Simulation, case: Case, *, lattice: LatticeError | None = None, headline_flips: int = 0
) -> tuple[TrustCheck, ...]:
    """Return the trust limits of a simulation with what was found."""
    rows = done.results.increments
    path = Course(
        displacement_mm=rows.displacement_mm,
        force_N=rows.punch_force_N,
        clamp_force_N=rows.clamp_force_N,
        penetration_mm=rows.max_penetration_mm,
        softening=rows.softening,
        work=rows.external_work,
        energy_gap=_energy_gap(done.results),
        unconverged=int(np.count_nonzero(~rows.converged)) + bool(done.trouble),
        cut_share=lattice_cut(done.results, done.built).share,
    )
    return check_path(path, done.built, case, lattice=lattice, headline_flips=headline_flips)


def check_path(
    path: Course, built: Built, case: Case, *, lattice: LatticeError | None = None, headline_flips: int = 0
) -> tuple[TrustCheck, ...]:
    """Return the trust limits of a path with what was found."""
    force = float(np.abs(path.force_N).max(initial=0.0))
    gap = float(np.abs(path.force_N - path.clamp_force_N).max(initial=0.0))
    return check_run(
        max_penetration_mm=float(path.penetration_mm.max(initial=0.0)),
        allowed_penetration_mm=case.contact.max_penetration,
        energy_error=share_of_work(path.energy_gap, path.work, built.model),
        force_imbalance=None if case.worn else gap / force if force > 0.0 else 0.0,
        lattice_error=None if lattice is None else lattice.error,
        unconverged_increments=path.unconverged,
        body_in_clamp_mm=body_in_clamp(built, float(path.displacement_mm.max(initial=0.0))),
        increments_without_force=without_force(path) if case.motion.target == "body" else 0,
        softening_share=float(path.softening.max(initial=0)) / built.model.truss_count,
        headline_flips=headline_flips,
        cut_share=path.cut_share,
    )


def without_force(path: Course) -> int:
    """Return the number of increments that went deeper than all before and met no resistance any more, or never any.

    What comes before the first resistance does not count: a specimen mounted slack is first pushed straight.
    """
    deepest = np.maximum.accumulate(np.concatenate([[0.0], path.displacement_mm]))[:-1]
    pushes = path.force_N > 0.0
    met = np.maximum.accumulate(pushes) if pushes.any() else np.ones(len(pushes), dtype=np.bool_)
    return int(np.count_nonzero((path.displacement_mm > deepest) & ~pushes & met))


def body_in_clamp(built: Built, deepest: float) -> float:
    """Return how deep a clamped node was inside the body at the `deepest` travel, mm; contact does not act on them."""
    if built.body is None or built.worn is not None:
        return 0.0
    model = built.model
    nodes = slice(len(model.lattice.points))  # unknowns behind the nodes are no places
    held = model.points[nodes][model.fixed[nodes].all(axis=1)]
    shift = deepest * model.direction
    if built.case.motion.target != "body":
        shift = np.zeros(3)
    return max(0.0, -float(built.body.distance(held - shift).gap.min(initial=np.inf)))


def energy_error(done: Simulation) -> float:
    """Return external work not found again as stored, dissipated or penalty energy, as `share_of_work`."""
    return share_of_work(_energy_gap(done.results), done.results.increments.external_work, done.built.model)


def _energy_gap(results: Results) -> Array:
    """Return external work (n,) that is not found again in any form of energy, N mm."""
    rows = results.increments
    return rows.external_work - (rows.stored_energy + rows.plastic_work + rows.friction_work + rows.contact_energy)


def share_of_work(energy: Array, work: Array, model: Model) -> float:
    """Return the largest `energy` (n,) of a path over its largest work (n,), which counts as `least_work` at least."""
    return _most(energy) / max(_most(work), least_work(model))


def least_work(model: Model) -> float:
    """Return the energy (N mm) that strains all yarns of the fabric by `WHIFF`, by their laws.

    A loose sleeve, or a piece that is just touched, does next to no work, and what its quadrature leaves is a large
    share of nothing. A twentieth of this could strain a 50 000th of the fabric to where wires break: it hides no
    verdict.
    """
    block = model.lattice_block
    energy = np.array([law.energy(WHIFF) for law in block.laws])
    return float(np.sum(energy[block.law] * block.area * block.rest_length))


def little_work(done: Simulation) -> str:
    """Return the remark of a run that does less than `least_work`, else nothing."""
    work, least = _most(done.results.increments.external_work), least_work(done.built.model)
    if work >= least or not done.results.steps:
        return ""
    return (
        f"the motion does hardly any work ({work:.2g} N mm at most): its energy error is a share of {least:.2g} N mm, "
        f"which would strain the whole fabric by {100 * WHIFF:g} %"
    )


def _most(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
