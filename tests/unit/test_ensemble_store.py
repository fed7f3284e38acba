"""Sample files: exact, whole or not at all, used for their own ensemble only."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from etextile.ensemble.store import (
    BROKEN_OFF,
    Sample,
    SampleKey,
    foreign,
    read_sample,
    read_samples,
    sample_path,
    write_sample,
)


KEY = SampleKey("abc", 3, "sobol")


def sample(number: int = 0) -> Sample:
    rng = np.random.default_rng(number)
    loops, wires = rng.random((4, 6)), rng.random((4, 2))
    loops[3], wires[3] = np.nan, np.nan
    return Sample(
        key=KEY,
        number=number,
        status=BROKEN_OFF,
        reason="no equilibrium at 3 mm",
        inputs={"strength": 0.1 / 3.0},
        first_failure_mm=None,
        limits=("penetration",),
        seconds=0.5,
        displacement_mm=np.linspace(0.0, 3.0, 4),
        loop_failure=loops,
        loop_open=loops**2,
        wire_failure=wires,
        wire_open=wires**2,
        any_failure=wires.max(axis=1),
        any_open=wires.max(axis=1) ** 2,
        any_at_end=rng.random((2, 3)),
        nets_at_end=rng.random((1, 3)),
        max_strain=rng.random(6),
        force_N=rng.random(4),
    )


def same(a: Sample, b: Sample) -> bool:
    return all(
        np.array_equal(getattr(a, item.name), getattr(b, item.name), equal_nan=True)
        if isinstance(getattr(a, item.name), np.ndarray)
        else getattr(a, item.name) == getattr(b, item.name)
        for item in fields(Sample)
    )


def test_a_sample_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    path = write_sample(sample(7), tmp_path)
    found = read_sample(path, KEY)
    assert found is not None
    assert same(found, sample(7))
    assert path == sample_path(tmp_path, 7)
    assert [item.name for item in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize("other", [replace(KEY, seed=4), replace(KEY, sha256="abd"), SampleKey("abc", 3, "lhs", 8)])
def test_samples_of_another_ensemble_are_not_used(tmp_path: Path, other: SampleKey) -> None:
    path = write_sample(sample(), tmp_path)
    assert read_sample(path, other) is None
    assert foreign(tmp_path, other)
    assert not foreign(tmp_path, KEY)


@pytest.mark.parametrize("keep", [0, 20, 400, -10])
def test_a_damaged_file_is_run_again(tmp_path: Path, keep: int) -> None:
    path = write_sample(sample(), tmp_path)
    path.write_bytes(path.read_bytes()[:keep])
    assert read_sample(path, KEY) is None
    assert read_samples(tmp_path, KEY, 1) == {}
    assert not foreign(tmp_path, KEY)


def test_a_file_under_the_wrong_number_is_not_used(tmp_path: Path) -> None:
    write_sample(sample(2), tmp_path).rename(sample_path(tmp_path, 1))
    assert read_samples(tmp_path, KEY, 5) == {}


def test_missing_samples_are_missing(tmp_path: Path) -> None:
    for number in (0, 3):
        write_sample(sample(number), tmp_path)
    assert sorted(read_samples(tmp_path, KEY, 5)) == [0, 3]
    assert sorted(read_samples(tmp_path, KEY, 2)) == [0]
    assert not foreign(tmp_path / "nowhere", KEY)
