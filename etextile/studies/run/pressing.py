"""How a body presses on the fabric, and how deep the lattice cuts into it between its nodes.

Pressure is the normal force of nodes over the area that they stand for as it is stretched. Flat pieces of lattice are
chords of a round body: on a radius R of curvature a chord of length h cuts h^2 / (8 R) deep, so the fabric is led
around a body that much too small. The share of the radius bounds what that does to strains and forces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from etextile.contact.body import Distance
from etextile.results.reader import Results
from etextile.types import Array, BoolArray, IntArray
from loadcases.build import Built
from wires.wording import spoken


GARMENT_KPA = 6.0
"""What the tightest garments press with: compression stockings of classes 1 to 3, 2.4 to 6.1 kPa (RAL-GZ 387)."""
HARD_KPA = 2.0 * GARMENT_KPA
"""Mean pressure from which a report says that no garment presses so."""

Nearness = Callable[[Array], Distance]


@dataclass(frozen=True)
class Pressed:
    """Contact at a step: pressure (n,) kPa on touching nodes, and the area (n,) mm2 they stand for."""

    pressure: Array
    area: Array

    @property
    def largest(self) -> float:
        """Largest pressure, kPa."""
        return float(self.pressure.max(initial=0.0))

    @property
    def mean(self) -> float:
        """Pressure over the area that touches, kPa."""
        return float(self.pressure @ self.area / self.area.sum()) if len(self.area) else 0.0


def pressed(points: Array, force: Array, near: Nearness, *, quads: IntArray, left_out: BoolArray) -> Pressed:
    """Return the pressure on nodes `points` (n, 3) mm under contact forces (n, 3) N; `left_out` (q,) no cells."""
    touching = np.flatnonzero(np.any(force != 0.0, axis=1))
    normal = np.einsum("nc,nc->n", force[touching], near(points[touching]).normal)
    corners = points[quads]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)
    area[left_out] = 0.0
    around = np.bincount(quads.ravel(), np.repeat(0.25 * area, 4), minlength=len(points)).astype(np.float64)
    own = around[touching]
    in_left_out = np.bincount(quads[left_out].ravel(), minlength=len(points))[touching] > 0
    counted = ~in_left_out & (own > 0.0)
    return Pressed(1e3 * normal[counted] / own[counted], own[counted])


def nearness(built: Built, travel: float) -> Nearness:
    """Return the distance from the body of a case where it is at `travel`; raises ValueError without a body."""
    if built.body is None:
        raise ValueError("the case has no body")
    if built.worn is not None:
        motion = built.worn.motion
        return motion.posed(built.body, travel).distance
    body, shift = built.body, travel * built.model.direction
    shift = shift if built.case.motion.target == "body" else np.zeros(3)
    return lambda places: body.distance(places - shift)


def contact_block(results: Results, built: Built) -> dict[str, Any] | None:
    """Return the block `contact` of the report of a body pressed into a flat piece, at the end; None without one.

    `pressure_kPa_max` belongs to one node and grows somewhat as the lattice gets finer.
    """
    if built.body is None or built.worn is not None or results.steps == 0 or results.grid.quads is None:
        return None
    last, count = results.steps - 1, len(built.model.lattice.points)
    found = pressed(
        results.points(last)[:count],
        results.array("contact_force", last)[:count].astype(np.float64),
        nearness(built, float(results.displacement_mm[last])),
        quads=results.grid.quads,
        left_out=np.zeros(len(results.grid.quads), dtype=bool),
    )
    return {
        "pressure_kPa_max": found.largest,
        "pressure_kPa_mean": found.mean,
        "area_mm2": float(found.area.sum()) * built.model.lattice.multiplicity,
    }


def pressure_note(contact: dict[str, Any]) -> str | None:
    """Say that a body presses far harder than garments do, None when it does not."""
    mean = contact["pressure_kPa_mean"]
    if mean <= HARD_KPA:
        return None
    return (
        f"the body presses with {spoken(mean, 'kPa')} on average over {0.01 * contact['area_mm2']:.1f} cm2, garments "
        f"on skin with up to {GARMENT_KPA:.0f} kPa: this is a test of the fabric, not how it is worn"
    )


def add_contact(report: dict[str, Any], results: Results, built: Built) -> None:
    """Add the block `contact` to the report of a body pressed into a flat piece, with a remark when it presses hard."""
    block = contact_block(results, built)
    if block is None:
        return
    cut = lattice_cut(results, built)
    report["contact"] = {**block, "lattice_cut_mm": cut.depth, "lattice_cut_share": cut.share}
    note = pressure_note(block)
    report["notes"] += [note] if note else []


@dataclass(frozen=True)
class Cut:
    """How deep the lattice cuts into the body, mm, and the largest share of the radius of curvature there."""

    depth: float
    share: float


def lattice_cut(results: Results, built: Built) -> Cut:
    """Return how deep the lattice is in the body at the end; zero without a body."""
    if results.steps == 0:
        return Cut(0.0, 0.0)
    return cut_at(built, float(results.displacement_mm[-1]), results.points(results.steps - 1), results.cells)


def cut_at(built: Built, travel: float, points: Array, cells: IntArray) -> Cut:
    """Return how deep middles of trusses `cells` (M, 2) and `points` (n, 3) are in the body; zero without a body."""
    if built.body is None:
        return Cut(0.0, 0.0)
    places = np.concatenate([points[cells].mean(axis=1), points])
    found = nearness(built, travel)(places)
    depth = np.maximum(-found.gap, 0.0)
    inside = depth > 0.0
    # the distance is measured inside, where the level surface is rounder: R there is R of the body minus the depth
    bend = np.linalg.eigvalsh(found.hessian[inside])[:, -1].clip(min=0.0)
    share = depth[inside] * bend / (1.0 + depth[inside] * bend)
    return Cut(float(depth.max(initial=0.0)), float(share.max(initial=0.0)))
