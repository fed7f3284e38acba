"""Worker processes: they die, their tasks raise, their parent is killed, and nothing is lost or left behind."""

from __future__ import annotations

import math
import operator
import os
import signal
import struct
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from etextile.errors import BadInput, Problem
from etextile.process import LocalPool


DIES_ONCE = "__import__('os').path.exists({0!r}) or (open({0!r}, 'x').close(), __import__('os')._exit(1))"


def test_a_worker_that_dies_loses_nothing_and_a_task_that_kills_is_found_out(tmp_path: Path) -> None:
    tasks = [partial(math.sqrt, 4.0), partial(os._exit, 7), partial(eval, DIES_ONCE.format(str(tmp_path / "x")))]
    tasks += [partial(math.sqrt, float(n * n)) for n in range(1, 6)]
    with LocalPool(2) as pool:
        found = {outcome.task: outcome for outcome in pool.run(operator.call, tasks)}
    assert [found[task].result for task in tasks] == [2.0, None, True, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert "died each time" in str(found[tasks[1]].error)
    assert [outcome for outcome in found.values() if outcome.error] == [found[tasks[1]]]


def test_a_server_of_workers_that_dies_loses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever asks a server for a worker as it is killed reads the end of a pipe."""
    died = iter([EOFError("unexpected EOF"), ConnectionResetError()])
    submit = LocalPool._submit

    def asked(self: LocalPool, function: Any, task: Any) -> Any:
        if error := next(died, None):
            raise error
        return submit(self, function, task)

    monkeypatch.setattr(LocalPool, "_submit", asked)
    with LocalPool(2) as pool:
        assert sorted(found.result for found in pool.run(math.sqrt, [4.0, 9.0])) == [2.0, 3.0]


def test_an_error_that_stays_is_the_outcome() -> None:
    with LocalPool(1) as pool:
        bad, good = sorted(pool.run(math.sqrt, [-1.0, 9.0]), key=lambda item: item.task)
    assert isinstance(bad.error, ValueError)
    assert good.result == 3.0


def test_a_worker_has_the_environment_of_its_parent_and_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    with LocalPool(1) as pool:
        list(pool.run(abs, [-1]))  # from here on there is a server, whose environment is older
    monkeypatch.setenv("ETEXTILE_TEST", "said later")
    names = ["ETEXTILE_TEST", "OMP_NUM_THREADS"]
    with LocalPool(1) as pool:
        found = {outcome.task: outcome.result for outcome in pool.run(os.getenv, names)}
    assert found == {"ETEXTILE_TEST": "said later", "OMP_NUM_THREADS": "1"}


@pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux")
def test_workers_are_forks_of_a_process_without_threads_that_has_what_they_need() -> None:
    asked = ["len(__import__('os').listdir(f'/proc/{__import__(\"os\").getppid()}/task'))"]
    asked += [f"{name!r} in __import__('sys').modules" for name in ("numba", "etextile.studies.ensemble.sample")]
    with LocalPool(1) as pool:
        found = {outcome.task: outcome.result for outcome in pool.run(eval, asked)}
    assert [found[question] for question in asked] == [1, True, True]


def test_a_folder_no_socket_fits_into_leaves_workers_that_begin_anew(tmp_path: Path) -> None:
    folder = tmp_path / ("long" * 40)
    folder.mkdir()
    code = "from etextile.process import LocalPool, begin_server\nif __name__ == '__main__':\n"
    code += "    print(begin_server(), [outcome.result for outcome in LocalPool(1).run(abs, [-3])])\n"
    script = tmp_path / "parent.py"
    script.write_text(code)
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2]), "TMPDIR": str(folder)}
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False, env=environment)
    assert run.stdout.split() == ["False", "[3]"], run.stderr


def test_problems_come_from_a_worker_one_by_one() -> None:
    sent = BadInput([Problem("no", "case.yaml", 1, 2, "motion"), Problem("neither")])
    kind, content = sent.__reduce__()
    assert kind(*content).problems == sent.problems


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at processes through /proc")
def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    code = (
        "import operator, os, time\nfrom functools import partial\nfrom etextile.process import LocalPool\n"
        "TASKS = [partial(os.getpid), partial(time.sleep, 60)]\n"
        "if __name__ == '__main__':\n"
        "    for outcome in LocalPool(1).run(operator.call, TASKS):\n"
        "        print(outcome.result, flush=True)\n"
    )
    script = tmp_path / "parent.py"
    script.write_text(code)
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, env=environment) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        os.kill(parent.pid, signal.SIGKILL)
        parent.wait(timeout=10)
    for _ in range(50):
        if not Path(f"/proc/{worker}").exists() or ") Z " in Path(f"/proc/{worker}/stat").read_text():
            return
        time.sleep(0.1)
    pytest.fail("the worker outlived its parent")


def test_workers_ended_in_the_middle_of_a_message_leave_nobody_waiting() -> None:
    pool = LocalPool(1)
    assert [outcome.result for outcome in pool.run(abs, [-1])] == [1]
    executor: Any = pool._pool
    manager = executor._executor_manager_thread
    os.write(executor._result_queue._writer.fileno(), struct.pack("!i", 1000) + b"half of it")
    time.sleep(0.5)  # until the manager reads it
    pool.close(now=True)
    manager.join(timeout=20.0)
    assert not manager.is_alive()
