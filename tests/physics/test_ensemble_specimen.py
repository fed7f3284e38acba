"""Sampled specimens: without scatter the nominal model, with it what was drawn, each input with the expected sense."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from etextile.ensemble.inputs import COLUMNS, REACH
from etextile.ensemble.sample import local_normal
from etextile.ensemble.store import BROKEN_OFF, DONE, Sample, SampleKey
from etextile.mechanics.truss import TrussBlock
from etextile.studies.ensemble.sample import FINE, between, run_sample
from etextile.studies.ensemble.specimen import SampledSpecimen, SampleTask, nominal, specimen_of
from loadcases.reader import as_loaded, load_case


SMALL = ("fabric.coarsening=60", "motion.total=28 mm", "motion.steps=7", "scatter.loop_slack=0")


def task(*overrides: str, **units: float) -> SampleTask:
    loaded = as_loaded(load_case("punch", overrides=(*SMALL, *overrides)).case)
    row = tuple(units.get(name, 0.5) for name in COLUMNS)
    return SampleTask(loaded.source_text, SampleKey(loaded.sha256, 1, "sobol"), "nowhere", 4, row)


def specimen(*overrides: str, **units: float) -> SampledSpecimen:
    one = task(*overrides, **units)
    return specimen_of(nominal(one.case_text), one)


@cache
def sample(*overrides: str, **units: float) -> Sample:
    return run_sample(task(*overrides, **units))


def wires(made: SampledSpecimen) -> list[TrussBlock]:
    return [block for block in made.built.model.truss_blocks if block.family[0] == 3]


def test_in_the_middle_of_all_distributions_stands_the_nominal_specimen() -> None:
    made, usual = specimen(), nominal(task().case_text).built
    assert made.strength == 1.0
    for block, other in zip(made.built.model.truss_blocks, usual.model.truss_blocks, strict=True):
        assert np.array_equal(block.table, other.table)
        assert np.array_equal(block.rest_length, other.rest_length)


def test_strength_is_a_factor_whose_logarithm_is_normal() -> None:
    """As `wires.dependence` has it; 1 + 0.05 z would lose a wire oftener (0.869 for 0.867 on a strip at 6.5 %)."""
    weak, strong = (specimen(strength=unit).strength for unit in (0.1, 0.9))
    assert weak * strong == pytest.approx(1.0, rel=1e-12)
    assert np.log(strong) == pytest.approx(0.05 * 1.2815516, rel=1e-5)


def test_laws_scatter_by_family() -> None:
    made, usual = specimen(weft_1=1.0), nominal(task().case_text).built
    laws = made.built.model.lattice_block.laws
    assert laws[0] == usual.model.lattice_block.laws[0]
    before = usual.model.lattice_block.laws[1]
    stiffer = laws[1].E / before.E
    assert stiffer == pytest.approx(7000 / 4500)
    assert made.inputs["warp_level"] == 1.0
    assert made.inputs["weft_level"] > 1.02


def test_mounting_strains_fabric_and_wires_before_the_test() -> None:
    made = specimen(mounting=1.0)
    strain = REACH * 0.002
    assert made.inputs["mounting"] == pytest.approx(strain)
    model = made.built.model
    for block in model.truss_blocks:
        along_warp = np.isin(block.family, (0, 3))
        response = block.respond(model.points, 0.0, block.initial_state())
        flat = nominal(task().case_text).built.model.truss_blocks
        rest = next(other for other in flat if other.name == block.name).rest_length
        assert (rest / block.rest_length)[along_warp] == pytest.approx(1.0 + strain)
        if block.family[0] == 3:
            assert response.strain == pytest.approx(strain)


def test_slack_scatters_loop_by_loop() -> None:
    made, usual = specimen("scatter.loop_slack=30 %"), nominal(task().case_text).built
    record, before = made.built.wires, usual.wires
    assert record is not None
    assert before is not None
    slack = record.layout.loop_slack
    own = local_normal(3, seed=1, sample=4, place=0, reach=REACH)
    assert slack[:3] == pytest.approx(0.02 * (1.0 + 0.3 * own))
    assert (slack >= 0.0).all()
    loops = np.concatenate([block.rest_length for block in wires(made)])[record.count :]
    spans = np.concatenate([block.span for block in wires(made)])[record.count :]
    assert loops / spans == pytest.approx(1.0 + slack)


def test_wires_and_body_stand_where_they_were_drawn() -> None:
    made = specimen("fabric.portion=whole", wire_offset=1.0, loop_offset=0.0, punch_x=1.0)
    record, body = made.built.wires, made.built.body
    assert record is not None
    assert body is not None
    assert np.min(np.abs(record.layout.weft_mm - 0.9)) == pytest.approx(0.0, abs=1e-9)
    assert np.min(np.abs(record.layout.loop_warp_mm + 1.5)) == pytest.approx(0.0, abs=1e-9)
    assert body.distance(np.array([[1.5, 0.0, 0.0]])).gap[0] == pytest.approx(0.0, abs=1e-9)


def test_probabilities_rise_and_a_wire_is_worse_off_than_its_loops() -> None:
    found = sample()
    assert found.status == DONE
    assert len(found.displacement_mm) > FINE
    assert found.displacement_mm[-1] == 28.0
    assert (np.diff(found.loop_failure, axis=0) >= 0.0).all()
    assert (found.loop_open <= found.loop_failure + 1e-12).all()
    assert (found.wire_failure[:, :1] >= found.loop_failure[:, :3] - 1e-12).all()


def test_stronger_wires_fail_later_and_taut_specimens_push_back_harder() -> None:
    weak, usual, strong = sample(strength=0.02), sample(), sample(strength=0.98)
    slack, taut = sample(mounting=0.02), sample(mounting=0.98)
    order = [weak, usual, strong]
    firsts = [item.first_failure_mm for item in order]
    assert None not in firsts
    assert firsts == sorted(firsts, key=lambda value: value or 0.0)
    assert len(set(firsts)) == 3
    assert weak.max_strain == pytest.approx(strong.max_strain, rel=1e-12)
    assert taut.force_N[-1] > usual.force_N[-1] > slack.force_N[-1]


def test_a_stiffer_fabric_needs_more_force() -> None:
    assert sample(warp_1=1.0).force_N[-1] > 1.03 * sample(warp_1=0.0).force_N[-1]


def test_a_sample_depends_on_its_task_alone() -> None:
    one = task(strength=0.3, warp_1=0.8)
    first = run_sample(one)
    run_sample(replace(task(weft_1=0.1, mounting=0.9), number=9))
    again = run_sample(one)
    assert np.array_equal(first.loop_failure, again.loop_failure)
    assert np.array_equal(first.force_N, again.force_N)
    assert first.inputs == again.inputs


def test_a_run_without_equilibrium_keeps_what_it_showed() -> None:
    found = run_sample(task("solver.max_iterations=4", "solver.max_cut_backs=0"))
    assert found.status == BROKEN_OFF
    assert "no equilibrium" in found.reason
    assert np.isnan(found.loop_failure[-1]).all()
    assert (found.loop_failure[0] == 0.0).all()


def test_steps_between_lie_on_straight_lines_and_keep_the_ends() -> None:
    values = np.array([[0.0, 1.0], [3.0, 1.0], [0.0, 7.0]])
    fine = between(values, 3)
    assert fine.shape == (7, 2)
    assert fine[::3] == pytest.approx(values)
    assert fine[:, 0] == pytest.approx([0, 1, 2, 3, 2, 1, 0])
    assert between(values[:1], 3) == pytest.approx(values[:1])
