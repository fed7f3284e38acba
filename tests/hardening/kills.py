"""Runs, ensembles and diagnoses that are killed at random moments: what they leave is whole, true, and goes on.

Killed is the process itself, while it solves, writes or draws, or one of its workers. After every kill each file in the
folder is read, `report` and `map` are asked, and the same command goes on: it must end as the run that nobody killed.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import isolated
import numpy as np
from PIL import Image
from ruamel.yaml import YAML

from etextile.files import LOCK, OWNER, PART
from etextile.kept import recall
from etextile.results.layout import FILE_NAME
from etextile.results.reader import open_results
from etextile.studies.run.rebuilt import REMARK
from wires.seal import SEAL


Random = np.random.Generator
START = "import sys; from etextile.app.cli import main; sys.exit(main())"
SAME = 1e-6
"""How far numbers may lie from those of the run that nobody killed, relative."""
OF_THE_FILE = frozenset({"notes", SEAL})
"""Keys of a report that tell of its writing."""
TIMES = frozenset({"wall_s", "solve_s", "seconds", "simulations", "seal", "results_sha256"})
"""Keys that say how a result was come by."""
SMALL = (
    "fabric.coarsening=40", "motion.total=20 mm", "motion.steps=8", "contact.friction=0.2",
    "outputs.maps=[failure, warp_strain]",
)  # fmt: skip
OTHER = (*SMALL[:3], "contact.friction=0", *SMALL[4:])
FEW = ("fabric.coarsening=40", "motion.total=20 mm", "motion.steps=4")
ENDS_WITHIN_S = 15.0
"""Seconds after which a worker must have noticed that its parent was killed."""


def settings(values: Iterable[str]) -> list[str]:
    """Return options of the command line."""
    return [part for value in values for part in ("--set", value)]


@dataclass
class Sound:
    """A run that nobody killed: folder, exit code, seconds, and when its parts began (seconds after the start)."""

    folder: Path
    code: int
    seconds: float
    begun: dict[str, float] = field(default_factory=dict)


def begin(arguments: list[str], log: Path) -> int:
    """Start a verb in a fork of this process, a session of its own, and return its number."""
    with log.open("wb") as file:
        process = os.fork()
        if process == 0:
            os.setsid()
            isolated.child(file.fileno(), arguments)
    return process


def begin_anew(arguments: list[str], log: Path) -> subprocess.Popen[bytes]:
    """Start a verb that has workers: they begin by what their parent began with, which must be small."""
    with log.open("wb") as file:
        return subprocess.Popen(
            [sys.executable, "-c", START, *arguments], stdout=file, stderr=file, stdin=subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip


def ended(process: int) -> int | None:
    """Return the exit code of a fork that has ended, None as long as it runs."""
    done, status = os.waitpid(process, os.WNOHANG)
    return os.waitstatus_to_exitcode(status) if done else None


def session_of(leader: int) -> list[int]:
    """Return the processes of a session that live, its leader left out."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            words = (place / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(words[3]) == leader and words[0] != "Z" and int(place.name) != leader:
            found.append(int(place.name))
    return found


def sound_run(out: Path, values: tuple[str, ...]) -> Sound:
    """Run the case once and note when solving, writing and drawing began."""
    begun, start = dict[str, float](), time.monotonic()
    process = begin(["run", "punch", "-o", str(out), *settings(values)], out.with_suffix(".log"))
    while (code := ended(process)) is None:
        for phase, there in PHASES.items():
            if phase not in begun and there(out):
                begun[phase] = time.monotonic() - start
        time.sleep(0.002)
    if code not in (0, 4):  # a lattice as coarse as this one passes a limit
        raise RuntimeError(f"the sound run ended with {code}: {out.with_suffix('.log').read_text()}")
    return Sound(out, code, time.monotonic() - start, begun)


PHASES: dict[str, Callable[[Path], bool]] = {
    "solving": lambda out: (out / FILE_NAME).is_file() and not (out / "report.json").is_file(),
    "writing": lambda out: (out / "report.json").is_file(),
    "drawing": lambda out: any((out / "maps").glob("*.png")),
}
"""By what a phase of a run is known to have begun."""


