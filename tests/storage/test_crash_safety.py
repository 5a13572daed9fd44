"""Runs that are killed, disks that are full, writers that meet: what is committed survives, and is gone on with."""

import contextlib
import dataclasses
import os
import resource
import shutil
from functools import partial

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.analysis import CaseFinished, CaseStarted, IterationDone, plan
from blockstruct.solvers import ClarabelSolver
from blockstruct.storage import is_unfinished
from killed_runs import cases, check_resumed, wall
from processes import FRESH
from refusals import refused
from structures import SELF_WEIGHT, bonded, model_of, push, settings_of, stopping


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return bs.AnalysisManager(wall(), tmp_path_factory.mktemp("whole") / "wall.h5").run(cases())


@pytest.fixture
def path(tmp_path):
    return tmp_path / "wall.h5"


@pytest.mark.parametrize("at", [*(0, 8, 15), *(pytest.param(at, marks=pytest.mark.slow) for at in (1, 2, 16))])
def test_resume_after_any_iteration(path, whole, at):
    interrupt_after(path, at)
    check_resumed(path, whole)


def interrupt_after(path, at, *, error=RuntimeError, procedure="loading path"):
    """Run the wall and leave it by an error, as if killed, after so many iterations."""
    stop = stopping(IterationDone, nth=at + 1, error=error)
    with contextlib.suppress(RuntimeError):
        bs.AnalysisManager(wall(), path, listeners=[stop], settings=settings_of(procedure=procedure)).run(cases())


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """The folder of a run that was left after eight iterations, to be copied."""
    folder = tmp_path_factory.mktemp("killed")
    interrupt_after(folder / "wall.h5", 8)
    return folder


class Unreliable(ClarabelSolver):
    """Fails at some programs, as solvers do; the first it solves is that of the dead load."""

    def __init__(self, done=0):
        super().__init__()
        self.next = iter([True, *(k not in (2, 5) for k in range(done, 1000))])

    def solve(self, program, numbers, tolerance):
        solution = super().solve(program, numbers, tolerance)
        failed = dataclasses.replace(solution, status=bs.vocabulary.SolverStatus.INFEASIBLE)
        return solution if next(self.next) else failed


@pytest.mark.parametrize(
    ("settings", "solver"),
    [
        pytest.param({"procedure": "shifted"}, ClarabelSolver, marks=pytest.mark.slow),
        ({"crushing": "linearised"}, ClarabelSolver),
        ({"crushing_interaction": "biaxial"}, ClarabelSolver),
        ({"fallback_after": 8, "max_programs": 30}, ClarabelSolver),
        ({}, Unreliable),
    ],
    ids=str,
)
def test_every_procedure_is_replayed(settings, solver, tmp_path, monkeypatch):
    """Whatever the first iterations were, the others follow from them as without the interruption."""
    blocks = bonded(2, 3, material=bs.Material("tuff", "12 kN/m^3"))
    model = model_of(blocks, bs.JointMaterial("soft", 0.65, compressive_strength="60 kPa"))
    case = bs.LimitCase("sideways", SELF_WEIGHT, push(1, 0, 0))
    settings = settings_of(**{"procedure": "fictitious"} | settings)

    def run(path, **options):
        monkeypatch.setattr("blockstruct.solvers.ClarabelSolver", solver)
        with contextlib.suppress(RuntimeError):
            bs.AnalysisManager(model, path, settings=settings, effects=False, **options).run([case])

    run(tmp_path / "whole.h5")
    whole = bs.open_analysis(tmp_path / "whole.h5")["sideways"]
    assert whole.n_iterations > 5
    for at in (1, 3, 6):
        path = tmp_path / f"{at}.h5"
        run(path, listeners=[stopping(IterationDone, nth=at + 1, error=RuntimeError)])
        if solver is Unreliable:
            monkeypatch.setattr("blockstruct.solvers.ClarabelSolver", partial(Unreliable, at))
        again = bs.AnalysisManager.resume(path)["sideways"]
        assert again.status == whole.status
        # To the tolerance of the certificate: forces go through SI units, and the last bit of a force can decide which
        # of many equally good ones a program takes.
        np.testing.assert_allclose(again.load_factor, whole.load_factor, rtol=settings.numerics.gap_tolerance)
        for name in ("stage", "solver_status", "schedule_cohesion"):
            np.testing.assert_array_equal(again.history[name][:at], whole.history[name][:at])
        np.testing.assert_allclose(again.history.contact_force[:at], whole.history.contact_force[:at], atol=1e-9)


