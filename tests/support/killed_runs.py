"""Runs of a small wall that are killed at any moment, and what must be left of them."""

import contextlib
import time

import pytest

import blockstruct as bs
from blockstruct.analysis import IterationDone
from blockstruct.storage import is_unfinished
from processes import FRESH
from structures import SELF_WEIGHT, bonded, model_of, push


def wall() -> bs.Model:
    return model_of(bonded(3, 4), bs.JointMaterial("dry", 0.65))


def cases() -> list[bs.LimitCase]:
    return [
        bs.LimitCase("upper", SELF_WEIGHT, push(1, 0, 0), "associative"),
        bs.LimitCase("sideways", SELF_WEIGHT, push(1, 0, 0)),
        bs.LimitCase("lifted", SELF_WEIGHT, bs.LoadPattern("down", [bs.BodyForce((0, 0, -1))])),
    ]


def run(path, report):
    """Run the wall; tell of every event after it is committed."""
    manager = bs.AnalysisManager(wall(), path, listeners=[teller(report)])
    report.send("begun")
    manager.run(cases())
    report.send("finished")


def resume(path, report):
    """Go on with a killed run of the wall; its replayed iterations are told of, too."""
    report.send("begun")
    bs.AnalysisManager.resume(path, listeners=[teller(report)])
    report.send("finished")


def recover(path, report):
    """Keep what a killed run has found."""
    report.send("begun")
    bs.recover(path)
    report.send("finished")


def teller(report):
    def tell(event):
        match event:
            case IterationDone(case):
                report.send(case.name)
        time.sleep(0.005)

    return tell


def killed(job, path, seconds, *words):
    """Do a job in a process of its own, kill it so long after it has begun, and give what it has told."""
    here, there = FRESH.Pipe(duplex=False)
    process = FRESH.Process(target=job, args=(path, there, *words))
    process.start()
    there.close()
    told = [here.recv()]
    process.join(seconds)
    process.kill()
    process.join()
    with contextlib.suppress(EOFError):
        while here.poll():
            told.append(here.recv())
    return told


def timeless(result):
    return result.history.drop_vars("solver_time")


def check_survivors(path, told, whole):
    """What a killed run has left: every iteration that it told of, as it would be without the kill."""
    if not is_unfinished(path) and not path.is_file():
        assert told == ["begun"]
        return
    assert path.is_file() or "finished" not in told
    found = bs.recover(path) if is_unfinished(path) else bs.open_analysis(path)
    assert list(found) == list(whole)
    for name, result in found.items():
        n = result.n_iterations
        assert told.count(name) <= n <= whole[name].n_iterations
        expected = whole[name].history.isel(iteration=slice(n)).drop_vars("solver_time")
        assert timeless(result).identical(expected)
        if result.status == "interrupted":
            # A program without a solution, as the unbounded one of the load down, has no certificate.
            assert (result.certificate is None) == (n == 0 or bool(result.history["flow_rule_gap"][-1].isnull()))
        else:
            assert str(result.outcome) == str(whole[name].outcome)
    assert bs.open_analysis(path).status == found.status
    assert not is_unfinished(path)


def check_resumed(path, whole):
    again = bs.AnalysisManager.resume(path)
    assert again.status == "finished"
    for name, result in again.items():
        assert result.status == whole[name].status
        assert result.n_iterations == whole[name].n_iterations
        assert result.load_factor == pytest.approx(whole[name].load_factor, rel=1e-6)
    assert [p.name for p in path.parent.iterdir()] == [path.name]
    assert bs.open_analysis(path).status == "finished"
