"""Processes that are killed at random or write at once: what they had committed is there, and resumed runs end alike.

Under ``slow`` there are 200 kills; a few run by default.
"""

import contextlib
import random
import shutil
import time

import numpy as np
import pytest

import blockstruct as bs
import studied
from blockstruct import Q_
from blockstruct.analysis import IterationDone, StateDone, StepDone
from blockstruct.storage import is_unfinished
from killed_runs import cases, check_resumed, check_survivors, killed, recover, resume, run, wall
from processes import FRESH
from properties import slow_after
from structures import SELF_WEIGHT, block_on_a_bar, model_of, push, single_block, stopping
from trials import outcome

#: Seconds in which what a kill has left is gone on with.
LONGEST = 60
MU = {"friction_coefficient": [0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.6, 0.7]}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The wall without a kill, and the rest of a run that was stopped after twelve iterations."""
    folder, stop = tmp_path_factory.mktemp("whole"), stopping(IterationDone, nth=12, error=RuntimeError)
    with contextlib.suppress(RuntimeError):
        bs.AnalysisManager(wall(), folder / "stopped" / "wall.h5", listeners=[stop]).run(cases())
    return bs.AnalysisManager(wall(), folder / "wall.h5").run(cases()), folder / "stopped"


def kill(tell, what, folder, kills, trial):
    """Count how trials of kills ended."""
    outcomes = []
    for k in range(kills):
        place = folder / f"{k}"
        place.mkdir()
        how, said = outcome(lambda k=k, place=place: trial(random.Random(k), place), LONGEST)
        if how != "answered":
            print(f"{what} {k}: {how} {said}")
        # What a kill has left is never refused.
        outcomes.append({"answered": "resumed", "refused": "wrong"}.get(how, how))
        shutil.rmtree(place, ignore_errors=True)
    tell(f"kills: {what}", outcomes)


def some(few, many):
    return pytest.mark.parametrize("kills", slow_after(few, many))


@some(4, 70)
def test_of_runs(tmp_path, tell, whole, kills):
    def trial(chance, folder):
        path = folder / "wall.h5"
        told = killed(run, path, chance.uniform(0.0, 0.9))
        if chance.random() < 0.5:
            check_survivors(path, told, whole[0])
        if path.is_file() or is_unfinished(path):
            check_resumed(path, whole[0])

    kill(tell, "run", tmp_path, kills, trial)


@pytest.mark.parametrize("job", [resume, recover], ids=lambda job: job.__name__)
@some(2, 35)
def test_of_what_goes_on(tmp_path, tell, whole, kills, job):
    def trial(chance, folder):
        path = folder / "run" / "wall.h5"
        shutil.copytree(whole[1], path.parent)
        killed(job, path, chance.uniform(0.0, 0.5 if job is resume else 0.1))
        check_resumed(path, whole[0])

    kill(tell, job.__name__, tmp_path, kills, trial)


def pushover():
    """A block that slides, and its pushover."""
    model = model_of(*single_block(0.5, 1.0))
    return model, bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=20)


def record():
    """A block that breaks its bar and rocks under a pulse."""
    pulse = Q_(np.repeat([-0.8, 0.0], [4, 8]), "g_0")
    case = bs.RecordCase("shaken", SELF_WEIGHT, pulse, "0.05 s", "+x", interval="25 ms")
    return block_on_a_bar("10 mm"), case


def moved(path, report, motion):
    def tell(event):
        if isinstance(event, StepDone | StateDone):
            report.send(event.index)

    model, case = motion()
    manager = bs.AnalysisManager(model, path, listeners=[tell])
    report.send("begun")
    manager.run([case])


@pytest.mark.parametrize(("motion", "states", "dim"), [(pushover, "capacity", "step"), (record, "response", "time")])
@some(2, 30)
def test_of_motions(tmp_path, tell, kills, motion, states, dim):
    model, case = motion()
    expected = getattr(bs.run(model, case)[case.name], states).drop_vars("solver_time", errors="ignore")

    def trial(chance, folder):
        path = folder / "run.h5"
        _, *told = killed(moved, path, chance.uniform(0.0, 1.5), motion)
        if not (path.is_file() or is_unfinished(path)):
            assert not told
            return
        if is_unfinished(path) and told:
            kept = bs.open_analysis(path) if path.is_file() else bs.recover(path)
            assert getattr(kept[case.name], states).sizes[dim] >= len(told)
        found = getattr(bs.AnalysisManager.resume(path)[case.name], states)
        for name, values in expected.variables.items():
            np.testing.assert_array_equal(found[name], values, name)

    kill(tell, motion.__name__, tmp_path, kills, trial)


def study(path, report, options):
    report.send("begun")
    bs.study(studied.block, MU, path, **options)


def check_study(folder, options):
    """What a killed study has finished is found, and called again it ends."""
    finished = len(list(folder.glob("*.h5")))
    for _ in range(20):
        seen = []
        data = bs.study(studied.block, MU, folder, listeners=[seen.append], **options)
        assert seen[0].found >= finished
        if not data.elsewhere.any():
            break
        # A worker of the killed study lives until it notices.
        time.sleep(0.5)
    expected = np.minimum(MU["friction_coefficient"], 0.5)
    np.testing.assert_allclose(data.load_factor.to_numpy().ravel(), expected, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::blockstruct.errors.StudyWarning")
def test_of_studies_in_processes(tmp_path, tell):
    def trial(chance, folder):
        killed(study, folder / "store", chance.uniform(0.0, 3.0), {"workers": 2})
        check_study(folder / "store", {"workers": 2})

    kill(tell, "study in processes", tmp_path, 15, trial)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::blockstruct.errors.StudyWarning")
def test_of_studies_on_dask(tmp_path, tell):
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", memory_limit="2 GB") as cluster:
        options = {"cluster": cluster.scheduler_address}

        def trial(chance, folder):
            killed(study, folder / "store", chance.uniform(0.0, 3.0), options)
            check_study(folder / "store", options)

        kill(tell, "study on Dask", tmp_path, 15, trial)


def rewrite(path, times, start):
    start.wait()
    for _ in range(times):
        try:
            bs.save_analysis(bs.open_analysis(path), path)
        except bs.errors.BusyError:
            continue


@pytest.mark.parametrize("times", slow_after(2, 40))
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
        how, said = outcome(read, LONGEST)
        if how != "answered":
            print(said)
        outcomes.append({"answered": "identical", "refused": "wrong"}.get(how, how))
    tell("reads next to writers", outcomes)
    assert outcomes
    assert [w.exitcode for w in writers] == [0, 0, 0]
    assert [p.name for p in tmp_path.iterdir()] == ["wall.h5"]