def test_resume_solves_nothing_twice(path, monkeypatch):
    interrupt_after(path, 6, procedure="fictitious")
    solved = []
    solve = ClarabelSolver.solve
    monkeypatch.setattr(ClarabelSolver, "solve", lambda *words: solved.append(words) or solve(*words))
    heard = []
    analysis = bs.AnalysisManager.resume(path, listeners=[heard.append])
    # The dead load, which both cases that had not ended share, and what was not solved yet.
    assert len(solved) == 1 + (analysis["sideways"].n_iterations - 6) + analysis["lifted"].n_iterations
    iterations = sum(analysis[name].n_iterations for name in ("sideways", "lifted"))
    assert sum(isinstance(e, IterationDone) for e in heard) == iterations


@pytest.mark.parametrize("error", [pytest.param(RuntimeError, marks=pytest.mark.slow), KeyboardInterrupt])
def test_a_resumed_run_can_be_interrupted_again(path, whole, error):
    interrupt_after(path, 9, error=error)
    with contextlib.suppress(RuntimeError):
        bs.AnalysisManager.resume(path, listeners=[stopping(IterationDone, at=3, error=error)])
    found = bs.recover(path) if is_unfinished(path) else bs.open_analysis(path)
    assert found["sideways"].n_iterations == 9
    check_resumed(path, whole)


def test_what_a_third_version_goes_on_with_is_told(tmp_path, path, monkeypatch):
    made_by = [{**plan.versions(), "blockstruct": name} for name in ("0.0.7", "0.0.8", "0.0.9")]
    stop = stopping(IterationDone, at=6, case="sideways", error=RuntimeError)
    monkeypatch.setattr(plan, "_installed", lambda: made_by[0])
    interrupt_after(path, 4)
    monkeypatch.setattr(plan, "_installed", lambda: made_by[1])
    with pytest.warns(bs.errors.VersionWarning), pytest.raises(RuntimeError):
        bs.AnalysisManager.resume(path, listeners=[stop])
    monkeypatch.setattr(plan, "_installed", lambda: made_by[2])
    recovered = bs.recover(path)
    assert recovered["sideways"].versions == tuple(made_by[:2])
    assert bs.open_analysis(path)["sideways"].versions == tuple(made_by[:2])
    with pytest.warns(bs.errors.VersionWarning):
        bs.AnalysisManager.resume(path)
    stored = bs.open_analysis(path)
    assert stored["upper"].versions == (made_by[0],)
    assert stored["sideways"].versions == tuple(made_by)
    assert (stored["lifted"].versions, stored.versions) == ((made_by[2],), made_by[2])
    rows = bs.Archive(tmp_path).table(all_columns=True).set_index("case")
    assert rows.version.to_dict() == {"upper": "0.0.7", "sideways": "0.0.7, 0.0.8, 0.0.9", "lifted": "0.0.9"}


def test_a_finished_analysis_is_resumed_as_it_is(tmp_path, whole):
    path = bs.save_analysis(whole, tmp_path / "wall.h5")
    before = path.stat()
    assert bs.AnalysisManager.resume(path)["sideways"].load_factor == whole["sideways"].load_factor
    after = path.stat()
    # Reading it may move the time of its last access, and nothing else.
    assert (after.st_ino, after.st_size, after.st_mtime_ns) == (before.st_ino, before.st_size, before.st_mtime_ns)
    with pytest.raises(bs.errors.StorageError, match="no working data"):
        bs.recover(path)
    with pytest.raises(bs.errors.StorageError, match="no such file"):
        bs.AnalysisManager.resume(tmp_path / "other.h5")


