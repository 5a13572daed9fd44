"""Runs in processes, or threads, of this machine."""

import contextlib
import os
import signal
import sys
import threading
from collections import Counter, deque
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED as FIRST
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor, as_completed, wait
from multiprocessing import connection, get_context, parent_process
from pathlib import Path
from types import ModuleType
from typing import Any

from blockstruct.errors import StudyError
from blockstruct.studies.plan import Plan
from blockstruct.studies.task import Job, carry_out, carry_out_sent
from blockstruct.units import Q_

#: How often a run is begun whose worker ends while it is at work.
MOST_STARTS = 2
#: One thread per library: the workers share the processors among themselves.
_ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMEXPR_NUM_THREADS",
        "RAYON_NUM_THREADS",
    ),
    "1",
)

#: Runs as they end, each with why it failed, if it did.
Ended = Generator[tuple[Job, str], None, None]


def here(plan: Plan, jobs: Sequence[Job], folder: Path) -> Ended:
    """Carry out runs in this process, one after the other."""
    for job in jobs:
        yield job, carry_out(plan, job, folder)


def in_threads(plan: Plan, jobs: Sequence[Job], folder: Path, workers: int) -> Ended:
    """Carry out runs in threads of this process."""
    Q_(1.0, "meter")  # The registry reads its definitions when it is first used: by one thread only.
    with ThreadPoolExecutor(workers, thread_name_prefix="study") as pool:
        futures = {pool.submit(carry_out, plan, job, folder): job for job in jobs}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def in_processes(plan: Plan, jobs: Sequence[Job], folder: Path, workers: int, memory_limit: int | None) -> Ended:
    """Carry out runs in processes of their own, each with one thread per library.

    A worker that ends, killed or out of memory, takes its run alone with it: the run is gone on with in another
    worker, from its last committed iteration, and has failed if that one ends, too.

    Raises
    ------
    StudyError
        If the workers cannot start.
    """
    sent, why_script = plan.pickled()
    waiting, starts = deque(jobs), Counter[str]()
    idle = [_Worker(memory_limit, why_script) for _ in range(min(workers, len(jobs)))]
    busy: dict[Future[str], tuple[_Worker, Job]] = {}
    try:
        for worker in idle:
            worker.await_start()
        while waiting or busy:
            while idle and waiting:
                worker, job = idle.pop(), waiting.popleft()
                starts[job.name] += 1
                busy[worker.submit(carry_out_sent, sent, job, str(folder))] = worker, job
            for future in wait(busy, return_when=FIRST).done:
                worker, job = busy.pop(future)
                try:
                    problem = future.result()
                    idle.append(worker)
                except BrokenExecutor:
                    worker.end()
                    idle.append(_Worker(memory_limit, why_script))
                    if starts[job.name] < MOST_STARTS:
                        waiting.appendleft(job)
                        continue
                    problem = (
                        f"the worker ended {MOST_STARTS} times while it was at work: it was killed, or memory ran out"
                    )
                yield job, problem
    finally:
        for worker in [*idle, *(worker for worker, _ in busy.values())]:
            worker.end()


class _Worker:
    """A process that carries out one run at a time; it imports the script of this one if there is a reason why."""

    def __init__(self, memory_limit: int | None, why_script: str) -> None:
        self._why_script = why_script
        # Spawned, not forked: locks of threads and libraries that a fork copies may never open again.
        self._pool = ProcessPoolExecutor(
            1, mp_context=get_context("spawn"), initializer=_begin, initargs=(memory_limit,)
        )
        self._started = self.submit(os.getpid)

    def await_start(self) -> None:
        try:
            self._started.result()
        except BrokenExecutor as error:
            msg = (
                "study: a worker process ended as it started (its own message stands above). A memory limit must leave "
                "room for Python itself, some 500 MB."
            )
            if self._why_script:
                msg += (
                    " A script that defines build must call study under `if __name__ == '__main__':`, because each "
                    'worker imports it where cloudpickle, which comes with "blockstruct[cluster]", cannot send it '
                    f"({self._why_script}); or give threads=True"
                )
            raise StudyError(msg) from error

    def submit(self, function: Any, *args: Any) -> Future[Any]:
        # Processes start when they are first given something to do.
        with _start_of_a_process(needs_script=bool(self._why_script)):
            try:
                return self._pool.submit(function, *args)
            except BrokenExecutor as error:  # It ended while it had nothing to do.
                failed = Future[Any]()
                failed.set_exception(error)
                return failed

    def end(self) -> None:
        """End the process at once: what it has at work is committed, iteration by iteration."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        if self._started.done() and not self._started.cancelled() and self._started.exception() is None:
            with contextlib.suppress(OSError):
                os.kill(self._started.result(), signal.SIGTERM)


@contextlib.contextmanager
def _start_of_a_process(*, needs_script: bool) -> Iterator[None]:
    """What a process that is started meanwhile finds: its environment, and whether it imports the script of this one.

    A script that is imported runs again, but for what stands under ``if __name__ == "__main__"``.
    """
    before, script = {name: os.environ.get(name) for name in _ONE_THREAD}, sys.modules["__main__"]
    os.environ.update(_ONE_THREAD)
    try:
        if not needs_script:
            sys.modules["__main__"] = ModuleType("__main__")
        yield
    finally:
        sys.modules["__main__"] = script
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin(memory_limit: int | None) -> None:
    """Prepare a worker process."""
    # The process that conducts tells its workers when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    if memory_limit is not None:
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (memory_limit, memory_limit))


def _end_with(sentinel: int) -> None:
    """End this process when another one does: it would wait for ever for something to do."""
    connection.wait([sentinel])
    os._exit(1)
