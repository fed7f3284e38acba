"""Laws beyond the range they were identified in: which verdicts hang on them, and what is decided by geometry."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.lattice.weave import WARP
from etextile.laws.powerlaw import PowerLaw, dissipated_energy, respond, stored_energy
from etextile.solve.path import advance
from etextile.studies.run.continuation import continued_law, continued_model
from loadcases.build import build, settings
from loadcases.fabric import dump_fabric, load_fabric
from loadcases.reader import load_case


LAW = PowerLaw(E=3000.0, sigma_y0=0.2, H=9960.0, n=1.5)
ONSET = 0.12
TOTALS = (16, 30)
COARSE = {"fabric.coarsening": 39, "motion.steps": 10, "outputs.maps": []}


def stress_at(law: PowerLaw, p: float) -> float:
    """Return the true stress at a plastic strain, by bisection of E (eps - p) = sigma with our own eyes on sigma."""
    low, high = p, p + 1.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        found = respond(law.row(), middle, 0.0)[2]
        low, high = (middle, high) if found < p else (low, middle)
    return law.E * (low - p)


def onset_of(law: PowerLaw) -> float:
    """Return the plastic strain at 12 % engineering strain, from E (eps - p) = s(p) solved here."""
    eps = np.log1p(ONSET)
    low, high = 0.0, eps
    for _ in range(200):
        p = 0.5 * (low + high)
        s = law.sigma_y0 * p / (p + law.e0) + law.H * p**law.n
        low, high = (p, high) if law.E * (eps - p) > s else (low, p)
    return p


@pytest.mark.parametrize(("slope", "factor"), [(0.5, 0.5), (2.0, 2.0), (1.0, 1.0)])
def test_a_continuation_scales_the_slope_of_the_law_beyond_its_range_and_nothing_before(
    slope: float, factor: float
) -> None:
    """s(p) = s(q) + factor (s0(p) - s0(q)) beyond q, s0 the identified law."""
    law, q = continued_law(LAW, slope, ONSET), onset_of(LAW)
    for p in (0.3 * q, 0.9 * q):
        assert stress_at(law, p) == pytest.approx(stress_at(LAW, p), rel=1e-9)
    base = LAW.sigma_y0 * q / (q + LAW.e0) + LAW.H * q**LAW.n
    for p in (1.2 * q, 3.0 * q):
        own = LAW.sigma_y0 * p / (p + LAW.e0) + LAW.H * p**LAW.n
        assert stress_at(law, p) == pytest.approx(base + factor * (own - base), rel=1e-6)


def test_the_tangent_goes_straight_on_and_keeps_force_and_energy_consistent() -> None:
    """Beyond the range the slope is the last one, 1.5 H sqrt(q) and what sigma_y0 adds; tau is the energy's slope."""
    law, q = continued_law(LAW, "tangent", ONSET), onset_of(LAW)
    slope = 1.5 * LAW.H * np.sqrt(q) + LAW.sigma_y0 * LAW.e0 / (q + LAW.e0) ** 2
    rise = stress_at(law, 3.0 * q) - stress_at(law, 1.5 * q)
    assert rise == pytest.approx(slope * 1.5 * q, rel=1e-6)

    def energy(eps: float) -> float:
        p = respond(law.row(), eps, 0.0)[2]
        return float(stored_energy(law.row(), eps, p) + dissipated_energy(law.row(), p))

    for eps in (0.15, 0.3):
        h = 1e-5
        assert (energy(eps + h) - energy(eps - h)) / (2 * h) == pytest.approx(respond(law.row(), eps, 0.0)[0], rel=1e-6)


def test_within_their_ranges_nothing_is_followed_and_every_loop_is_decided(tmp_path: Path) -> None:
    """The punch at 15 mm stretches the warp by less than 12 %."""
    run = et.run(et.load("punch", {**COARSE, "motion.total": 15}), tmp_path)
    block = run.report["extrapolation"]
    assert block["beyond"] == []
    assert block["continuations"] == {}
    assert block["warp"]["reached"] == pytest.approx(max(run.report["strain"]["warp_max"]), rel=1e-5)
    assert block["decided_by_geometry"] == block["loops"] == 9 * 3