def test_a_killed_run_is_not_replaced_unasked(path):
    interrupt_after(path, 3)
    with pytest.raises(bs.errors.StorageError, match=r"wall\.h5\.partial.*killed.*resume.*recover"):
        bs.AnalysisManager(wall(), path).run(cases())
    assert bs.recover(path)["sideways"].n_iterations == 3


def test_iterations_of_another_procedure_are_not_gone_on_with(path):
    interrupt_after(path, 6, error=KeyboardInterrupt, procedure="fictitious")
    stored = bs.open_analysis(path)
    history = stored["sideways"].history
    other = history.assign(schedule_cohesion=history.schedule_cohesion.copy(data=2 * history.schedule_cohesion.values))
    results = {**stored, "sideways": dataclasses.replace(stored["sideways"], history=other)}
    bs.save_analysis(stored.replaced(results=results), path)
    with pytest.raises(bs.errors.FormatError, match=r"iteration 1 of the history.*run the case anew"):
        bs.AnalysisManager.resume(path)


def records(path):
    """The records of a journal, each with its line."""
    return [b"blockstruct record " + part for part in path.read_bytes().split(b"blockstruct record ")[1:]]


def changed(record):
    return record[:900] + b"x" + record[901:]


@pytest.mark.parametrize(
    ("damage", "left"),
    [
        (lambda r: [*r[:5], r[5][: len(r[5]) // 2]], 5),
        pytest.param(lambda r: [*r[:5], r[5][:50], *r[6:]], 5, marks=pytest.mark.slow),
        pytest.param(lambda r: [*r[:5], changed(r[5]), *r[6:]], 5, marks=pytest.mark.slow),
        (lambda r: [*r[:3], r[4], r[3], *r[5:]], 3),
        (lambda r: [*r[:2], *r[3:]], 2),
        pytest.param(lambda r: [r[0], r[1], r[1], *r[2:]], 2, marks=pytest.mark.slow),
        pytest.param(lambda r: [changed(r[0]), *r[1:]], 0, marks=pytest.mark.slow),
        pytest.param(lambda r: r[1:], 0, marks=pytest.mark.slow),
    ],
    ids=["cut", "shortened", "changed", "swapped", "left out", "twice", "first changed", "first left out"],
)
def test_a_damaged_record_ends_what_is_recovered(tmp_path, path, whole, killed, damage, left):
    shutil.copytree(killed, tmp_path, dirs_exist_ok=True)
    journal = tmp_path / "wall.h5.partial" / "1.journal"
    journal.write_bytes(b"".join(damage(records(journal))))
    found = bs.recover(path)["sideways"]
    assert found.n_iterations == left
    assert f"in record {left}, which is left out with all after it" in found.damage
    check_resumed(path, whole)


def test_an_edited_ending_is_not_taken_over(tmp_path, path, whole, killed):
    """As by who changes the status of a case that has ended: its case counts as interrupted."""
    shutil.copytree(killed, tmp_path, dirs_exist_ok=True)
    journal = tmp_path / "wall.h5.partial" / "0.journal"
    journal.write_bytes(journal.read_bytes().replace(b'"status": "converged"', b'"status": "unbounded"'))
    found = bs.recover(path)["upper"]
    assert found.status == "interrupted"
    assert "0.journal does not match its checksum" in found.damage
    check_resumed(path, whole)


def test_journals_of_another_run_are_not_taken_over(tmp_path, whole):
    for name in ("wall", "other"):
        (tmp_path / name).mkdir()
        interrupt_after(tmp_path / name / "wall.h5", 8)
    for name in ("0.journal", "1.journal"):
        shutil.copy(tmp_path / "other" / "wall.h5.partial" / name, tmp_path / "wall" / "wall.h5.partial" / name)
    assert [r.n_iterations for r in bs.recover(tmp_path / "wall" / "wall.h5").values()] == [0, 0, 0]


def test_the_second_writer_is_refused(tmp_path, path, whole):
    met = []

    def meet(event):
        if isinstance(event, CaseFinished) and not met:
            for write in (
                lambda: bs.AnalysisManager(wall(), path).run(cases()),
                lambda: bs.save_analysis(whole, path),
                lambda: bs.AnalysisManager.resume(path),
                lambda: bs.recover(path),
            ):
                with refused(bs.errors.StorageError, f"is being written by process {os.getpid()} on since"):
                    write()
                met.append(write)

    bs.AnalysisManager(wall(), path, listeners=[meet]).run(cases())
    assert len(met) == 4
    bs.save_analysis(whole, path)
    assert [p.name for p in tmp_path.iterdir()] == ["wall.h5"]


def test_a_lock_that_is_a_link_to_nowhere_is_named(tmp_path, path):
    (tmp_path / "wall.h5.partial").mkdir()
    (tmp_path / "wall.h5.partial" / "lock").symlink_to(tmp_path / "nowhere" / "lock")
    with pytest.raises(bs.errors.StorageError, match=r"lock: cannot be made .*; remove it, or choose another name"):
        bs.AnalysisManager(wall(), path).run(cases())


def test_a_run_that_kept_nothing_is_not_to_be_resumed(tmp_path, path):
    """As a full disk leaves it, or a kill before the plan is written."""
    (tmp_path / "wall.h5.partial").mkdir()
    (tmp_path / "wall.h5.partial" / "plan.draft").write_bytes(bytes(100))
    for read in (bs.open_analysis, bs.recover, bs.AnalysisManager.resume):
        with pytest.raises(bs.errors.StorageError, match="ended before it kept anything; wait, or run it again"):
            read(path)
    assert bs.AnalysisManager(wall(), path).run(cases()).status == "finished"
    assert [p.name for p in tmp_path.iterdir()] == ["wall.h5"]


def test_a_reader_sees_the_old_file_during_a_run(tmp_path, whole):
    path = bs.save_analysis(whole, tmp_path / "wall.h5")
    seen = []

    def read(event):
        if isinstance(event, CaseStarted):
            seen.append(bs.open_analysis(path).created_at)

    new = bs.AnalysisManager(wall(), path, listeners=[read]).run(cases())
    assert seen == [whole.created_at] * 3
    assert bs.open_analysis(path).created_at == new.created_at


def run_on_a_full_disk(path, limit, report):
    """Run the wall where no file may grow beyond a limit; tell the message."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    try:
        bs.AnalysisManager(wall(), path).run(cases())
    except bs.errors.StorageError as error:
        report.send(str(error))
    report.close()


@pytest.mark.parametrize("share", [0.0, 0.9])
def test_a_full_disk(tmp_path, path, whole, share):
    """The plan, a journal or the finished file does not fit: one message, and what was committed is kept."""
    size = bs.save_analysis(whole, path).stat().st_size
    path.unlink()
    here, there = FRESH.Pipe(duplex=False)
    process = FRESH.Process(target=run_on_a_full_disk, args=(path, int(share * size), there))
    process.start()
    there.close()
    message = here.recv()
    process.join()
    assert process.exitcode == 0
    assert "free some space" in message
    if share:
        check_resumed(path, whole)
    else:
        assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("at", [IterationDone, CaseFinished])
def test_a_folder_that_is_moved_during_a_run(tmp_path, whole, at):
    """No space is short: what is committed is in the folder wherever it is."""
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()

    def move(event):
        case = event.result if isinstance(event, CaseFinished) else event.case
        if isinstance(event, at) and case.name == "sideways" and here.exists():
            here.rename(there)

    with pytest.raises(bs.errors.StorageError, match=r"its folder was moved or removed; move it back.*resume") as error:
        bs.AnalysisManager(wall(), here / "wall.h5", listeners=[move]).run(cases())
    assert "space" not in str(error.value)
    check_resumed(there / "wall.h5", whole)
