"""Independent tasks side by side: on the processors of this machine, or on the ranks of mpirun.

There is one process for each processor, each with a pipe of its own. Where a task takes its process
down (a fault in a library, no memory left), that task is known, fails alone, and the next one gets
a new process; Ctrl-C ends all processes at once. These are the promises for which there is a pool
of our own: the executors of `concurrent.futures` and `loky` give up all tasks where one process
dies, and wait for the tasks that run when they are left; `multiprocessing.Pool` waits for ever for
the task of a process that died; `pebble` 5.1 may do so, too.
"""

from __future__ import annotations

import os
import pickle
import signal
import threading
import time as clock
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import partial
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from types import FrameType
from typing import Any, Protocol, TypeVar

from solver.errors import RockslipError, SceneError, not_installed
from solver.run.progress import ProgressDisplay


class Named(Protocol):
    """A task with a name."""

    @property
    def name(self) -> str:
        """Its name."""


Task = TypeVar("Task")
NamedTask = TypeVar("NamedTask", bound=Named)
Value = TypeVar("Value")

#: Time that a process is given to end by itself before it is killed, s.
TIME_TO_END = 2.0

#: Environment variables with the number of threads of libraries.
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ProcessEnded(RockslipError):
    """A task took its process down."""


def parallel_map(
    function: Callable[[Task], Value], tasks: Sequence[Task], *, processes: int | None = None
) -> Generator[tuple[int, Value | Exception], None, None]:
    """Call a function for each of many tasks; yields as they finish, not in their order.

    Under mpirun every rank must come here and iterate: rank 0 hands the tasks out and gets all
    results, the other ranks work and yield nothing. Tasks are called with one process each: what
    they do with MPI belongs on `MPI.COMM_SELF`. Leaving the loop, Ctrl-C and SIGTERM (a
    `KeyboardInterrupt` here) end the processes at once.

    Args:
        function: Function of a module, not a lambda, since other processes import it.
        tasks: Arguments to call it with, one for each call.
        processes: Number of processes; None: one for each processor. Under mpirun the ranks count.

    Yields:
        The number of a task, and what the function returned or the exception that it raised;
        `ProcessEnded` where the task took its process down.
    """
    from mpi4py import MPI

    if MPI.COMM_WORLD.size > 1:
        yield from _on_ranks(MPI.COMM_WORLD, function, tasks)
    elif tasks:
        yield from _on_processes(function, tasks, min(processes or processors(), len(tasks)))


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0))


def _on_ranks(
    comm: Any, function: Callable[[Task], Value], tasks: Sequence[Task]
) -> Generator[tuple[int, Value | Exception], None, None]:
    """Run the tasks on all ranks but the first."""
    from concurrent.futures import as_completed

    from mpi4py.futures import MPICommExecutor

    ranks: Any = MPICommExecutor(comm, root=0)
    with ranks as executor:
        if executor is None:  # a rank that works: it has done so when it comes here
            return
        numbers = {executor.submit(_sent, function, task): k for k, task in enumerate(tasks)}
        try:
            for future in as_completed(numbers):
                yield numbers.pop(future), pickle.loads(future.result())
        finally:
            for future in numbers:
                future.cancel()


def _on_processes(
    function: Callable[[Task], Value], tasks: Sequence[Task], processes: int
) -> Generator[tuple[int, Value | Exception], None, None]:
    """Run the tasks on processes of this machine."""
    waiting = iter(enumerate(tasks))
    with ExitStack() as stack:
        stack.enter_context(_termination_interrupts())
        start = partial(_Worker, function)
        workers = [start() for _ in range(processes)]
        stack.callback(_end, workers)
        for worker in workers:
            worker.give(next(waiting, None))
        while busy := [worker for worker in workers if worker.number >= 0]:
            ready = wait([worker.connection for worker in busy])
            for worker in (worker for worker in busy if worker.connection in ready):
                number, outcome = worker.number, worker.take()
                if isinstance(outcome, ProcessEnded):
                    workers.remove(worker)
                    worker = start()
                    workers.append(worker)
                worker.give(next(waiting, None))
                yield number, outcome


class _Worker:
    """A process that is given one task after the other."""

    def __init__(self, function: Callable[[Any], Any]):
        """Start a new process, since MPI does not survive a fork."""
        context = get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.number = -1
        self._process = context.Process(target=_work, args=(function, theirs), daemon=True)
        with _settings():
            self._process.start()
        theirs.close()  # so that the end of the process is the end of the pipe

    def give(self, task: tuple[int, Any] | None) -> None:
        """Give the process a task with its number; None: there is none left."""
        self.number = -1
        if task is None:
            return
        self.number, what = task
        try:
            self.connection.send(what)
        except OSError:  # it has ended already, which `take` will find
            pass

    def take(self) -> Any:
        """Outcome of the task; waits for it."""
        try:
            return pickle.loads(self.connection.recv_bytes())
        except (EOFError, OSError):
            self._process.join(TIME_TO_END)
            return ProcessEnded(f"its process was ended by {_cause(self._process.exitcode)}")

    def stop(self) -> None:
        """Terminate the process."""
        self.connection.close()
        self._process.terminate()

    def join(self) -> None:
        """Wait for the end of the process, and force it."""
        self._process.join(TIME_TO_END)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _end(workers: list[_Worker]) -> None:
    """End all processes."""
    for worker in workers:
        worker.stop()
    for worker in workers:
        worker.join()


