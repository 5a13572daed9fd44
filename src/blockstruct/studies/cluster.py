"""Runs on a Dask cluster."""

import contextlib
import uuid
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from importlib.metadata import version
from pathlib import Path
from typing import Any

from blockstruct.errors import BusyError, ClusterError, MissingExtraError, shown
from blockstruct.storage import save_image
from blockstruct.studies.plan import Plan
from blockstruct.studies.processes import Ended
from blockstruct.studies.task import Job, Problem, carry_out_far, described

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
    if isinstance(cluster, Client):
        _check(cluster)
        yield cluster
        return
    address = getattr(cluster, "scheduler_address", cluster)
    if not isinstance(address, str) or not address:
        msg = (
            f"study: cluster is {shown(cluster)}; give a dask Client, a running cluster such as LocalCluster, or the "
            "address of a scheduler such as 'tcp://127.0.0.1:8786'"
        )
        raise ClusterError(msg)
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise _unreachable(address, error) from error
    try:
        _check(client)
        yield client
    finally:
        client.close()


def _check(client: Any) -> None:
    address = getattr(client.scheduler, "address", "") or "no address"
    if client.status != "running":
        raise _unreachable(address, f"the client is {client.status}")
    try:
        identity = client.sync(client.scheduler.identity, callback_timeout=PATIENCE)
        if not identity["workers"]:
            client.wait_for_workers(1, timeout=PATIENCE)
    except (OSError, RuntimeError) as error:  # a TimeoutError is an OSError
        if client.status == "running" and "workers" in str(error):
            msg = f"study: the scheduler at {address} has no worker; start one by `dask worker {address}`"
            raise ClusterError(msg) from error
        raise _unreachable(address, error) from error
    try:
        theirs = client.submit(version, "blockstruct", pure=False).result(timeout=6 * PATIENCE)
    except Exception as error:
        msg = f"study: workers of {address} cannot run blockstruct ({described(error)}); install it there"
        raise ClusterError(msg) from error
    if theirs != version("blockstruct"):
        msg = (
            f"study: workers of {address} have blockstruct {theirs}, this is {version('blockstruct')}; "
            "install the same version on both sides"
        )
        raise ClusterError(msg)


def on_cluster(plan: Plan, jobs: Sequence[Job], folder: Path, client: Any) -> Ended:
    """Carry out runs on a cluster; each file is written on this machine.

    If a worker ends, the scheduler begins its runs again on other workers, up to its ``allowed-failures``.

    Raises
    ------
    ClusterError
        If the scheduler is lost.
    """
    from distributed import as_completed

    sent, _ = plan.pickled()
    futures = {client.submit(carry_out_far, sent, job, key=_key(job), pure=False): job for job in jobs}
    try:
        for future in as_completed(list(futures), loop=client.loop):
            job = futures.pop(future)
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
                    save_image(image, folder / f"{job.name}.h5")
                except BusyError as error:
                    problem = Problem.of(error)
            yield job, problem
    finally:
        with contextlib.suppress(Exception):
            client.cancel(list(futures))


def _key(job: Job) -> str:
    """Return a unique key of a run, so that a cluster reuses no old result."""
    return f"blockstruct-{job.name}-{uuid.uuid4().hex[:8]}"


def _unreachable(address: str, why: Any) -> ClusterError:
    return ClusterError(
        f"study: no scheduler answers at {address} ({why}); start one by `dask scheduler` and `dask worker ADDRESS`, "
        "or leave cluster out to run on this machine"
    )
