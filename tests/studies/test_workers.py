"""Studies in processes and on Dask clusters: the same rows, and nothing lost."""

import os
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import blockstruct as bs
import studied
from blockstruct import Q_
from blockstruct.storage.run_folder import writer_lock

SUPPORT, SOURCE = Path(studied.__file__).parent, Path(bs.__file__).parents[1]
MU = {"friction_coefficient": [0.3, 0.4, 0.45, 0.6]}
EXPECTED = [0.3, 0.4, 0.45, 0.5]


def load_factors(data):
    return data.load_factor.to_numpy().ravel().tolist()


@pytest.fixture(scope="module")
def cluster():
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", memory_limit="2 GB") as found:
        yield found


def test_processes_lose_one_run_at_most(tmp_path):
    """A worker that is killed loses its run alone, which another process begins again."""
    before = dict(os.environ)
    seen = []
    values = MU | {"folder": str(tmp_path)}
    data = bs.study(studied.killing, values, tmp_path / "store", workers=2, listeners=[seen.append])
    assert load_factors(data) == pytest.approx(EXPECTED, rel=1e-6)
    assert (tmp_path / "killed").exists()
    assert [p.done for p in seen] == [0, 1, 2, 3, 4]
    assert dict(os.environ) == before


@pytest.mark.slow
def test_a_run_that_kills_its_worker_is_a_row(tmp_path):
    with pytest.warns(bs.errors.StudyWarning, match=r"1 of 4 runs failed.*ended twice"):
        data = bs.study(studied.dying, MU, tmp_path, workers=2)
    assert data.status.to_numpy().ravel().tolist() == ["converged", "failed", "converged", "converged"]
    assert len(list(tmp_path.glob("*.h5"))) == 3


def test_what_cannot_be_sent_is_refused(tmp_path):
    lock = threading.Lock()
    with pytest.raises(bs.errors.StudyError, match=r"<lambda> cannot be sent.*\(TypeError: .*workers=1"):
        bs.study(lambda mu: studied.block(mu, lock), {"mu": [0.3, 0.4]}, tmp_path, workers=2)


SCRIPT = """
import sys
from functools import partial
import blockstruct as bs, studied
from blockstruct import Q_
MORE = Q_(0.25, "m"), None
TALL = Q_(1, "m")
def build(mu, height):
    return studied.block(mu, height + MORE[0])
data = bs.study(partial(build, height=TALL), {"mu": [0.3, 0.32, 0.34, 0.7]}, workers=2)
print(data.load_factor.to_numpy().ravel().round(6).tolist())
"""


@pytest.mark.slow
def test_a_script_with_its_own_build(tmp_path):
    """It needs no guard: workers have the function and the quantities that it refers to, and do not run the script."""
    (tmp_path / "script.py").write_text(SCRIPT)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (SUPPORT, SOURCE)))}
    command = [sys.executable, tmp_path / "script.py"]
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "[0.3, 0.32, 0.34, 0.4]\n", "")


def test_a_local_cluster(cluster, tmp_path):
    """By a client, by the cluster, and by its address: the same call, the same rows, nothing repeated."""
    from distributed import Client

    parameters = {"friction_coefficient": [0.3, 0.6], "height": Q_(1, "m")}
    with Client(cluster, set_as_default=False) as client:
        data = bs.study(lambda **values: studied.block(**values), parameters, tmp_path, cluster=client)
    assert load_factors(data) == pytest.approx([0.3, 0.5], rel=1e-6)
    assert bs.open_analysis(tmp_path / str(data.path.to_numpy()[0])).parameters["height"] == Q_(1, "m")
    seen = []
    # Another source that makes the same models.
    more = {"friction_coefficient": [0.3, 0.6, 0.35], "height": Q_(1, "m")}
    one = bs.study(studied.block, more, tmp_path, cluster=cluster, listeners=[seen.append])
    two = bs.study(studied.block, more, tmp_path, cluster=cluster.scheduler_address, listeners=[seen.append])
    assert load_factors(one) == load_factors(two) == pytest.approx([0.3, 0.5, 0.35], rel=1e-6)
    assert (seen[0].found, seen[-1].found) == (2, 3)


