"""What this process and its children take of the machine: environment variables, written here and nowhere else.

Libraries read them when they are loaded, so threads are to be set before numpy is imported.
"""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress


THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
"""What linear algebra and compiled kernels take their number of threads from."""


GARBAGE = (50_000, 20, 20)
"""New objects after which they, older ones and all are looked through for garbage that hangs together."""


def look_for_garbage_seldom() -> None:
    """Let a process of ours look for garbage after 50 000 new objects instead of 700.

    Libraries bring some 400 000 objects that stay: to go through them again and again takes 7 % of a short run.
    """
    gc.set_threshold(*GARBAGE)


def cores() -> int:
    """Return how many processes the machine can run at the same time."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def memory_bytes() -> float:
    """Return how much memory this process may have: the machine's, or less where a limit is set."""
    found = [float("inf")]
    with suppress(ValueError, OSError, AttributeError):
        found.append(float(os.sysconf("SC_PAGE_SIZE")) * float(os.sysconf("SC_PHYS_PAGES")))
    with suppress(ImportError, ValueError, OSError):
        import resource

        soft, _ = resource.getrlimit(resource.RLIMIT_AS)
        found += [float(soft)] if soft != resource.RLIM_INFINITY else []
    for path in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        with suppress(OSError, ValueError), open(path, encoding="ascii") as file:  # noqa: PTH123
            found.append(float(file.read()))
    return min(found)


def set_variable(name: str, value: str) -> None:
    """Set an environment variable."""
    os.environ[name] = value


def take_over(variables: Mapping[str, str]) -> None:
    """Make these the environment variables of the process, and no others: those of its parent."""
    os.environ.clear()
    os.environ.update(variables)


def use_threads(count: int) -> None:
    """Let linear algebra and compiled kernels use at most `count` threads; to be said before numpy is loaded."""
    os.environ.update(dict.fromkeys(THREADS, str(count)))


def one_thread_each() -> None:
    """Let linear algebra use one thread per process, unless the user has set another number.

    Matrices of a diagnosis have some hundred rows: threads that wait for each other cost more than they bring, ten
    times as much on a machine that is busy. It has to be said before numpy is loaded.
    """
    for name in THREADS:
        if name != "NUMBA_NUM_THREADS":
            os.environ.setdefault(name, "1")


@contextmanager
def single_threaded() -> Iterator[None]:
    """Let processes that start now use one thread each: they share the cores among themselves."""
    with variables(dict.fromkeys(THREADS, "1")):
        yield


@contextmanager
def variables(wanted: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables for a while, and what was there before afterwards."""
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
