"""Disks that are full and places that may not be written: one message, nothing lost, and it goes on when there is room.

Small disks are file systems in memory, which only root can mount; without that right these situations are left out.
"""

from __future__ import annotations

import ctypes
import os
import resource
import shutil
import struct
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import isolated
from kills import ENSEMBLE, SMALL, Sound, Take, broken_files, leftovers, other_results, report_lies, settings, sound_run

from etextile.files import LOCK, OWNER


NOBODY = 65534
CAPABILITIES = 0x20080522
"""Version of the system call that sets what a process may do."""
RUN = ("run", "punch", "--quiet", *settings(SMALL))
MOST_LINES = 2
"""Lines that a refusal may take."""


@dataclass(frozen=True)
class Situation:
    """What stands in the way of a verb that writes into a folder.

    `disk`: size and further options of a file system in memory; `limit`: bytes of a file; `prepare` makes the place,
    `lift` takes what stands there away; `codes` are right while it does. `whole`: the run goes on to the same numbers.
    """

    name: str
    codes: tuple[int, ...]
    arguments: tuple[str, ...] = RUN
    disk: str = ""
    limit: int = 0
    nobody: bool = False
    prepare: Callable[[Path], None] = lambda _: None
    lift: Callable[[Path], None] = lambda _: None
    goes_on: bool = True
    place: str = "out"


def _folder(name: str) -> Callable[[Path], None]:
    return lambda out: (out / name).mkdir(parents=True)


def _file(name: str) -> Callable[[Path], None]:
    def make(out: Path) -> None:
        out.mkdir(exist_ok=True)
        (out / name).write_text("mine")

    return make


def _gone(name: str) -> Callable[[Path], None]:
    def take_away(out: Path) -> None:
        place = out / name
        shutil.rmtree(place) if place.is_dir() else place.unlink()

    return take_away


def _of_nobody(out: Path) -> None:
    out.mkdir(mode=0o755)
    os.chown(out, NOBODY, NOBODY)


def _below_nobody(out: Path) -> None:
    os.chown(out.parent, NOBODY, NOBODY)
    out.parent.chmod(0o755)


def _open_to_all(out: Path) -> None:
    out.chmod(0o777)


FULL, REFUSED = (1,), (2,)
SITUATIONS = (
    *(Situation(f"disk of {size}", FULL, disk=f"size={size}") for size in ("64k", "500k", "1600k")),
    Situation("disk of 5 MB", (0, 1, 4), disk="size=5m"),
    Situation("disk without inodes", FULL, disk="size=50m,nr_inodes=4"),
    Situation("disk of 64 kB, ensemble", FULL, ENSEMBLE.arguments, disk="size=64k"),
    Situation("disk of 200 kB, ensemble", FULL, ENSEMBLE.arguments, disk="size=200k"),
    Situation("disk of 64 kB, layout", FULL, ("layout", "elbow"), disk="size=16k", place="a.dxf", goes_on=False),
    Situation("disk of 20 kB, identify", FULL, ("identify", "hidden_clamp"), disk="size=4k", place="fabric.yaml"),
    *(Situation(f"files of {size} bytes", FULL, limit=size) for size in (10_000, 100_000, 700_000, 1_500_000)),
    Situation("read-only disk", REFUSED, disk="size=5m,ro"),
    Situation("read-only disk, ensemble", REFUSED, ENSEMBLE.arguments, disk="size=5m,ro"),
    Situation("a folder report.json", REFUSED, prepare=_folder("report.json"), lift=_gone("report.json")),
    Situation("a folder results.vtkhdf", REFUSED, prepare=_folder("results.vtkhdf"), lift=_gone("results.vtkhdf")),
    Situation("a file maps", REFUSED, prepare=_file("maps"), lift=_gone("maps")),
    Situation(
        "a folder ensemble.json", REFUSED, ENSEMBLE.arguments, prepare=_folder("ensemble.json"),
        lift=_gone("ensemble.json"),
    ),
    Situation("a file for a folder", REFUSED, prepare=lambda out: out.write_text("mine") and None, lift=Path.unlink),
    Situation("a folder of another user", REFUSED, nobody=True, prepare=_of_nobody, lift=_open_to_all),
    Situation("below a folder of another user", REFUSED, nobody=True, prepare=_below_nobody,
              lift=lambda out: out.parent.chmod(0o777)),
)  # fmt: skip