def test_failures_on_a_cluster_are_rows(cluster, tmp_path):
    with pytest.warns(bs.errors.StudyWarning, match="ValueError: no such stone"):
        data = bs.study(studied.failing, MU, tmp_path, cluster=cluster)
    assert np.isnan(load_factors(data)).tolist() == [False, True, False, False]


def test_a_run_that_another_writes_is_elsewhere_on_a_cluster(cluster, tmp_path):
    """The file of one run is being written when its worker has ended."""
    values = {"friction_coefficient": [0.3, 0.4]}
    path = tmp_path / str(bs.study(studied.block, values, tmp_path, cluster=cluster).path.to_numpy().ravel()[1])
    path.unlink()
    with writer_lock(path), pytest.warns(bs.errors.StudyWarning, match="another study is carrying out 1 of 2 runs"):
        data = bs.study(studied.block, values, tmp_path, cluster=cluster)
    assert data.elsewhere.to_numpy().tolist() == [False, True]
    assert not path.exists()
    assert load_factors(bs.study(studied.block, values, tmp_path, cluster=cluster)) == pytest.approx([0.3, 0.4])


@pytest.mark.slow
def test_a_worker_of_a_cluster_is_killed(cluster, tmp_path):
    data = bs.study(studied.killing, MU | {"folder": str(tmp_path)}, tmp_path / "store", cluster=cluster)
    assert load_factors(data) == pytest.approx(EXPECTED, rel=1e-6)
    assert (tmp_path / "killed").exists()


@pytest.mark.parametrize("given", [3, ""])
def test_what_is_no_cluster_is_told_at_once(tmp_path, given):
    with pytest.raises(bs.errors.ClusterError, match=f"no worker of cluster {given!r} answers"):
        bs.study(studied.block, MU, tmp_path / "store", cluster=given)
    assert not (tmp_path / "store").exists()


def test_a_cluster_without_workers_is_told(tmp_path, monkeypatch):
    from distributed import LocalCluster

    monkeypatch.setattr("blockstruct.studies.workers.PATIENCE", 0.5)
    with (
        LocalCluster(n_workers=0, dashboard_address=":0") as empty,
        pytest.raises(bs.errors.ClusterError, match=r"no worker .*0/1 workers.*start workers"),
    ):
        bs.study(studied.block, MU, tmp_path, cluster=empty)


@pytest.mark.slow
def test_a_study_that_is_killed_leaves_its_runs_and_no_process(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        textwrap.dedent(f"""
        import blockstruct as bs, studied
        if __name__ == "__main__":
            values = {MU!r} | {{"folder": {str(tmp_path)!r}}}
            bs.study(studied.slow, values, {str(tmp_path / "store")!r}, workers=2)
        """)
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (SUPPORT, SOURCE)))}
    process = subprocess.Popen([sys.executable, script], env=environment)
    while not (tmp_path / "worker").exists() or len(list((tmp_path / "store").glob("*.h5"))) < 3:
        time.sleep(0.1)
    worker = int((tmp_path / "worker").read_text())
    process.kill()
    process.wait()
    (tmp_path / "killed").touch()
    for _ in range(100):
        if not Path(f"/proc/{worker}").exists() or "zombie" in Path(f"/proc/{worker}/status").read_text():
            break
        time.sleep(0.05)
    else:
        pytest.fail("the worker lives on")
    seen = []
    values = MU | {"folder": str(tmp_path)}
    data = bs.study(studied.slow, values, tmp_path / "store", workers=1, listeners=[seen.append])
    assert seen[0].found == 3
    assert load_factors(data) == pytest.approx(EXPECTED, rel=1e-6)
