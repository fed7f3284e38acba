"""Independent tasks on worker processes: of this machine (`etextile.process`), or of a dask scheduler that is there.

Tasks are named, so that results do not depend on how many workers there are or in which order they finish. A worker
that dies loses nothing: its task goes to another one. Local workers open no port; a scheduler is the user's own, and
whoever can reach it can run code on its workers and answer for them.
"""

# mypy: disallow-untyped-calls=False

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from etextile import foreign_code
from etextile.errors import BadInput
from etextile.process import LocalPool, TaskOutcome


if TYPE_CHECKING:
    from distributed import Client

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

CONNECT_S = 10
"""Seconds that a scheduler may take to answer, and that its first worker may take to come."""
RETRIES = 2
"""How often a scheduler tries a task again that raised an error."""
DEATHS = 5
"""How many workers may die under a task before it counts as failed."""


@contextmanager
def workers(*, jobs: int | None = None, scheduler: str | None = None) -> Iterator[LocalPool | Client]:
    """Yield a pool of `jobs` new local processes (one per core by default), or the client of a scheduler's address.

    Raises BadInput when no scheduler answers there or it has no workers.
    """
    if scheduler is None:
        with LocalPool(jobs) as pool:
            yield pool
        return
    import dask

    quiet = {
        "distributed.scheduler.worker-ttl": None,
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.admin.tick.limit": "1h",
    }
    with dask.config.set(quiet), _connected(scheduler) as client:
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
    pool: LocalPool | Client, function: Callable[[TaskT], ResultT], tasks: Sequence[TaskT], *, names: Sequence[str]
) -> Iterator[TaskOutcome[TaskT, ResultT]]:
    """Yield the outcomes of `function` on all tasks as they come; `names` (one per task) tell tasks apart.

    `function` and tasks are sent to the workers, so both must be importable or picklable there.
    """
    if isinstance(pool, LocalPool):
        yield from pool.run(function, tasks)
        return
    from distributed import as_completed

    sent = partial(foreign_code.call_with, foreign_code.allowed(), function)
    futures = [
        pool.submit(sent, task, key=name, retries=RETRIES, pure=False) for name, task in zip(names, tasks, strict=True)
    ]
    by_key = dict(zip((future.key for future in futures), tasks, strict=True))
    for future in as_completed(futures):
        task = by_key[future.key]
        error = future.exception()
        yield TaskOutcome(task, future.result()) if error is None else TaskOutcome(task, None, error)
        future.release()
