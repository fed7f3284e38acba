"""Independent tasks on dask.distributed: worker processes on this machine, or a cluster that is already there.

Tasks are named, so that results do not depend on how many workers there are or in which order they finish. A worker
that dies loses nothing: its task goes to another one. Workers compute on one thread each.
"""

# mypy: disallow-untyped-calls=False

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from etextile.errors import BadInput


if TYPE_CHECKING:
    from distributed import Client

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

CONNECT_S = 10
"""Seconds that a scheduler may take to answer, and that its first worker may take to come."""
RETRIES = 2
"""How often a task that raised an error is tried again."""
DEATHS = 5
"""How many workers may die under a task before it counts as failed."""


DEAF = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
"""Run by local workers: Ctrl-C on the terminal reaches them too, but ending them is up to their cluster."""


@dataclass(frozen=True)
class Outcome(Generic[TaskT, ResultT]):
    """A task and what came of it: its result, or the error that remained after all retries."""

    task: TaskT
    result: ResultT | None
    error: BaseException | None = None


@contextmanager
def workers(*, jobs: int | None = None, scheduler: str | None = None) -> Iterator[Client]:
    """Yield a client of `jobs` new local worker processes (one per core by default), or of a scheduler's address.

    Raises BadInput when no scheduler answers there or it has no workers.
    """
    import dask
    from distributed import Client, LocalCluster

    quiet = {
        "distributed.scheduler.worker-ttl": None,
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.admin.tick.limit": "1h",
        "distributed.worker.preload": [DEAF] if scheduler is None else [],
    }
    with dask.config.set(quiet):
        if scheduler is not None:
            with _connected(scheduler) as client:
                yield client
            return
        with (
            LocalCluster(
                n_workers=jobs or dask.system.CPU_COUNT,
                threads_per_worker=1,
                processes=True,
                dashboard_address=None,
                memory_limit=0,
                silence_logs=logging.CRITICAL,
            ) as cluster,
            Client(cluster) as client,
        ):
            yield client


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    """Yield a client of a running scheduler with at least one worker; raises BadInput."""
    from distributed import Client

    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        message = (
            f"no scheduler answers at {address!r} ({error}), start one with `dask scheduler` and give its tcp address"
        )
        raise BadInput.of(message, key="--scheduler") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_S)
        except TimeoutError as error:
            message = f"the scheduler at {address!r} has no workers, start some with `dask worker {address}`"
            raise BadInput.of(message, key="--scheduler") from error
        yield client


def run_all(
    client: Client, function: Callable[[TaskT], ResultT], tasks: Sequence[TaskT], *, names: Sequence[str]
) -> Iterator[Outcome[TaskT, ResultT]]:
    """Yield the outcomes of `function` on all tasks as they come; `names` (one per task) tell tasks apart.

    `function` and tasks are sent to the workers, so both must be importable or picklable there.
    """
    from distributed import as_completed

    futures = [
        client.submit(function, task, key=name, retries=RETRIES, pure=False)
        for name, task in zip(names, tasks, strict=True)
    ]
    by_key = dict(zip((future.key for future in futures), tasks, strict=True))
    for future in as_completed(futures):
        task = by_key[future.key]
        error = future.exception()
        yield Outcome(task, future.result()) if error is None else Outcome(task, None, error)
        future.release()