@pytest.mark.slow
def test_continuations_from_the_last_state_inside_are_the_runs_with_those_laws(tmp_path: Path) -> None:
    """Forces under low and high equal those of whole load paths from the flat piece with the same laws."""
    case = et.load("punch", {**COARSE, "motion.total": 40})
    run = et.run(case, tmp_path)
    block = run.report["extrapolation"]
    assert set(block["beyond"]) >= {"warp", "weft"}
    built = build(case.case)
    forces = {}
    for way in ("low", "high"):
        *_, last = advance(continued_model(built, way), settings(case.case))  # type: ignore[arg-type]
        forces[way] = last.punch_force_N
        assert block["continuations"][way]["force_N"] == pytest.approx(last.punch_force_N, rel=1e-4)
    assert forces["low"] < run.report["punch"]["force_N"][-1] < forces["high"]


@pytest.mark.slow
def test_a_verdict_that_the_continuation_turns_is_open_to_the_law_and_a_turned_headline_is_a_limit(
    tmp_path: Path,
) -> None:
    """Identified to 2 % only, and known there within a factor of hundreds, the wires may or may not survive."""
    fabric = load_fabric("estimated_mid")
    wide = type(fabric.warp.beyond)(low=0.02, high=10.0)
    laws = {
        name: getattr(fabric, name).model_copy(update={"strain_range": (0.0, 0.02), "beyond": wide})
        for name in ("warp", "weft", "diagonal")
    }
    path = tmp_path / "unknown.yaml"
    path.write_text(dump_fabric(fabric.model_copy(update=laws)), encoding="utf-8")
    at = {**COARSE, "fabric.coarsening": 30, "fabric.set": str(path), "failure.criterion": "calibrated"}
    turned, sure = (et.run(et.load("punch", {**at, "motion.total": total}), tmp_path / str(total)) for total in TOTALS)
    for run in (turned, sure):
        block = run.report["extrapolation"]
        named = {(part["wire"], part["loop"]) for part in block["verdicts_that_hang_on_it"] if part["loop"] is not None}
        marked = {
            (wire["wire"], loop["loop"])
            for wire in run.report["wires"]
            for loop in wire["loops"]
            if loop["open_to_the_law"]
        }
        assert named == marked != set()
        assert block["decided_by_geometry"] == block["loops"] - len(named)
    answers = {block["survive"] for block in turned.report["extrapolation"]["continuations"].values()}
    assert answers == {True, False}
    assert turned.exit_code == 4
    assert turned.report["verdict"]["survive"] is None
    assert sure.exit_code == 0
    assert sure.report["verdict"]["survive"] is False


def test_the_law_of_an_effect_stays_what_the_effect_says() -> None:
    """yarn_tail states the law beyond the range; the fabric's continuation does not overrule it."""
    stated = replace(LAW, tail_onset=0.1, tail_factor=-0.7)
    assert continued_law(stated, 2.0, ONSET) is stated


def test_effects_and_wires_keep_their_place_when_laws_are_continued() -> None:
    """Only the laws of the fabric change."""
    built = build(load_case("punch", overrides=["fabric.coarsening=39"]).case)
    low = continued_model(built, "low")
    assert len(low.contributions) == len(built.model.contributions)
    assert low.lattice_block.laws[WARP].tail_factor == pytest.approx(-0.5)
    assert all(a is b for a, b in zip(low.contributions[1:], built.model.contributions[1:], strict=True))


@pytest.mark.slow
def test_wires_without_loops_are_followed_beyond_the_range_too(tmp_path: Path) -> None:
    wires = {"every_warp_yarns": 76, "loops": None}
    changes = {"wires": wires, "motion.total": "12 mm", "motion.steps": 3, "fabric.coarsening": 80, "outputs.maps": []}
    report = et.run(et.load("tension_warp", changes), tmp_path / "out").report
    assert report["extrapolation"]["warp"]["reached"] > report["extrapolation"]["warp"]["identified_to"]
    assert all(wire["loops"] == [] for wire in report["wires"])
