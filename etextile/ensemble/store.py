"""One small file per sample: what a run of the ensemble left, written at once or not at all, checked on reading.

A file carries the key of its ensemble (case, seed, method); a sample of another ensemble or a damaged file is not used.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from etextile.kept import keep, recall
from etextile.types import Array


FORMAT = "etextile ensemble sample"
VERSION = 4
FOLDER = "samples"
DONE, BROKEN_OFF = "done", "no equilibrium"


@dataclass(frozen=True)
class SampleKey:
    """What a sample belongs to; `count` is 0 for Sobol points, whose rows do not depend on the number of samples."""

    sha256: str
    seed: int
    method: str
    count: int = 0
    code: str = ""
    """Digest of the program that ran it: no sample of another version is taken for one of this."""


@dataclass(frozen=True)
class Sample:
    """What one run left, over S steps (the first is the flat fabric), W wires and L loops.

    Arrays over steps are NaN from where the run broke off. Probabilities are those given the sample's inputs.
    """

    key: SampleKey
    number: int
    status: str
    reason: str
    inputs: dict[str, float]
    first_failure_mm: float | None
    """Displacement at which the first filament breaks at the mean onset; None when none does."""
    limits: tuple[str, ...]
    """Names of the trust limits that the run exceeded."""
    seconds: float
    displacement_mm: Array
    """(S,)"""
    loop_failure: Array
    """(S, L) probability that a filament of the loop is broken."""
    loop_open: Array
    """(S, L) probability that all are."""
    wire_failure: Array
    """(S, W)"""
    wire_open: Array
    """(S, W)"""
    any_failure: Array
    """(S,) probability that some wire has lost a filament, with what the wires share."""
    any_open: Array
    """(S,)"""
    any_at_end: Array
    """(2, 3) of both at the last step that was reached: value, low and high of what the coupons leave unknown."""
    nets_at_end: Array
    """(N, 3) the same of the loss of each net."""
    max_strain: Array
    """(L,) greatest strain of the criterion's measure."""
    force_N: Array
    """(S,) punch force."""


def sample_path(folder: Path, number: int) -> Path:
    """Return the file of a sample."""
    return folder / FOLDER / f"sample_{number:05d}.npz"


def write_sample(sample: Sample, folder: Path) -> Path:
    """Write a sample's file; a reader sees the whole file or none."""
    path = sample_path(folder, sample.number)
    arrays, plain = _parts(sample)
    keep(path, {"header": json.dumps(plain), **arrays})
    return path


def read_sample(path: Path, key: SampleKey) -> Sample | None:
    """Return the sample in a file; None when there is none, when it is damaged or of another ensemble."""
    content = recall(path, ("header", *_array_names()))
    if content is None:
        return None
    try:
        plain: dict[str, Any] = json.loads(str(content["header"]))
        if plain.pop("format") != FORMAT or plain.pop("version") != VERSION or SampleKey(**plain.pop("key")) != key:
            return None
        arrays: dict[str, Any] = {name: content[name] for name in _array_names()}
        return Sample(key=key, limits=tuple(plain.pop("limits")), **plain, **arrays)
    except (KeyError, TypeError, ValueError, AttributeError):
        return None


def read_samples(folder: Path, key: SampleKey, count: int) -> dict[int, Sample]:
    """Return the usable samples below `count` of an ensemble's folder, by number."""
    found = {number: read_sample(sample_path(folder, number), key) for number in range(count)}
    return {number: sample for number, sample in found.items() if sample is not None and sample.number == number}


def foreign(folder: Path, key: SampleKey) -> bool:
    """Tell whether a folder holds readable samples of another ensemble."""
    for path in sorted((folder / FOLDER).glob("sample_*.npz")):
        content = recall(path, ("header",))
        if content is None:
            continue
        try:
            found = SampleKey(**json.loads(str(content["header"]))["key"])
        except (KeyError, TypeError, ValueError):
            continue
        return (found.sha256, found.seed, found.method, found.count) != (key.sha256, key.seed, key.method, key.count)
    return False


def _parts(sample: Sample) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the arrays and the plain values of a sample."""
    arrays = {name: getattr(sample, name) for name in _array_names()}
    names = [item.name for item in fields(sample) if item.name not in arrays]
    plain: Mapping[str, Any] = {name: getattr(sample, name) for name in names}
    return arrays, {"format": FORMAT, "version": VERSION, **plain, "key": asdict(sample.key)}


def _array_names() -> tuple[str, ...]:
    return tuple(item.name for item in fields(Sample) if item.type == "Array")
