"""Carry out the runs of a study in this process, in worker processes or on a Dask cluster."""

import contextlib
import os
import signal
import sys
import threading
import uuid
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor, as_completed
from importlib.metadata import version
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType
from typing import Any

from blockstruct.errors import BusyError, ClusterError, MissingExtraError, StudyError, shown
from blockstruct.storage import save_image
from blockstruct.studies.plan import Plan, Problem, Run, carry_out_far, carry_out_sent, described

#: One thread per library, because the workers share the processors.
_ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "RAYON")}
_ONE_THREAD |= {"VECLIB_MAXIMUM_THREADS": "1"}

#: Runs as they end, each with the reason if it has no results.
Ended = Generator[tuple[Run, Problem], None, None]


def in_processes(plan: Plan, runs: Sequence[Run], folder: Path, workers: int) -> Ended:
    """Carry out runs in worker processes, each with one thread per library.

    A worker that is killed ends the pool. The runs at work then continue one by one from their last committed
    iteration, each in a process of its own. A run that ends its process again has failed.

    Raises
    ------
    StudyError
        If the workers cannot start.
    """
    sent = plan.pickled()
    left = {run.name: run for run in runs}

    def in_a_pool(some: Sequence[Run], count: int) -> Ended:
        with _pool(min(count, len(some))) as pool:
            futures: dict[Future[Problem], Run] = {}
            with contextlib.suppress(BrokenExecutor):
                for run in some:
                    futures[pool.submit(carry_out_sent, sent, run, str(folder))] = run
            for future in as_completed(futures):
                try:
                    problem = future.result()
                except BrokenExecutor:
                    continue
                yield left.pop(futures[future].name), problem

    while left:
        yield from in_a_pool([*left.values()], workers)
        # Runs begin in order, so the unfinished runs of a pool are the first of the remaining ones.
        for run in [*left.values()][:workers]:
            yield from in_a_pool([run], 1)
            if left.pop(run.name, None):
                why = "its worker process ended twice while it was at work: it was killed, or memory ran out"
                yield run, Problem(why)


@contextlib.contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Start a pool of processes that end at once with the context.

    Committed iterations are kept.
    """
    # Spawned, not forked: a lock that a fork copies while it is held never opens.
    context = get_context("spawn")
    ends_with_parent, held_by_parent = context.Pipe(duplex=False)
    # Windows waits for at most 61 processes.
    workers = min(workers, 61) if sys.platform == "win32" else workers
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=(ends_with_parent,))
    try:
        with _start_of_processes():
            # A pool starts a process for each call that finds none idle, and none is before all have begun.
            started = [pool.submit(os.getpid) for _ in range(workers)]
        try:
            for process in started:
                process.result()
        except BrokenExecutor as error:
            msg = "study: a worker process ended as it started. Its own message stands above."
            raise StudyError(msg) from error
        yield pool
    finally:
        held_by_parent.close()
        pool.shutdown(cancel_futures=True)
        ends_with_parent.close()


@contextlib.contextmanager
def _start_of_processes() -> Iterator[None]:
    """Set the environment of new processes, which do not run the script of this process again."""
    before, script = {name: os.environ.get(name) for name in _ONE_THREAD}, sys.modules["__main__"]
    os.environ.update(_ONE_THREAD)
    try:
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


#: Seconds within which a scheduler must answer and a worker must be available.
PATIENCE = 10.0


@contextlib.contextmanager
def connected(cluster: Any) -> Iterator[Any]:
    """Connect to a cluster with a worker of this version of blockstruct.

    Parameters
    ----------
    cluster
        A ``distributed.Client``, a cluster such as ``LocalCluster``, or the address of a scheduler.

    Raises
    ------
    ClusterError
        If no scheduler answers, it has no worker, or its workers cannot run blockstruct.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        raise MissingExtraError.of(error, "cluster", "study: cluster") from error
    with contextlib.ExitStack() as stack:
        try:
            if not isinstance(cluster, Client):
                cluster = stack.enter_context(Client(cluster, timeout=PATIENCE, set_as_default=False))
            cluster.wait_for_workers(1, timeout=PATIENCE)
            theirs = cluster.submit(version, "blockstruct", pure=False).result(timeout=6 * PATIENCE)
        except Exception as error:  # Of the network, of Dask, or of a worker.
            msg = (
                f"study: no worker of cluster {shown(cluster)} answers ({described(error)}); give a Dask client, a "
                "running cluster or the address of a scheduler, and start workers that have blockstruct by `dask "
                "worker ADDRESS`"
            )
            raise ClusterError(msg) from error
        if theirs != version("blockstruct"):
            msg = (
                f"study: workers of the cluster have blockstruct {theirs}, this is {version('blockstruct')}; install "
                "the same version on both sides"
            )
            raise ClusterError(msg)
        yield cluster


def on_cluster(plan: Plan, runs: Sequence[Run], folder: Path, client: Any) -> Ended:
    """Carry out runs on a cluster; each file is written on this machine.

    If a worker ends, the scheduler begins its runs again on other workers, up to its ``allowed-failures``.

    Raises
    ------
    ClusterError
        If the scheduler is lost.
    """
    from distributed import as_completed

    sent = plan.pickled()
    # The keys are unique, so that a cluster reuses no old result.
    keys = {run.name: f"blockstruct-{run.name}-{uuid.uuid4().hex[:8]}" for run in runs}
    futures = {client.submit(carry_out_far, sent, run, key=keys[run.name], pure=False): run for run in runs}
    try:
        for future in as_completed(list(futures), loop=client.loop):
            run = futures.pop(future)
            try:
                problem, image = future.result()
            except CancelledError as error:
                msg = "study: the scheduler was lost; the runs that had ended are kept, call study again to go on"
                raise ClusterError(msg) from error
            except Exception as error:
                problem, image = Problem.of(error), b""
            future.release()
            if image:
                try:
                    save_image(image, folder / f"{run.name}.h5")
                except BusyError as error:
                    problem = Problem.of(error)
            yield run, problem
    finally:
        with contextlib.suppress(Exception):
            client.cancel(list(futures))