def kill_run(arguments: list[str], out: Path, sound: Sound, rng: Random) -> str:
    """Start a run and kill it at random; return in which phase, '' when it had ended before."""
    phase = ("solving", "solving", "writing", "drawing", "anywhere")[int(rng.integers(5))]
    process = begin(arguments, out.parent / "killed.log")
    if phase == "anywhere":
        time.sleep(float(rng.uniform(0.0, sound.seconds)))
    else:
        last = {"solving": sound.begun["writing"], "writing": sound.begun["drawing"], "drawing": sound.seconds}[phase]
        while ended_early(process) is None and not PHASES[phase](out):
            time.sleep(0.001)
        time.sleep(float(rng.uniform(0.0, last - sound.begun[phase])))
    if ended_early(process) is not None:
        os.waitpid(process, 0)
        return ""
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    return next((name for name in ("drawing", "writing", "solving") if PHASES[name](out)), "starting")


def ended_early(process: int) -> bool | None:
    """Tell whether a fork has ended, and leave it to be waited for."""
    return True if os.waitid(os.P_PID, process, os.WEXITED | os.WNOHANG | os.WNOWAIT) else None


def broken_files(out: Path) -> str:
    """Read every file of a folder and say which is not whole."""
    for path in sorted(out.rglob("*")):
        if not path.is_file() or path.name in (LOCK, OWNER) or PART.fullmatch(path.name):
            continue
        try:
            whole = READERS.get(path.suffix, lambda _: True)(path)
        except Exception as error:
            return f"{path.name} is broken: {type(error).__name__}: {error}"
        if not whole:
            return f"{path.name} is not whole"
    return ""


def _picture(path: Path) -> bool:
    with Image.open(path) as picture:
        picture.load()
    return True


READERS: dict[str, Callable[[Path], Any]] = {
    ".json": lambda path: json.loads(path.read_text(encoding="utf-8")),
    ".html": lambda path: path.read_text(encoding="utf-8").rstrip().endswith("</html>"),
    ".csv": lambda path: path.read_text(encoding="utf-8").endswith("\n"),
    ".yaml": lambda path: YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8")) is not None,
    ".npz": lambda path: recall(path, ()) is not None,
    ".png": _picture,
    ".vtkhdf": lambda path: open_results(path).steps >= 0,
}
"""What reads a file of a kind, by its suffix, and tells whether it is whole."""


def leftovers(out: Path) -> str:
    """Say which half written files lie in a folder whose run has ended."""
    found = [path.name for path in out.rglob("*") if PART.fullmatch(path.name)]
    return f"left behind: {found}" if found else ""


def different(one: Any, two: Any, place: str = "") -> str:
    """Say where nested data differ by more than `SAME`, '' where they do not; how long anything took may differ."""
    if isinstance(one, dict) and isinstance(two, dict):
        keys = (set(one) | set(two)) - TIMES
        return next(filter(None, (different(one.get(key), two.get(key), f"{place}.{key}") for key in sorted(keys))), "")
    if isinstance(one, list) and isinstance(two, list) and len(one) == len(two):
        pairs = enumerate(zip(one, two, strict=True))
        return next(filter(None, (different(a, b, f"{place}[{at}]") for at, (a, b) in pairs)), "")
    if isinstance(one, float | int) and isinstance(two, float | int):
        return "" if math.isclose(one, two, rel_tol=SAME, abs_tol=1e-9) else f"{place}: {one} is not {two}"
    return "" if one == two else f"{place}: {str(one)[:60]} is not {str(two)[:60]}"


def other_results(out: Path, sounds: Iterable[Sound]) -> str:
    """Say where the steps in a result file are not those of the run that nobody killed."""
    if not (out / FILE_NAME).is_file():
        return ""
    results = open_results(out)
    for sound in sounds:
        whole = open_results(sound.folder)
        if whole.case.sha256 != results.case.sha256:
            continue
        for step in range(results.steps):
            here, there = results.array("strain", step), whole.array("strain", step)
            if not np.allclose(here, there, rtol=SAME, atol=1e-12):
                return f"strain of step {step} is another"
        return ""
    return "the results are of no case that was run"


