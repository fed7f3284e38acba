"""What a run on a limb says beyond strains: joint moment, pressure on the skin, slip, folds, putting on.

Moments and forces are those of the whole piece. A cell is folded when its warp yarns, which run along the limb, are
shorter by more than `FOLDED` than they are long: then the fabric stands in folds, where a membrane has no answer.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from etextile.lattice.weave import DIAGONAL, WARP, WEFT
from etextile.motion.hold import WeakHold
from etextile.results.reader import Results
from etextile.studies.run.pressing import GARMENT_KPA, HARD_KPA, Pressed, nearness, pressed
from etextile.types import Array, BoolArray, IntArray
from loadcases.build import Built
from loadcases.build_worn import Worn, limb_of
from wires.facts import RunCurves, WornFacts
from wires.wording import spoken


FOLDED = 0.05
"""Shortening of the warp from which on a cell, or the span of a loop, counts as folded."""
FAMILIES = {"warp_max": WARP, "weft_max": WEFT, "diagonal_max": DIAGONAL}


def bending(results: Results) -> IntArray:
    """Return the output steps at which the joint bends."""
    return np.flatnonzero(results.displacement_mm > 0.0)


def worn_curves(results: Results, built: Built) -> RunCurves:
    """Return the curves of the report over the steps at which the joint bends."""
    steps = bending(results)
    peaks = {name: np.array([_peak(results, step, family) for step in steps]) for name, family in FAMILIES.items()}
    return RunCurves(
        displacement_mm=results.displacement_mm[steps],
        force_N=np.degrees(results.curves.punch_force_N[steps]),
        draw_in_mm=np.array([slip(results, built, int(step)) for step in steps]),
        **peaks,
    )


def worn_facts(results: Results, built: Built) -> WornFacts:
    """Return the blocks of the report that only a worn case has."""
    worn = _worn(built)
    steps = bending(results)
    folds = [folded_cells(results, int(step)) for step in steps]
    area = cell_areas(results) * built.model.lattice.multiplicity
    skins = [skin(results, built, int(step), folded) for step, folded in zip(steps, folds, strict=True)]
    largest, mean = (np.array([getattr(item, name) for item in skins]) for name in ("largest", "mean"))
    return WornFacts(
        joint={
            "name": getattr(built.case.body, "joint", ""),
            "folded_area_mm2": [float(area @ folded) for folded in folds],
            "folded_share": [float(area @ folded / area.sum()) for folded in folds],
            "folded_beyond": FOLDED,
        },
        contact={
            "pressure_kPa_max": float(largest.max(initial=0.0)),
            "pressure_kPa_mean": float(mean[-1]) if len(mean) else 0.0,
            "over_angle": {"pressure_kPa_max": largest, "pressure_kPa_mean": mean},
        },
        donning=_donning(results, built, worn),
        hold=_hold(results, built),
        folded=folded_loops(results),
    )


def folded_cells(results: Results, step: int) -> BoolArray:
    """Return which cells (q,) are folded at a step: those whose warp yarns are too long by more than `FOLDED`."""
    from viz import surface

    warp = results.family == WARP
    strain = results.array("strain", step)[warp].astype(np.float64)
    quads = _quads(results)
    return surface.cell_values(quads, results.cells[warp], strain, n_points=len(results.grid.reference)) < -FOLDED


def cell_areas(results: Results) -> Array:
    """Return the areas (q,) mm2 of the lattice cells as they lie flat."""
    corners = results.grid.reference[_quads(results)]
    return np.asarray(np.ptp(corners[:, :, 0], axis=1) * _width(corners[:, :, 1]))


def _width(y: Array) -> Array:
    """Return the extents (q,) of cells around, also of those across a seam, which are as wide as their neighbours."""
    wide = np.ptp(y, axis=1)
    return np.asarray(np.where(wide > 3.0 * np.median(wide), np.median(wide), wide))


def skin(results: Results, built: Built, step: int, folded: BoolArray) -> Pressed:
    """Return the pressure of nodes outside of folds on the skin."""
    count = len(_worn(built).piece.places)
    return pressed(
        results.points(step)[:count],
        results.array("contact_force", step)[:count].astype(np.float64),
        nearness(built, float(results.displacement_mm[step])),
        quads=_quads(results),
        left_out=folded,
    )


def slip(results: Results, built: Built, step: int) -> float:
    """Return how far the ends have slipped along the skin since it was straight, mm; 0 where they are held."""
    worn = _worn(built)
    lattice = worn.piece.lattice
    nodes = np.flatnonzero((lattice.edges["x_min"] | lattice.edges["x_max"]) & ~worn.fixed.all(axis=1))
    if not len(nodes):
        return 0.0
    straight = np.flatnonzero(results.displacement_mm <= 0.0)
    before = results.points(int(straight[-1]))[nodes] if len(straight) else worn.piece.places[nodes]
    led = worn.motion.carried(before, 0.0, float(results.displacement_mm[step]))
    return float(np.linalg.norm(results.points(step)[nodes] - led, axis=1).max())


def _donning(results: Results, built: Built, worn: Worn) -> dict[str, Any] | None:
    """Return what putting the piece on did, None when it lies on the limb from the start."""
    steps = np.flatnonzero(results.displacement_mm <= 0.0)
    if not len(steps):
        return None
    last = int(steps[-1])
    found = skin(results, built, last, np.zeros(len(_quads(results)), dtype=bool))
    growth, wires = worn.donning + results.displacement_mm[steps], results.wires
    return {
        "growth_mm": growth,
        "force_N": results.curves.punch_force_N[steps],
        "strain": {name: _peak(results, last, family) for name, family in FAMILIES.items()},
        "pressure_kPa_max": found.largest,
        "pressure_kPa_mean": found.mean,
        "wire_strain_max": None if wires is None else float(wires.wire_strain[1 + last].max(initial=0.0)),
    }


def _hold(results: Results, built: Built) -> dict[str, Any] | None:
    """Return what the weak hold stores at most, beside the largest work of the motion; None without one."""
    hold = next((part for part in built.model.contributions if isinstance(part, WeakHold)), None)
    if hold is None or not results.steps:
        return None
    count = len(built.model.lattice.points)
    energies = [
        hold.respond(results.points(step)[:count], float(results.displacement_mm[step]), None).energy().stored
        for step in range(results.steps)
    ]
    work = float(np.abs(results.increments.external_work).max(initial=0.0))
    return {
        "stored_Nmm": max(energies),
        "share_of_work": max(energies) / work if work > 0.0 else 0.0,
        "stiffness_N_per_mm3": float(np.median(hold.stiffness / built.model.lattice.share[hold.nodes[:, 0]]))
        / built.model.lattice.cell_area,
    }


def folded_loops(results: Results, *, until: int | None = None) -> BoolArray:
    """Return the loops (L,) whose span was ever shorter by more than `FOLDED` while the joint bent, up to a step."""
    if results.wires is None:
        return np.zeros(0, dtype=bool)
    steps = bending(results)
    chosen = steps if until is None else steps[steps <= until]
    return np.asarray((results.wires.span_strain[1 + chosen] < -FOLDED).any(axis=0))


def _peak(results: Results, step: int, family: int) -> float:
    """Return the largest strain of a family at a step."""
    return float(results.array("strain", step)[results.family == family].max(initial=0.0))


def _quads(results: Results) -> IntArray:
    quads = results.grid.quads
    return np.zeros((0, 4), dtype=np.int64) if quads is None else quads


def _worn(built: Built) -> Worn:
    if built.worn is None:
        raise ValueError("the case is not worn")
    return built.worn


def worn_notes(facts: WornFacts) -> Mapping[str, str]:
    """Return remarks for the reader: what is idealised, and how much the weak hold matters."""
    notes = {
        "idealised": (
            "the limb is rigid (flesh gives way: real pressures are lower), folds in the crook carry nothing and are "
            "undetermined, seams are as the fabric beside them; bending of the fabric, washing and ageing are left out"
        )
    }
    mean = facts.contact["pressure_kPa_mean"]
    if mean > HARD_KPA:
        notes["pressure"] = (
            f"it presses on the limb with {spoken(mean, 'kPa')} on average at the end, garments on skin with up to "
            f"{GARMENT_KPA:.0f} kPa: what is held and cannot slide is stretched as no limb of flesh would stretch it"
        )
    if facts.hold is not None:
        notes["hold"] = (
            f"a weak hold keeps the piece from sliding freely; it stores {100 * facts.hold['share_of_work']:.2g} % of "
            "the work of the motion"
        )
    return notes


def bend_note(results: Results, built: Built) -> str:
    """Return the remark on a loose tube that is narrower than the bent limb is round, nothing of any other piece."""
    width, reached = built.case.pattern[1], float(results.displacement_mm.max(initial=0.0))
    if built.case.fabric.shape != "tube" or reached < 1.0:
        return ""
    limb, angles = limb_of(built.case), np.append(np.arange(0.0, reached), reached)
    girths = np.array([limb.bend_girth(angle) for angle in np.radians(angles)])
    if not girths[0] < width < girths.max():
        return ""
    grown = 100.0 * (girths.max() / girths[0] - 1.0)
    return (
        f"the girth of the limb in the plane that halves the joint grows by {grown:.0f} % "
        f"up to {reached:g} deg: from {angles[np.argmax(girths > width)]:.0f} deg on the tube is too narrow for it and "
        "stretched round the crook, whatever its ends do"
    )
