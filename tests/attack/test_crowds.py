"""Many at once: a reader next to writers, hundreds of runs in one store, and disks that are full."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import blockstruct as bs
import killed_runs
import studied
from killed_runs import cases, wall
from processes import FRESH
from trials import outcome

SUPPORT = Path(killed_runs.__file__).parent


def rewrite(path, times, start):
    start.wait()
    for _ in range(times):
        try:
            bs.save_analysis(bs.open_analysis(path), path)
        except bs.errors.BusyError:
            continue


@pytest.mark.parametrize("times", [2, pytest.param(40, marks=pytest.mark.slow)])
def test_readers_beside_writers(tmp_path, tell, times):
    """Three processes replace a file again and again; a reader always sees a whole one, and no rubbish is left."""
    whole = bs.AnalysisManager(wall(), tmp_path / "wall.h5").run(cases())
    start = FRESH.Event()
    writers = [FRESH.Process(target=rewrite, args=(tmp_path / "wall.h5", times, start)) for _ in range(3)]
    for writer in writers:
        writer.start()
    start.set()
    outcomes = []

    def read():
        assert bs.open_analysis(tmp_path / "wall.h5")["sideways"].history.identical(whole["sideways"].history)
        table = bs.Archive(tmp_path).table().set_index("case")
        assert table.loc["sideways", "load_factor"] == whole["sideways"].load_factor

    while any(writer.is_alive() for writer in writers):
        how, said = outcome(read)
        if how != "answered":
            print(said)
        outcomes.append({"answered": "identical", "refused": "wrong"}.get(how, how))
    tell("reads next to writers", outcomes)
    assert outcomes
    assert [w.exitcode for w in writers] == [0, 0, 0]
    assert [p.name for p in tmp_path.iterdir()] == ["wall.h5"]


@pytest.mark.slow
def test_300_runs_in_one_store(tmp_path, tell):
    mu = np.linspace(0.2, 0.7, 300)
    data = bs.study(studied.block, {"friction_coefficient": mu.tolist()}, tmp_path, workers=2)
    table = bs.Archive(tmp_path).table().set_index("path")
    assert len(table) == len(list(tmp_path.glob("*.h5"))) == 300
    in_archive = table.loc[data.path.to_numpy().ravel(), "load_factor"].to_numpy()
    found = [data.load_factor.to_numpy().ravel(), in_archive]
    right = np.isclose(found, np.minimum(mu, 0.5), rtol=1e-6).all(axis=0)
    tell("runs in one store", np.where(right, "identical", "wrong").tolist())


#: Runs the wall on a disk of so many kilobytes, and again once there is space.
ON_A_DISK = """
import json, subprocess, sys
import blockstruct as bs
from pathlib import Path
from killed_runs import cases, check_resumed, wall
from blockstruct.storage import is_unfinished
whole, folder, outcomes = bs.AnalysisManager(wall()).run(cases()), Path(sys.argv[1]), []
for size in map(int, sys.argv[2:]):
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", folder], check=True)
    path = folder / "wall.h5"
    try:
        bs.AnalysisManager(wall(), path).run(cases())
        outcomes.append("answered")
    except bs.errors.StorageError as error:
        outcomes.append("refused" if "free some space" in str(error) else "wrong")
    except Exception as error:
        print(size, repr(error), file=sys.stderr)
        outcomes.append("raw")
    subprocess.run(["mount", "-o", "remount,size=100M", folder], check=True)
    try:
        if is_unfinished(path) or path.is_file():
            check_resumed(path, whole)
        else:
            assert not list(folder.iterdir()), list(folder.iterdir())
    except Exception as error:
        print(size, repr(error), file=sys.stderr)
        outcomes[-1] = "wrong"
    subprocess.run(["umount", folder], check=True)
print(json.dumps(outcomes))
"""


@pytest.mark.slow
def test_full_disks(tmp_path, tell):
    """File systems of 4 kB to 4 MB, in a namespace of mounts of their own."""
    alone = ["unshare", "--map-root-user", "--mount"]
    if sys.platform != "linux" or subprocess.run([*alone, "true"], check=False, capture_output=True).returncode:
        pytest.skip("this system lets nobody mount a file system of their own")
    sizes = [str(round(4 * 1.2**k)) for k in range(39)]
    run = subprocess.run(
        [*alone, sys.executable, "-c", ON_A_DISK, tmp_path, *sizes],
        env={"PYTHONPATH": ":".join([str(SUPPORT), *filter(None, sys.path)]), "PATH": "/usr/bin:/bin:/usr/sbin:/sbin"},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    print(run.stderr)
    outcomes = json.loads(run.stdout)
    tell("full disks", outcomes)
    assert {"answered", "refused"} <= set(outcomes)
