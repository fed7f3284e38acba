"""Nets over several wires against the arithmetic of small networks, and the loss of a net in a whole run."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from etextile.studies.run.run import run
from loadcases.reader import load_case
from wires.circuit import reliability, resistance_between


BRIDGE = [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]


def by_enumeration(edges: list[tuple[int, int]], kept: list[float], ends: tuple[int, ...]) -> float:
    """Add the probability of every combination of edges that connects the ends."""
    total = 0.0
    for alive in product([True, False], repeat=len(edges)):
        reached = {ends[0]}
        for _ in edges:
            for (a, b), lives in zip(edges, alive, strict=True):
                if lives and (a in reached or b in reached):
                    reached |= {a, b}
        if set(ends) <= reached:
            total += float(np.prod([p if lives else 1.0 - p for p, lives in zip(kept, alive, strict=True)]))
    return total


@pytest.mark.parametrize("ends", [(0, 3), (0, 1, 3), (0, 1, 2, 3)])
def test_the_reliability_of_a_bridge_is_that_of_all_its_combinations(ends: tuple[int, ...]) -> None:
    kept = [0.9, 0.7, 0.4, 0.8, 0.6]
    found = reliability(list(zip(BRIDGE, kept, strict=True)), ends)
    assert found == pytest.approx(by_enumeration(BRIDGE, kept, ends), rel=1e-12)


def test_many_cases_at_once_are_each_alone() -> None:
    rng = np.random.default_rng(1)
    kept = rng.uniform(0.0, 1.0, size=(5, 7))
    together = reliability([(edge, row) for edge, row in zip(BRIDGE, kept, strict=True)], (0, 3))
    alone = [by_enumeration(BRIDGE, list(kept[:, k]), (0, 3)) for k in range(7)]
    assert together == pytest.approx(alone, rel=1e-12)


def test_resistors_in_series_and_in_parallel() -> None:
    assert resistance_between([((0, 1), 2.0), ((1, 2), 3.0)], 0, 2) == pytest.approx(5.0)
    assert resistance_between([((0, 1), 2.0), ((0, 1), 2.0)], 0, 1) == pytest.approx(1.0)
    balanced = [(edge, ohm) for edge, ohm in zip(BRIDGE, [1.0, 2.0, 7.0, 1.0, 2.0], strict=True)]
    assert resistance_between(balanced, 0, 3) == pytest.approx(1.0 / (1.0 / 2.0 + 1.0 / 4.0))
    assert resistance_between([((0, 1), 2.0), ((1, 2), np.inf)], 0, 2) == np.inf


CASE = """\
schema_version: 1
extends: punch
title: Nets
fabric: {portion: whole}
motion: {total: 26 mm, steps: 2}
outputs: {maps: []}
failure: {criterion: wire_strain, scatter: 0.02}
wires:
  loops: null
  paths:
    - {name: A, along: warp, at: -4, loops: [0]}
    - {name: B, along: warp, at: 4, loops: [1]}
    - {name: C, along: weft, at: -20}
    - {name: D, along: weft, at: 20}
  joined: [[A, C], [B, C], [A, D], [B, D]]
  components:
    - {name: P, at: [-30, -4], connects: [A]}
    - {name: Q, at: [30, -4], connects: [A]}
    - {name: R, at: [30, 4], connects: [B]}
  nets:
    - {name: one, wires: [A], parts: [P, Q]}
    - {name: two, wires: [A, B, D], parts: [P, R]}
    - {name: ring, wires: [A, B, C, D], parts: [P, R]}
"""


def test_a_way_round_makes_a_net_safer_and_a_longer_one_less_safe(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(CASE)
    report = run(load_case(tmp_path / "case.yaml"), tmp_path / "out").report
    nets = {net["name"]: net for net in report["nets"]}
    loops = {wire["name"]: wire["loops"][0]["open_probability"] for wire in report["wires"] if wire["loops"]}
    assert 0.01 < loops["A"] < 0.99
    for net in nets.values():
        assert net["low"] <= net["loss_probability"] <= net["high"]
        assert net["resistance_before_ohm"] > 0.0
    assert nets["one"]["loss_probability"] == pytest.approx(loops["A"], abs=0.02)
    assert nets["two"]["loss_probability"] == pytest.approx(loops["A"], abs=0.02)
    assert nets["ring"]["loss_probability"] < 0.9 * nets["two"]["loss_probability"]
    assert nets["ring"]["resistance_before_ohm"] < nets["two"]["resistance_before_ohm"]
    assert [net["name"] for net in report["reliability"]["nets"]] == ["one", "two", "ring"]
