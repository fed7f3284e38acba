"""The output folder of compare and diagnose: what belongs to the same question is renewed, nothing else overwritten."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from etextile.diagnose.data.measured import Measurements
from etextile.errors import BadInput
from etextile.files import write_whole
from etextile.studies.diagnose.setting import DiagnosisTask


CACHE = "cache"
"""Simulator runs, kept so that a repeated or interrupted call goes on from them."""
MARK = "made_from.json"
"""Says what the files of a folder were made from."""


@dataclass(frozen=True)
class Folder:
    """A folder that may be written to."""

    path: Path
    key: str

    @property
    def cache(self) -> Path:
        """Where simulator runs are kept."""
        return self.path / CACHE

    def write(self, name: str, text: str) -> Path:
        """Write a text file and return its path."""
        self.path.mkdir(parents=True, exist_ok=True)
        path = self.path / name
        write_whole(path, text)
        return path


def claim(path: Path, task: DiagnosisTask, files: Sequence[str], *, verb: str, force: bool) -> Folder:
    """Return the folder; raises BadInput, before anything is written, when it holds another case or measurement.

    `files`: files and folders that the verb would write; those of before are removed first, the cache is kept.
    """
    return claim_for(path, key_of(task), files, verb=verb, force=force)


def claim_for(path: Path, key: str, files: Sequence[str], *, verb: str, force: bool) -> Folder:
    """Return the folder for what `key` names; raises BadInput as `claim` does."""
    if path.exists() and not path.is_dir():
        raise BadInput.of("this is a file, give a folder to write into", file=str(path))
    there = sorted(name for name in files if (path / name).exists())
    if there and _marked(path).get(verb) != key and not force:
        raise BadInput.of(
            f"holds {', '.join(there)} of another case or measurement, choose another --output or overwrite with "
            "--force",
            file=str(path),
        )
    for name in there:
        _remove(path / name)
    path.mkdir(parents=True, exist_ok=True)
    marks = _marked(path) | {verb: key}
    write_whole(path / MARK, json.dumps(marks, indent=1) + "\n")
    return Folder(path, key)


def key_of(task: DiagnosisTask) -> str:
    """Return what tells one question from another: the case, the measured files, the candidate effects.

    The file that names the measured files is one of them: it holds the noise and the sizes of coupons.
    """
    found = hashlib.sha256(task.loaded.sha256.encode())
    for file in sorted(set(measured_files(task.measured))):
        found.update(Path(file).read_bytes())
    for item in task.setting.candidates:
        found.update(f"{item.card.id} {item.file}".encode())
    found.update(f"{task.fabric is None} {task.setting.seed}".encode())
    return found.hexdigest()


def measured_files(measured: Measurements) -> Iterator[str]:
    """Yield the file that describes the measurements, and those of all channels."""
    if measured.file:
        yield measured.file
    yield from (
        curve.file
        for curve in (
            *measured.punch_force,
            *measured.pressure_height,
            *measured.displacement_field,
            *measured.joint_moment,
            *measured.clamp_force,
            *measured.moment_curvature,
            *measured.cyclic_force,
        )
    )
    yield from {curve.diaphragm for curve in measured.pressure_height if curve.diaphragm}
    yield from (curve.file for curves in measured.tensile.values() for curve in curves)
    fields = (measured.free_edge, measured.strain_field, measured.clamp_line, measured.mark_slip, measured.wires)
    yield from (item.file for item in fields if item is not None)


def _remove(path: Path) -> None:
    """Remove a file, or a folder with all that is in it."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink()


def _marked(path: Path) -> dict[str, str]:
    try:
        found = json.loads((path / MARK).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {str(verb): str(key) for verb, key in found.items()} if isinstance(found, dict) else {}
