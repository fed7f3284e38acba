"""Gaps of the base, the re-tuned base and the floor, against what linear algebra by hand says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.observe import PEAKS, Record
from etextile.diagnose.data.points import gather
from etextile.diagnose.data.punched import PunchForce
from etextile.diagnose.decide.gap import FITTED, HELD_OUT, Gap
from etextile.diagnose.decide.proof import (
    BASE,
    EFFECT,
    FLOOR,
    RETUNED,
    Proof,
    RunPair,
    base_gap,
    change_by_runs,
    prove,
    raw_deviation,
)
from etextile.diagnose.infer.whitened import LatticeDoubt, Workbench, set_up


SPLIT = 20.0
TRAVEL = np.linspace(0.5, 40.0, 80)
NOISE = 2.0


def of_part(found: tuple[Gap, ...], channel: str, part: str) -> Gap | None:
    """Return the gap of a channel over a part, None when it has no points."""
    return next((gap for gap in found if (gap.channel, gap.part) == (channel, part)), None)


def simulated(travel: np.ndarray) -> np.ndarray:
    return 0.6 * travel**2


def record() -> Record:
    """A run of the base: only its force matters."""
    travel = np.linspace(0.0, 40.0, 25)
    x = np.linspace(0.0, 50.0, 5)
    return Record(x, x, (True, True), travel, simulated(travel), np.zeros((25, 5, 5, 3)), np.zeros((25, len(PEAKS))))


def bench(measured: np.ndarray, freedom: np.ndarray | None = None, *, noise: float = NOISE) -> Workbench:
    """A workbench of one force curve whose base parameters may change it by the columns of `freedom` (80, 9)."""
    curve = PunchForce("a.csv", TRAVEL, measured, noise)
    points = gather(Measurements("test", ".", (curve,)))
    nothing = np.zeros((80, 0))
    lattice = LatticeDoubt(simulated(TRAVEL), nothing, np.zeros(80))
    return set_up(points, record(), lattice, np.zeros((80, 9)) if freedom is None else freedom)


def proven(measured: np.ndarray, **options: np.ndarray | None) -> Proof:
    freedom = options.pop("freedom", None)
    free = options.pop("free_columns", None)
    return prove(
        bench(measured, freedom), simulated(TRAVEL), record(), split=SPLIT, free_columns=free,
        fitted_effect=options.get("fitted"), held_out_effect=options.get("held_out"),
    )  # fmt: skip


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_per_cent_is_rms_of_the_difference_over_rms_of_what_was_measured() -> None:
    measured = 1.1 * simulated(TRAVEL)
    found = base_gap(bench(measured), simulated(TRAVEL), record())[0]
    assert found.before_percent == pytest.approx(100.0 * rms(0.1 * simulated(TRAVEL)) / rms(measured), rel=1e-9)
    assert found.before_chi == pytest.approx(rms(0.1 * simulated(TRAVEL) / raw_deviation(bench(measured))), rel=1e-9)


def test_the_effect_counts_as_fitted_up_to_the_split_and_as_predicted_beyond() -> None:
    gap = 0.2 * simulated(TRAVEL)
    proof = proven(simulated(TRAVEL) + gap, fitted=gap, held_out=0.5 * gap)
    early = of_part(proof.gaps, "punch_force", FITTED)
    late = of_part(proof.gaps, "punch_force", HELD_OUT)
    assert early is not None
    assert late is not None
    assert early.after_percent == pytest.approx(0.0, abs=1e-9)
    assert late.after_percent == pytest.approx(0.5 * late.before_percent, rel=1e-9)
    assert proof.patched is not None
    np.testing.assert_allclose(proof.patched, simulated(TRAVEL) + gap)


def test_an_ordinary_run_loses_its_own_lattice_error() -> None:
    """On the coarse lattice everything is 5 % too soft: without the effect, and with one that halves the force."""

    def scaled(factor: float) -> Record:
        return replace(record(), force=factor * record().force)

    found = change_by_runs(
        bench(simulated(TRAVEL)),
        RunPair(scaled(0.95), scaled(0.475)),
        coarse=RunPair(scaled(0.95), scaled(0.475)),
        finest=RunPair(scaled(1.0), scaled(0.5)),
    )
    np.testing.assert_allclose(found, -0.5 * simulated(TRAVEL), rtol=1e-9)


def test_without_an_effect_nothing_changes() -> None:
    proof = proven(1.2 * simulated(TRAVEL))
    assert EFFECT not in proof.predictions
    assert all(gap.before_percent == gap.after_percent for gap in proof.gaps)


def test_fabric_parameters_take_up_what_they_can_and_no_more() -> None:
    """One parameter that changes the force by 3 % takes up about that share of a gap of 3 %, little of one of 30 %."""
    freedom = np.zeros((80, 9))
    freedom[:, 0] = 0.03 * simulated(TRAVEL)
    left = {}
    for size in (0.03, 0.30):
        proof = proven((1.0 + size) * simulated(TRAVEL), freedom=freedom)
        rows = {name: of_part(proof.rows[name], "punch_force", HELD_OUT) for name in (BASE, RETUNED)}
        assert rows[BASE] is not None
        assert rows[RETUNED] is not None
        left[size] = rows[RETUNED].after_percent / rows[BASE].after_percent
    assert left[0.03] == pytest.approx(left[0.30], rel=0.3)
    assert 0.02 < left[0.03] < 0.6


def test_the_floor_is_what_noise_and_scatter_leave() -> None:
    rng = np.random.default_rng(0)
    bump = 60.0 * np.exp(-(((TRAVEL - 30.0) / 8.0) ** 2))
    measured = simulated(TRAVEL) + bump + NOISE * rng.standard_normal(80)
    shapes = np.stack([np.exp(-(((TRAVEL - u) / 8.0) ** 2)) for u in np.arange(0.0, 45.0, 5.0)], axis=1)
    workbench = bench(measured)
    proof = prove(
        workbench, simulated(TRAVEL), record(), split=SPLIT, free_columns=100.0 * workbench.bins.average(shapes)
    )
    floor = of_part(proof.rows[FLOOR], "punch_force", HELD_OUT)
    base = of_part(proof.rows[BASE], "punch_force", HELD_OUT)
    assert floor is not None
    assert base is not None
    assert base.after_chi > 3.0
    assert floor.after_chi < 1.0
    assert floor.after_percent > 100.0 * 0.8 * NOISE / rms(measured[TRAVEL > SPLIT])