def _work(function: Callable[[Any], Any], connection: Connection) -> None:
    """Work of a process: take tasks and send back their outcomes, until the pipe ends."""
    # Ctrl-C reaches all processes of a terminal; the one that gives the tasks ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            task = connection.recv()
            connection.send_bytes(_sent(function, task))
        except (EOFError, OSError):
            return


def _sent(function: Callable[[Task], Value], task: Task) -> bytes:
    """Outcome of a task as it is sent: pickled here, where an exception may refuse it."""
    try:
        return pickle.dumps(function(task))
    except Exception as error:
        try:
            text = pickle.dumps(error)
            pickle.loads(text)  # exceptions with arguments of their own may not come back
        except Exception:
            return pickle.dumps(RuntimeError(f"{type(error).__name__}: {error}"))
        return text


def _cause(code: int | None) -> str:
    """Cause of the end of a process, in words."""
    if code is None or code >= 0:
        return f"exit code {code}"
    name = signal.Signals(-code).name
    return f"{name} (no memory left?)" if name == "SIGKILL" else name


@contextmanager
def _settings() -> Iterator[None]:
    """Let processes that are started meanwhile use one thread each, and PETSc no signal handler.

    It would end a process whose pipe is closed with a page about a caught signal.
    """
    petsc = f"{os.environ.get('PETSC_OPTIONS', '')} -no_signal_handler"
    settings = dict.fromkeys(THREAD_VARIABLES, "1") | {"PETSC_OPTIONS": petsc.strip()}
    before = {name: os.environ[name] for name in settings if name in os.environ}
    os.environ.update(settings)
    try:
        yield
    finally:
        for name in settings:
            del os.environ[name]
        os.environ.update(before)


@contextmanager
def _termination_interrupts() -> Iterator[None]:
    """Let SIGTERM do meanwhile what Ctrl-C does; only the main thread of a process can do this."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


# ---------------------------------------------------------------- with a display


def finished_cases(
    function: Callable[[NamedTask], Value],
    cases: Sequence[NamedTask],
    *,
    done: int = 0,
    processes: int | None = None,
    quiet: bool = False,
) -> Generator[tuple[NamedTask, Value | Exception], None, None]:
    """Cases as they finish, not in their order, while the progress is shown; as `parallel_map`.

    `done` is how many other cases had been done before. With each case comes what the function
    returned or the exception that it raised.
    """
    from mpi4py import MPI

    if MPI.COMM_WORLD.size > 1:
        # PETSc starts on all ranks together, also on the first one, which runs nothing. Where it is
        # missing, cases that need it fail with that reason.
        with suppress(ImportError):
            import_module("petsc4py.PETSc")
    progress = CaseProgress(done + len(cases), done=done, quiet=quiet, rank=MPI.COMM_WORLD.rank)
    outcomes = parallel_map(function, cases, processes=processes)
    with closing(progress), closing(outcomes):
        for number, outcome in outcomes:
            yield cases[number], outcome
            progress.add(cases[number].name)


def reason_of(error: Exception) -> str:
    """Reason why a case failed: the line of a refused scene, else kind and text of the error.

    Raises:
        EnvironmentTrouble: Where a package is missing: then no case can be run.
    """
    if isinstance(error, ImportError):
        raise not_installed(error) from error
    if isinstance(error, SceneError):
        return str(error)
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


class CaseProgress(ProgressDisplay):
    """Finished cases of a study, and the time that is left; shown on rank 0 only."""

    def __init__(self, total: int, *, done: int = 0, quiet: bool = False, rank: int = 0):
        """Start, where `done` of all cases had been done before; shows nothing but on rank 0."""
        layout = "{percentage:3.0f}%|{bar}| {n_fmt}/{total_fmt} {elapsed}<{remaining}{postfix}"
        share = done / max(total, 1)
        super().__init__(
            quiet=quiet, rank=rank, done=share, total=total, initial=done, bar_format=layout
        )
        self._total, self._before, self._done = total, done, done

    def add(self, name: str) -> None:
        """Count a finished case of this name."""
        self._done += 1
        if self._silent:
            return
        now = clock.monotonic()
        if self._bar is not None:
            self._bar.set_postfix_str(name, refresh=False)
            self._bar.update()
        elif self._line_is_due(now, self._done / self._total) or self._done == self._total:
            spent = now - self._began
            left = spent * (self._total - self._done) / (self._done - self._before)
            self._write(
                f"{self._done} of {self._total} ({name}), {spent:.0f} s spent, {left:.0f} s left"
            )
