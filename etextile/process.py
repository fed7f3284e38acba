"""Worker processes on this machine: independent tasks, one thread each, that outlive a worker but not their parent.

They talk through pipes of the operating system, and on Linux a socket in a folder that only this user can enter, so
nobody else can reach them. A worker that dies loses nothing: what was running is run again, one task at a time, so that
a task that kills its worker is found out.

On Linux workers are forks of a server that has imported what tasks need (`WARM`) but never solved anything: a fork of a
process with threads, such as those of a solver, may wait for ever for a lock that nobody holds. Elsewhere each worker
begins with an interpreter of its own and imports everything itself.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from etextile import foreign_code
from etextile.environment import look_for_garbage_seldom, single_threaded, take_over
from etextile.errors import EtextileError


TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

RETRIES = 2
"""How often a task that raised an error is tried again."""
DEATHS = 3
"""How many workers may die under a task that runs alone before it counts as failed."""
BREAKS = 8
"""How many times in a row workers may die before anything ends: beyond it they cannot run here at all."""
MOST_WORKERS = 60
"""One system call on Windows waits for at most 63 processes."""
WARM = "etextile.studies.warm"
"""The module that the server of workers imports before it forks any."""
PRIVATE = (3, 11, 1)
"""First Python whose server listens in a folder of the user and not where everybody may call (CVE-2022-42919)."""


@dataclass(frozen=True)
class TaskOutcome(Generic[TaskT, ResultT]):
    """A task and what came of it: its result, or the error that remained after all retries."""

    task: TaskT
    result: ResultT | None
    error: BaseException | None = None


def begin_server() -> bool:
    """Let the server of workers start to import, if none does yet; return whether there is one on this machine.

    Whoever knows that workers will be needed says so early: the server gets ready while this process goes on.
    """
    if sys.platform != "linux" or sys.version_info < PRIVATE:
        return False
    from multiprocessing import forkserver

    forkserver.set_forkserver_preload([WARM])
    with single_threaded(), suppress(OSError):  # no temporary folder, or one whose name is too long for a socket
        forkserver.ensure_running()
        return True
    return False


class LocalPool:
    """Worker processes that start with the first tasks and are replaced when they die; use as a context manager."""

    def __init__(self, jobs: int | None = None) -> None:
        self.jobs = min(jobs or os.cpu_count() or 1, MOST_WORKERS)
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> LocalPool:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        self.close(now=kind is not None)

    def close(self, *, now: bool = False) -> None:
        """Stop the workers; `now` ends them in the middle of their tasks.

        One that ends while it hands over a result leaves half a message in the pipe, for whose rest the pool would wait
        for ever as long as we hold the pipe's other end: so that is closed with them.
        """
        pool, self._pool = self._pool, None
        if pool is None:
            return
        running = list((getattr(pool, "_processes", None) or {}).values())
        sending = getattr(getattr(pool, "_result_queue", None), "_writer", None)
        pool.shutdown(wait=not now, cancel_futures=True)
        if not now:
            return
        for process in running:
            process.terminate()
        if sending is not None:
            sending.close()

    def run(
        self, function: Callable[[TaskT], ResultT], tasks: Sequence[TaskT]
    ) -> Iterator[TaskOutcome[TaskT, ResultT]]:
        """Yield the outcomes of `function` on all tasks as they come; both have to be picklable.

        Raises EtextileError when workers die again and again before anything ends.
        """
        queue = _Queue(len(tasks))
        running: dict[Future[ResultT], int] = {}
        while running or queue:
            broken = False
            for number in queue.take(self.jobs + 1 - len(running), idle=not running):
                try:
                    running[self._submit(function, tasks[number])] = number
                except (BrokenProcessPool, EOFError, ConnectionError):  # a worker, or the server that starts them, died
                    queue.put_back(number)
                    broken = True
                    break
            ended, _ = wait(running, return_when=FIRST_COMPLETED)
            lost: list[int] = []
            for future in ended:
                number, error = running.pop(future), future.exception()
                if isinstance(error, BrokenProcessPool):
                    lost.append(number)
                elif error is None or isinstance(error, EtextileError) or queue.is_final(number):
                    queue.breaks = 0
                    yield TaskOutcome(tasks[number], None if error else future.result(), error)
                else:
                    queue.put_back(number)
            if lost or broken:
                lost += self._give_up(running)
                yield from (TaskOutcome(tasks[n], None, queue.death()) for n in queue.suspect(lost))

    def _submit(self, function: Callable[[TaskT], ResultT], task: TaskT) -> Future[ResultT]:
        with single_threaded():
            if self._pool is None:
                context = multiprocessing.get_context("forkserver" if begin_server() else "spawn")
                given = (foreign_code.allowed(), dict(os.environ))
                self._pool = ProcessPoolExecutor(self.jobs, mp_context=context, initializer=_begin, initargs=given)
            return self._pool.submit(function, task)

    def _give_up(self, running: dict[Future[Any], int]) -> list[int]:
        """Leave a pool that broke; return the tasks that were in it."""
        lost = list(running.values())
        running.clear()
        self.close(now=True)
        return lost


class _Queue:
    """Which task comes next: suspects first and alone, then the others in their order."""

    def __init__(self, count: int) -> None:
        self._waiting = deque(range(count))
        self._suspects: deque[int] = deque()
        self._alone: int | None = None
        self._errors: Counter[int] = Counter()
        self._deaths: Counter[int] = Counter()
        self.breaks = 0

    def __bool__(self) -> bool:
        return bool(self._waiting or self._suspects)

    def take(self, room: int, *, idle: bool) -> Iterator[int]:
        """Yield the next tasks, at most `room`; a suspect only when nothing else runs (`idle`)."""
        if self._suspects:
            if idle:
                self._alone = self._suspects.popleft()
                yield self._alone
            return
        if idle or self._alone is None:
            self._alone = None
            for _ in range(min(room, len(self._waiting))):
                yield self._waiting.popleft()

    def put_back(self, number: int) -> None:
        """Take a task again that did not end."""
        self._waiting.appendleft(number)

    def is_final(self, number: int) -> bool:
        """Note an error of a task; tell whether it was the last try."""
        self._errors[number] += 1
        return self._errors[number] > RETRIES

    def suspect(self, lost: Sequence[int]) -> list[int]:
        """Note tasks under which a worker died; return those that are given up."""
        self.breaks += 1
        if self.breaks > BREAKS:
            raise self.death()
        if list(lost) == [self._alone]:
            self._deaths[lost[0]] += 1
            if self._deaths[lost[0]] >= DEATHS:
                return [lost[0]]
        self._suspects.extendleft(reversed(sorted(lost)))
        return []

    @staticmethod
    def death() -> EtextileError:
        """Return the error of a task whose worker died each time."""
        return EtextileError("the worker process died each time it was run (out of memory?), try fewer --jobs")


def _begin(code: frozenset[str], environment: dict[str, str]) -> None:
    """Make a worker ready: it may run the same code, Ctrl-C is its parent's matter, it ends when its parent does.

    Its environment is that of its parent when it began, not that of the server, which may have begun long before.
    """
    foreign_code.allow(code)
    take_over(environment)
    look_for_garbage_seldom()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Wait for the parent's end, also by a kill, and end this process: nobody is left who would take its results."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