def disks(folder: Path, take: Take, *, only: str = "") -> int:
    """Try the situations whose name has a word in it; return how many there were."""
    whole = sound_run(folder / "whole", SMALL)
    folder.chmod(0o755)
    tried = 0
    for situation in (item for item in SITUATIONS if only in item.name):
        place = folder / "place"
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        with _mounted(place, situation.disk) as there:
            if there:
                tried += 1
                _try(situation, place, whole, take)
    return tried


def _try(situation: Situation, place: Path, whole: Sound, take: Take) -> None:
    """Run a verb where it cannot write, look at what it left, lift what stood in the way and let it go on."""
    out = place / situation.place
    situation.prepare(out)
    done = isolated.verb([*situation.arguments, "-o", str(out)], before=lambda: _restrict(situation))
    lie = "" if done.code in situation.codes else f"exit {done.code} is not one of {situation.codes}"
    if not lie and done.code in (1, 2) and len(done.said.strip().splitlines()) > MOST_LINES:
        lie = "more than one message"
    lie = lie or (broken_files(out) if out.is_dir() and done.code != 2 else "")
    if not lie and done.code == 2 and not situation.disk:
        new = {path.name for path in out.glob("*")} - {LOCK, OWNER, "maps", "report.json", "results.vtkhdf"}
        lie = f"a refusal left {new}" if situation.arguments is RUN and new else ""
    take(
        isolated.Ended(0 if done.code == 1 else done.code, done.seconds, done.peak, done.said), situation.name, lie=lie
    )
    if situation.goes_on:
        _go_on(situation, out, whole, take)


def _go_on(situation: Situation, out: Path, whole: Sound, take: Take) -> None:
    """Lift what stood in the way and repeat the command; a run must come to the numbers of the sound one."""
    situation.lift(out)
    if situation.disk:
        options = ",".join(part for part in situation.disk.split(",") if part.startswith("nr_inodes"))
        more = "nr_inodes=1000" if options else "size=100m"
        subprocess.run(["mount", "-o", f"remount,rw,size=100m,{more}", str(out.parent)], check=True)
    started = (out / "results.vtkhdf").is_file()
    more = ["--resume"] if started else []
    nobody = _leave_rights if situation.nobody else None
    done = isolated.verb([*situation.arguments, "-o", str(out), *more], before=nobody)
    lie = leftovers(out) if out.is_dir() else ""
    if situation.arguments is RUN and not lie:
        lie = f"exit {done.code} instead of {whole.code}" if done.code != whole.code else broken_files(out)
        lie = lie or other_results(out, [whole])
        lie = lie or report_lies(out, (out / "report.json").read_text(encoding="utf-8"), [whole])
    take(done, f"{situation.name}, going on", lie=lie)


def _restrict(situation: Situation) -> None:
    if situation.limit:
        resource.setrlimit(resource.RLIMIT_FSIZE, (situation.limit, resource.RLIM_INFINITY))
    if situation.nobody:
        _leave_rights()


def _leave_rights() -> None:
    """Give up all that root may do beyond an ordinary user, but not its own files: the interpreter may be one."""
    header = struct.pack("Ii", CAPABILITIES, 0)
    if ctypes.CDLL(None, use_errno=True).capset(header, bytes(24)):
        raise OSError(ctypes.get_errno(), "capset")


@contextmanager
def _mounted(place: Path, options: str) -> Iterator[bool]:
    """Mount a file system in memory with these options, if any; yield False where that is not allowed."""
    if not options:
        yield os.geteuid() == 0
        return
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", str(place)], check=False, capture_output=True)
    if done.returncode:
        yield False
        return
    try:
        yield True
    finally:
        subprocess.run(["umount", str(place)], check=True)
