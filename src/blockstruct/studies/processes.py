"""Carry out the runs of a study in this process or in worker processes."""

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType

from blockstruct.errors import StudyError
from blockstruct.studies.plan import Plan
from blockstruct.studies.task import Job, Problem, carry_out, carry_out_sent

#: One thread per library, because the workers share the processors.
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

#: Runs as they end, each with the reason if it has no results.
Ended = Generator[tuple[Job, Problem], None, None]


def here(plan: Plan, jobs: Sequence[Job], folder: Path) -> Ended:
    """Carry out runs in this process, one after the other."""
    for job in jobs:
        yield job, carry_out(plan, job, folder)


def in_processes(plan: Plan, jobs: Sequence[Job], folder: Path, workers: int) -> Ended:
    """Carry out runs in worker processes, each with one thread per library.

    A worker that is killed ends the pool. The runs at work then continue one by one from their last committed
    iteration, each in a process of its own. A run that ends its process again has failed.

    Raises
    ------
    StudyError
        If the workers cannot start.
    """
    sent, why_script = plan.pickled()
    left = {job.name: job for job in jobs}

    def in_a_pool(some: Sequence[Job], count: int) -> Ended:
        with _pool(min(count, len(some)), why_script) as pool:
            futures: dict[Future[Problem], Job] = {}
            with contextlib.suppress(BrokenExecutor):
                for job in some:
                    futures[pool.submit(carry_out_sent, sent, job, str(folder))] = job
            for future in as_completed(futures):
                try:
                    problem = future.result()
                except BrokenExecutor:
                    continue
                yield left.pop(futures[future].name), problem

    while left:
        yield from in_a_pool([*left.values()], workers)
        # Runs begin in order, so the unfinished runs of a pool are the first of the remaining ones.
        for job in [*left.values()][:workers]:
            yield from in_a_pool([job], 1)
            if left.pop(job.name, None):
                why = "its worker process ended twice while it was at work: it was killed, or memory ran out"
                yield job, Problem(why)


@contextlib.contextmanager
def _pool(workers: int, why_script: str) -> Iterator[ProcessPoolExecutor]:
    """Start a pool of processes that end at once with the context.

    Committed iterations are kept.
    """
    # Spawned, not forked: a lock that a fork copies while it is held never opens.
    context = get_context("spawn")
    ends_with_parent, held_by_parent = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=(ends_with_parent,))
    try:
        with _start_of_processes(needs_script=bool(why_script)):
            started = pool.submit(os.getpid)
        try:
            started.result()
        except BrokenExecutor as error:
            msg = "study: a worker process ended as it started. Its own message stands above."
            if why_script:
                msg += (
                    " A script that defines build must call study under `if __name__ == '__main__':`, because each "
                    'worker imports it where cloudpickle, which comes with "blockstruct[cluster]", cannot send it '
                    f"({why_script}); or give workers=1"
                )
            raise StudyError(msg) from error
        yield pool
    finally:
        held_by_parent.close()
        pool.shutdown(cancel_futures=True)
        ends_with_parent.close()


@contextlib.contextmanager
def _start_of_processes(*, needs_script: bool) -> Iterator[None]:
    """Set the environment of new processes.

    ``needs_script`` makes them import the script of this process. The script runs again, except for the code under
    ``if __name__ == "__main__"``.
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


def _begin(parent: Connection) -> None:
    """Prepare a worker process to end when its parent ends."""
    # An interrupt reaches the parent, which ends its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Connection) -> None:
    parent.poll(None)
    os._exit(1)
