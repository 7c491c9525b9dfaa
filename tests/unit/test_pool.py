"""Tasks side by side: results, failures, processes that die, and leaving early."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from solver.errors import SceneError
from solver.study.pool import ProcessEnded, parallel_map

pytestmark = pytest.mark.serial

MODULE = """
import os, signal, sys, time
from solver.errors import SceneError

class Odd(Exception):
    def __init__(self, one, two):
        super().__init__(f"{one} and {two}")

class Unreadable:
    def __reduce__(self):
        return int, ("not a number",)

def act(task):
    if task == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if task == "fault":
        os.abort()
    if task == "leave":
        os._exit(7)
    if task == "refuse":
        raise SceneError("motion.file", "none", "one")
    if task == "odd":
        raise Odd(1, 2)
    if task == "lambda":
        return lambda: 0
    if task == "threads":
        return os.environ["OPENBLAS_NUM_THREADS"]
    if task == "catches":
        from petsc4py import PETSc
        words = dict(line.split(":") for line in open("/proc/self/status"))
        return bool(int(words["SigCgt"], 16) >> (signal.SIGPIPE - 1) & 1)
    return os.getpid(), task

def sleep(seconds):
    time.sleep(seconds)
    return seconds
"""


@pytest.fixture(scope="module")
def tasks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A module that other processes can import."""
    folder = tmp_path_factory.mktemp("tasks")
    (folder / "pool_tasks.py").write_text(MODULE)
    sys.path.insert(0, str(folder))
    return folder


def test_each_task_has_its_outcome(tasks: Path) -> None:
    """A failure, a fault and a kill stay with the tasks that they belong to."""
    import pool_tasks

    names = ["a", "die", "b", "refuse", "fault", "c", "odd", "lambda", "leave", "threads", "d"]
    outcomes = dict(parallel_map(pool_tasks.act, names, processes=2))
    found = {names[number]: outcome for number, outcome in outcomes.items()}
    assert set(found) == set(names)
    for name in "abcd":
        assert found[name][1] == name
        assert found[name][0] != os.getpid()
    assert found["threads"] == "1"
    for name, word in (("die", "SIGKILL"), ("fault", "SIGABRT"), ("leave", "exit code 7")):
        assert isinstance(found[name], ProcessEnded)
        assert word in str(found[name])
    assert isinstance(found["refuse"], SceneError)
    assert str(found["refuse"]) == "motion.file: got none, allowed one"
    assert str(found["odd"]) == "Odd: 1 and 2"
    assert isinstance(found["lambda"], Exception)


def test_petsc_catches_no_broken_pipe(tasks: Path) -> None:
    """Its handler would say a page about the broken pipe of a process that is ended."""
    pytest.importorskip("petsc4py")
    import pool_tasks

    before = os.environ.get("PETSC_OPTIONS")
    assert list(parallel_map(pool_tasks.act, ["catches"])) == [(0, False)]
    assert os.environ.get("PETSC_OPTIONS") == before


def test_a_task_that_cannot_be_read_fails_alone(tasks: Path) -> None:
    """Its process ends before it has said which task it took: the next ones get another."""
    import pool_tasks

    given = ["a", pool_tasks.Unreadable(), "b", "c"]
    outcomes = dict(parallel_map(pool_tasks.act, given, processes=1))
    assert [outcomes[number][1] for number in (0, 2, 3)] == ["a", "b", "c"]
    assert isinstance(outcomes[1], ProcessEnded) and "exit code 1" in str(outcomes[1])


def test_two_processes_work_at_the_same_time(tasks: Path) -> None:
    """Both sleep at once: results come as they finish, the short one first."""
    import pool_tasks

    order = [number for number, _ in parallel_map(pool_tasks.sleep, [0.6, 0.0], processes=2)]
    assert order == [1, 0]


SCRIPT = """
import sys
sys.path.insert(0, {folder!r})
from pool_tasks import sleep
from solver.study.pool import parallel_map
if __name__ == "__main__":
    try:
        for number, outcome in parallel_map(sleep, [0.0, 60.0, 60.0], processes=2):
            print("finished", number, flush=True)
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_all_processes_at_once(
    tasks: Path, tmp_path: Path, number: signal.Signals
) -> None:
    """Finished outcomes were yielded; no process stays behind; the signals are free again."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(folder=str(tasks)))
    run = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    assert run.stdout is not None
    assert run.stdout.readline() == "finished 0\n"
    began = time.monotonic()
    os.killpg(run.pid, number) if number == signal.SIGINT else run.send_signal(number)
    assert run.wait(timeout=20) == 130
    # Python's tracker of resources ends by itself once the others have: Python 3.14 does not wait.
    while is_there(run.pid):
        assert time.monotonic() - began < 10
        time.sleep(0.02)


def is_there(group: int) -> bool:
    """True if a group of processes has any left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_leaving_the_loop_ends_the_others(tasks: Path) -> None:
    import pool_tasks

    began = time.monotonic()
    outcomes = parallel_map(pool_tasks.sleep, [0.0, 60.0], processes=2)
    assert next(iter(outcomes)) == (0, 0.0)
    outcomes.close()  # type: ignore[attr-defined]
    assert time.monotonic() - began < 10


@pytest.mark.mpi
def test_the_ranks_of_mpirun_share_the_tasks(tasks: Path, tmp_path: Path) -> None:
    """The same loop: the first rank gets every outcome, failures included, the others none."""
    script = tmp_path / "ranks.py"
    script.write_text(
        f"import sys; sys.path.insert(0, {str(tasks)!r})\n"
        "from mpi4py import MPI\n"
        "from pool_tasks import act\n"
        "from solver.study.pool import parallel_map\n"
        "found = sorted((n, str(o)[-3:]) for n, o in parallel_map(act, ['refuse', 'b', 'odd']))\n"
        "print(MPI.COMM_WORLD.rank, found, flush=True)\n"
    )
    command = ["mpirun", "--oversubscribe", "-n", "3", sys.executable, str(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    lines = sorted(done.stdout.splitlines())
    assert lines == ["""0 [(0, 'one'), (1, "b')"), (2, 'd 2')]""", "1 []", "2 []"]