def report_lies(out: Path, said: str, sounds: Iterable[Sound]) -> str:
    """Say whether a report that was printed is not that of the results beside it.

    One that was made again, the run being killed before it wrote its own, says so in its notes and has no seal.
    """
    results = open_results(out)
    if not results.completed:
        return "a report of a run that did not end"
    for sound in sounds:
        if open_results(sound.folder).case.sha256 == results.case.sha256:
            told, whole = json.loads(said), json.loads((sound.folder / "report.json").read_text(encoding="utf-8"))
            if f"this report was {REMARK}" in told["notes"]:
                told, whole = ({key: data[key] for key in set(data) - OF_THE_FILE} for data in (told, whole))
            return different(told, whole)
    return "a report of no case that was run"


def map_lies(out: Path, said: str) -> str:
    """Say whether maps of a run that did not end are shown as if it had."""
    return "" if open_results(out).completed or "did not end" in said else "maps of a run that did not end"


Take = Callable[..., None]
"""Counts how a verb ended: `take(ended, what, lie=...)`."""


def runs(folder: Path, numbers: Iterator[int], seed: int, take: Take) -> Counter[str]:
    """Kill runs up to three times each until `numbers` are used up; return how many kills fell into which phase."""
    whole = sound_run(folder / "whole", SMALL)
    other = sound_run(folder / "other", OTHER)
    kills, out, begun = Counter[str](), folder / "killed", False
    for number in numbers:
        rng = np.random.default_rng((seed, 6, number))
        if not begun:
            shutil.rmtree(out, ignore_errors=True)
            if rng.random() < 0.5:
                shutil.copytree(other.folder, out)
        phase = kill_run(_going_on(out, whole), out, whole, rng)
        kills[phase or "ended before"] += 1
        _ask(out, (whole, other), f"kill {number} {phase}", take, with_map=number % 3 == 0)
        begun = bool(phase) and rng.random() < 0.5
        if not begun:
            _end(out, whole, f"kill {number} {phase} resume", take)
    if begun:
        _end(out, whole, "the last kill, resume", take)
    return kills


def _end(out: Path, whole: Sound, what: str, take: Take) -> None:
    """Let a run go on to its end and compare it with the one that nobody killed."""
    done = isolated.verb(_going_on(out, whole))
    lie = f"exit {done.code} instead of {whole.code}" if done.code != whole.code else ""
    lie = lie or broken_files(out) or leftovers(out) or other_results(out, [whole])
    take(done, what, lie=lie or report_lies(out, (out / "report.json").read_text(encoding="utf-8"), [whole]))


def _going_on(out: Path, sound: Sound) -> list[str]:
    """Return the command that goes on with what lies in a folder, or begins anew over another case."""
    more = []
    if (out / FILE_NAME).is_file():
        own = open_results(out).case.sha256 == open_results(sound.folder).case.sha256
        more = ["--resume"] if own else ["--force"]
    return ["run", "punch", "-o", str(out), *settings(SMALL), *more]


def _ask(out: Path, sounds: tuple[Sound, ...], what: str, take: Take, *, with_map: bool) -> None:
    """Read all that a killed run left, and ask `report` and `map`."""
    if not out.is_dir():
        return
    lie = broken_files(out) or other_results(out, sounds)
    done = isolated.verb(["report", str(out), "--format", "json"])
    take(done, f"{what} report", lie=lie or (report_lies(out, done.printed, sounds) if done.code == 0 else ""))
    if with_map and (out / FILE_NAME).is_file():
        done = isolated.verb(["map", str(out), "-o", str(out.parent / "maps"), "--field", "warp_strain"])
        take(done, f"{what} map", lie=map_lies(out, done.said) if done.code == 0 else "")


@dataclass(frozen=True)
class Study:
    """A verb with workers: its arguments without the folder, the file that holds what it found."""

    name: str
    arguments: tuple[str, ...]
    result: str


