"""How the program stands hostile files, in figures: `python tests/hardening/figures.py`.

Every input is made from a seed and tried in a process of its own, forked from this one. A fork of a process whose
solver has started threads may wait for them for ever: this one imports, and solves nothing. The table is the one of
the validation page `hardening` of the manual.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


sys.path.insert(0, str(Path(__file__).parent))

import disks
import isolated
import kills
import mutate
import valid

import etextile as et
import etextile.studies.run.run
import viz.maps  # noqa: F401
from etextile.studies.run.outcome import open_run


CASES = Path(et.__file__).parents[1] / "loadcases"
COARSE = {
    "fabric.portion": "whole", "fabric.coarsening": 40, "motion.total": "20 mm", "motion.steps": 4,
    "contact.friction": 0.2,
}  # fmt: skip


@dataclass
class Figures:
    """What became of the inputs of one kind."""

    kind: str
    count: int = 0
    codes: Counter[int] = field(default_factory=Counter)
    troubles: Counter[str] = field(default_factory=Counter)
    slowest: float = 0.0
    largest: int = 0
    examples: list[str] = field(default_factory=list)

    def take(self, ended: isolated.Ended, what: str, *, lie: str = "") -> None:
        """Count one verb."""
        self.count += 1
        self.codes[ended.code] += 1
        self.slowest = max(self.slowest, ended.seconds)
        self.largest = max(self.largest, ended.peak)
        trouble = ended.trouble or ("lie" if lie else "")
        if VERBOSE[0]:
            print(f"{time.strftime('%H:%M:%S')} {what}: {ended.code} {trouble} {lie}", file=sys.stderr, flush=True)
        if trouble:
            self.troubles[trouble] += 1
            self.examples.append(f"{self.kind} {what}: {trouble} {lie}, exit {ended.code}, {ended.said.strip()[-600:]}")

    def row(self) -> str:
        """Return the row of the table."""
        codes = ", ".join(f"{code}: {count}" for code, count in sorted(self.codes.items()))
        names = ("traceback", "hang", "memory", "exit", "lie")
        troubles = " | ".join(str(self.troubles[name]) for name in names)
        size = f"{self.largest / 2**30:.2f} GiB"
        return f"| {self.kind} | {self.count} | {codes} | {troubles} | {self.slowest:.1f} s | {size} |"


HEAD = (
    "| inputs | verbs | exit codes | tracebacks | over 20 s | over 2 GiB | other exits | lies | slowest | largest |\n"
    "|---|---|---|---|---|---|---|---|---|---|"
)


VERBOSE = [False]
"""Whether every verb is told as it ends."""
PATIENCE = [float("inf")]
"""Minutes for the inputs of one kind; the last ones are left out when it is over, and the table has fewer."""
FIRST = [0]
"""Number of the first input: where another table of the same seed ended."""


def in_time(count: int) -> Iterator[int]:
    """Yield the numbers of inputs as long as there is patience."""
    over = time.monotonic() + 60.0 * PATIENCE[0]
    numbers = range(FIRST[0], FIRST[0] + count)
    yield from itertools.takewhile(lambda _: time.monotonic() < over, numbers)


def cases(folder: Path, count: int, seed: int) -> Figures:
    """Check mutated cases; those that are accepted are built too."""
    found, shipped = Figures("mutated cases"), mutate.shipped(CASES)
    for number in in_time(count):
        rng = np.random.default_rng((seed, 1, number))
        path = folder / "case.yaml"
        path.write_bytes(mutate.case(shipped[int(rng.integers(len(shipped)))], rng))
        found.take(isolated.verb(["check", str(path)], after=_builder(path)), str(number))
    return found


def _builder(path: Path) -> Callable[[], None]:
    """Return what builds the model of a case that was found good; what it refuses is told as `run` tells it."""

    def build() -> None:
        with contextlib.suppress(et.BadInput):
            et.build(et.load(path))

    return build


def folders(folder: Path, count: int, seed: int) -> Figures:
    """Read mutated folders of measurements."""
    found = Figures("measured folders")
    sources = [item.parent for item in sorted((CASES / "data").rglob("measured.yaml"))]
    for number in in_time(count):
        rng = np.random.default_rng((seed, 2, number))
        target = folder / "measured"
        shutil.rmtree(target, ignore_errors=True)
        source = sources[int(rng.integers(len(sources)))]
        mutate.folder(source, target, rng)
        if rng.random() < 0.5:
            tables = sorted(target.rglob("*.csv"))
            arguments = ["inspect", str(tables[int(rng.integers(len(tables)))])] if tables else ["inspect", str(target)]
        else:
            arguments = ["identify", str(target), "-o", str(folder / "fabric.yaml"), "--force"]
        found.take(isolated.verb(arguments), f"{number} {source.name} {arguments[0]}")
    return found


def meshes(folder: Path, count: int, seed: int) -> Figures:
    """Check and build a punch with mutated meshes as its body."""
    found = Figures("meshes")
    for number in in_time(count):
        rng = np.random.default_rng((seed, 3, number))
        suffix, content = mutate.mesh(rng)
        (folder / f"body.{suffix}").write_bytes(content)
        path = folder / "mesh.yaml"
        path.write_text(
            "schema_version: 1\nextends: punch\nfabric: {portion: whole, coarsening: 40}\n"
            f"body: {{type: mesh, file: body.{suffix}}}\n"
        )
        found.take(isolated.verb(["check", str(path)], after=_builder(path)), f"{number} {suffix}")
    return found


def sound_result(folder: Path) -> Path:
    """Run a small case, from which result files are damaged."""
    out = folder / "sound"
    start = "import sys; from etextile.app.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", start, "run", "punch", "-o", str(out), "--quiet", *_options()]
    code = subprocess.run(command, check=False, stderr=subprocess.DEVNULL).returncode
    if code not in (0, 4):  # a lattice as coarse as this one passes a limit
        raise RuntimeError(f"the sound run ended with {code}")
    return out


def _options() -> list[str]:
    return [part for key, value in COARSE.items() for part in ("--set", f"{key}={value}")]


def results(folder: Path, count: int, seed: int) -> Figures:
    """Map, report and resume damaged result files; what is accepted must hold the numbers that were written."""
    found, sound = Figures("result files"), sound_result(folder)
    before = _numbers(sound)
    for number in in_time(count):
        rng = np.random.default_rng((seed, 4, number))
        out = folder / "damaged"
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(sound, out)
        how = mutate.result_file(out / "results.vtkhdf", rng)
        ended = isolated.verb(["map", str(out)])
        found.take(ended, f"{number} map {how}", lie=_lie(out, before) if ended.code == 0 else "")
        found.take(isolated.verb(["report", str(out)]), f"{number} report {how}")
        if number % 4 == 0:
            resumed = isolated.verb(["run", "punch", "-o", str(out), "--resume", *_options()])
            found.take(resumed, f"{number} resume {how}")
    return found


def _numbers(out: Path) -> dict[str, np.ndarray]:
    run = open_run(out)
    return {"strain": run.array("strain"), "force": np.asarray(run.results.curves.punch_force_N)}


def _lie(out: Path, before: dict[str, np.ndarray]) -> str:
    try:
        now = _numbers(out)
    except et.EtextileError:
        return ""
    return "" if all(np.array_equal(now[name], before[name]) for name in before) else "lie"


def reports(folder: Path, count: int, seed: int) -> Figures:
    """Print damaged reports."""
    found, sound = Figures("report files"), sound_result(folder)
    for number in in_time(count):
        rng = np.random.default_rng((seed, 5, number))
        out = folder / "damaged"
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(sound, out)
        path = out / "report.json"
        path.write_bytes(mutate.damaged_json(path.read_bytes(), rng))
        found.take(isolated.verb(["report", str(out)]), str(number))
    return found


def killed_runs(folder: Path, count: int, seed: int) -> Figures:
    """Kill runs, and let them go on."""
    found = Figures("kills of run")
    found.kind += _told(kills.runs(folder, in_time(count), seed, found.take))
    return found


def killed_ensembles(folder: Path, count: int, seed: int) -> Figures:
    """Kill ensembles and their workers."""
    found = Figures("kills of ensemble")
    found.kind += _told(kills.studies(kills.ENSEMBLE, folder, in_time(count), seed, found.take))
    return found


def killed_diagnoses(folder: Path, count: int, seed: int) -> Figures:
    """Kill diagnoses and their workers."""
    found = Figures("kills of diagnose")
    found.kind += _told(kills.studies(kills.DIAGNOSE, folder, in_time(count), seed, found.take))
    return found


def full_disks(folder: Path, count: int, seed: int) -> Figures:
    """Write where there is no room or no right to."""
    found = Figures("full disks and rights")
    found.kind += f" ({disks.disks(folder, found.take)} situations)"
    return found


def valid_cases(folder: Path, count: int, seed: int) -> Figures:
    """Run random valid cases."""
    found = Figures("random valid cases")
    found.kind += _told(valid.cases(folder, in_time(count), seed, found.take))
    return found


def _told(counts: Counter[str]) -> str:
    return f" ({', '.join(f'{count} {what}' for what, count in sorted(counts.items()))})"


KINDS = {
    "cases": (cases, 1000), "folders": (folders, 300), "meshes": (meshes, 150), "results": (results, 100),
    "reports": (reports, 400), "killed-runs": (killed_runs, 70), "killed-ensembles": (killed_ensembles, 18),
    "killed-diagnoses": (killed_diagnoses, 12), "disks": (full_disks, 1), "valid": (valid_cases, 200),
}  # fmt: skip


def measured(kinds: dict[str, int], seed: int) -> Iterator[Figures]:
    """Yield the figures of each kind."""
    with tempfile.TemporaryDirectory() as name:
        for kind, count in kinds.items():
            folder = Path(name) / kind
            folder.mkdir()
            yield KINDS[kind][0](folder, count, seed)


def main() -> int:
    """Print the table, and what should not have happened."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first input of each kind")
    parser.add_argument("--share", type=float, default=1.0, help="share of the full numbers")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="for each kind at most")
    parser.add_argument("-v", "--verbose", action="store_true", help="tell every verb as it ends")
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    options = parser.parse_args()
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))
    PATIENCE[0] = options.minutes
    FIRST[0] = options.first
    VERBOSE[0] = options.verbose
    if unknown := [kind for kind in options.kinds if kind not in KINDS]:
        parser.error(f"no such kind (got {', '.join(unknown)}), known are {', '.join(KINDS)}")
    kinds = {kind: max(1, round(options.share * KINDS[kind][1])) for kind in options.kinds}
    print(HEAD)
    examples = []
    for found in measured(kinds, options.seed):
        print(found.row(), flush=True)
        examples += found.examples
    print("\n".join(examples), file=sys.stderr)
    return bool(examples)


if __name__ == "__main__":
    sys.exit(main())