ENSEMBLE = Study(
    "ensemble", ("ensemble", "punch", "-n", "4", "--jobs", "2", "--quiet", *settings(FEW)), "ensemble.json"
)
DIAGNOSE = Study(
    "diagnose",
    (
        "diagnose", "punch", "--measured", "hidden_clamp", "--among", "clamp_slip", "--jobs", "2", "--quiet", "--set",
        "fabric.coarsening=39",
    ),
    "diagnosis.json",
)  # fmt: skip


def studies(study: Study, folder: Path, numbers: Iterator[int], seed: int, take: Take) -> Counter[str]:
    """Kill a study or a worker of it at random moments, let it go on, and compare what it finds at last."""
    out, log, start = folder / "whole", folder / "whole.log", time.monotonic()
    code = begin_anew([*study.arguments, "-o", str(out)], log).wait()
    if code not in (0, 4):
        raise RuntimeError(f"the sound {study.name} ended with {code}: {log.read_text()}")
    sound = Sound(out, code, time.monotonic() - start)
    kills, out = Counter[str](), folder / "killed"
    process: subprocess.Popen[bytes] | None = None
    for number in numbers:
        rng = np.random.default_rng((seed, 7, number))
        if process is None:
            shutil.rmtree(out, ignore_errors=True)
            process = begin_anew([*study.arguments, "-o", str(out)], log)
        time.sleep(float(rng.uniform(0.0, 0.9 * sound.seconds)))
        what = _kill(process, rng)
        kills[what] += 1
        if what == "main":
            lie = _outlived(process.pid) or broken_files(out)
            take(isolated.Ended(0, 0.0, 0, ""), f"{study.name} {number} main", lie=lie)
            process = begin_anew([*study.arguments, "-o", str(out)], log)
        if what != "main" or rng.random() < 0.3:
            _conclude(study, process, sound, f"{study.name} {number}", take)
            process = None
    if process is not None:
        _conclude(study, process, sound, f"{study.name}, the last kill", take)
    return kills


def _kill(process: subprocess.Popen[bytes], rng: Random) -> str:
    """Kill a process or, with equal chance where there are any, one of its workers; return which."""
    workers = [number for number in session_of(process.pid) if not _is_tracker(number)]
    if process.poll() is not None:
        return "ended before"
    if workers and rng.random() < 0.5:
        os.kill(workers[int(rng.integers(len(workers)))], signal.SIGKILL)
        return "worker"
    process.kill()
    process.wait()
    return "main"


def _is_tracker(number: int) -> bool:
    """Tell whether a process is Python's own tracker of semaphores, which complains by itself when it was killed."""
    try:
        return b"resource_tracker" in Path(f"/proc/{number}/cmdline").read_bytes()
    except OSError:
        return True


def _conclude(study: Study, process: subprocess.Popen[bytes], sound: Sound, what: str, take: Take) -> None:
    """Wait for a study and compare what it found with what the one found that nobody killed."""
    code, out = process.wait(), sound.folder.with_name("killed")
    said = sound.folder.with_suffix(".log").read_text(encoding="utf-8", errors="replace")
    lie = f"exit {code} instead of {sound.code}" if code != sound.code else broken_files(out) or leftovers(out)
    if not lie:
        here, there = (_without_place(place / study.result) for place in (out, sound.folder))
        lie = different(here, there)
    take(isolated.Ended(code, 0.0, 0, said), what, lie=lie)


def _without_place(path: Path) -> Any:
    """Return what a file holds, its folder by another name."""
    return json.loads(path.read_text(encoding="utf-8").replace(str(path.parent), "FOLDER"))


def _outlived(leader: int) -> str:
    """Say which workers live longer than their killed parent."""
    end = time.monotonic() + ENDS_WITHIN_S
    while left := session_of(leader):
        if time.monotonic() > end:
            for process in left:
                os.kill(process, signal.SIGKILL)
            return f"{len(left)} workers outlived their parent"
        time.sleep(0.1)
    return ""
