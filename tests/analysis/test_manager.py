"""The analysis manager: cases, listeners, interruption."""

import io
import sys

import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import CaseFinished, CaseStarted, IterationDone
from structures import SELF_WEIGHT, box, model_of, push, stopping


def test_events_come_in_order(small_model, small_cases):
    events = []
    analysis = bs.AnalysisManager(small_model, listeners=[events.append]).run(small_cases)
    kinds = [type(e) for e in events]
    assert kinds[:3] == [CaseStarted, IterationDone, CaseFinished]
    assert kinds.count(IterationDone) == sum(r.n_iterations for r in analysis.values())
    assert [e.index for e in events if isinstance(e, IterationDone)][1:4] == [0, 1, 2]
    assert [(e.number, e.count) for e in events if isinstance(e, CaseStarted)] == [(1, 2), (2, 2)]


def test_lines_of_a_run(small_model, small_cases, capsys):
    bs.AnalysisManager(small_model, listeners=[bs.analysis.print_lines()]).run(small_cases[:1])
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(":")[0] for line in lines] == [small_cases[0].name] * 3


def test_interruption_keeps_what_is_done(small_model, small_cases, tmp_path):
    path = tmp_path / "cut.h5"
    stop = stopping(IterationDone, at=4, case=small_cases[1].name)
    cases = [*small_cases, bs.LimitCase("never", small_cases[0].dead, bs.LoadPattern("+y", [bs.BodyForce((0, 1, 0))]))]
    analysis = bs.AnalysisManager(small_model, path, listeners=[stop]).run(cases)
    assert [r.status for r in analysis.values()] == ["converged", "interrupted", "interrupted"]
    assert analysis["never"].n_iterations == 0
    assert analysis[small_cases[1].name].n_iterations == 5
    assert analysis.status == "interrupted"
    again = bs.open_analysis(path)
    assert again.status == "interrupted"
    assert again[small_cases[1].name].history.identical(analysis[small_cases[1].name].history)


def test_a_run_repeats_itself(small_model, small_cases, small_analysis):
    again = bs.AnalysisManager(small_model).run(small_cases)
    for name, result in small_analysis.items():
        timeless = [r.history.drop_vars("solver_time") for r in (result, again[name])]
        assert timeless[0].identical(timeless[1])


def test_an_analysis_reads_like_a_dictionary(small_analysis, small_cases):
    assert list(small_analysis) == [c.name for c in small_cases]
    assert small_analysis.cases == tuple(small_cases)
    assert small_analysis.versions["clarabel"].count(".") == 2
    with pytest.raises(TypeError):
        small_analysis.results["x"] = 1


@pytest.mark.parametrize("moment", [CaseStarted, CaseFinished])
def test_interruption_between_programs_keeps_finished_cases(small_model, small_cases, tmp_path, moment):
    path = tmp_path / "cut.h5"
    bs.AnalysisManager(small_model, path, listeners=[stopping(moment, nth=2)]).run(small_cases)
    again = bs.open_analysis(path)
    assert again[small_cases[0].name].status == "converged"
    if moment is CaseStarted:
        cut = again[small_cases[1].name]
        assert (cut.status, cut.n_iterations, cut.certificate) == ("interrupted", 0, None)
        assert cut.states.sizes["iteration"] == 0


@pytest.mark.filterwarnings("ignore::blockstruct.errors.UnusualValueWarning")
@pytest.mark.parametrize("weights", [(0.00002, 20), (20, 0.00002, 20)], ids=["under dead load", "pushed"])
def test_a_light_plate_between_heavy_blocks_is_told_and_one_without_weight_is_solved(weights):
    """Blocks of 1.0, 1.2 and 1.4 m by 1 m on each other turn over about the foot of the lowest, 0.5 m aside.

    A block of 24 kN/m over a plate 1 m high: 0.5·24 / (1.5·24) = 1/3; blocks of 20 and 28 kN/m with one between:
    0.5·(20 + 28) / (0.5·20 + 2.5·28) = 0.3.
    """

    def pushed(densities):
        blocks = [box("base", [-3, -3, -1], [6, 6, 1], fixed=True)]
        for i, density in enumerate(densities):
            origin, size = Q_((-0.5 - 0.1 * i, -0.5, i), "m"), Q_((1 + 0.2 * i, 1, 1), "m")
            blocks.append(bs.Block.box(f"b{i}", origin, size, bs.Material(f"of {i}", Q_(density, "kN/m^3"))))
        model = model_of(blocks, bs.JointMaterial("dry", 0.6))
        return bs.run(model, bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative"))["push"]

    light = pushed(weights)
    assert light.status is bs.Status.NOT_CONVERGED
    assert light.outcome.load_ratio == pytest.approx(1.2e6, rel=0.05)
    assert "no weight" in light.message
    by_hand = 1 / 3 if len(weights) == 2 else 0.3
    assert pushed([w if w > 1 else 0.0 for w in weights]).load_factor == pytest.approx(by_hand, rel=1e-6)


class Terminal(io.StringIO):
    def isatty(self):
        return True


def on_terminal(monkeypatch):
    """Make standard output and standard error a terminal, whose text is returned."""
    screen = Terminal()
    monkeypatch.setattr(sys, "stdout", screen)
    monkeypatch.setattr(sys, "stderr", screen)
    return screen


def test_a_terminal_shows_which_case_is_run(small_model, small_cases, monkeypatch):
    terminal = on_terminal(monkeypatch)
    bs.run(small_model, small_cases)
    shown = terminal.getvalue().split("\r")
    assert shown[1].startswith("case 1 of 2, push associative: 8 blocks")
    assert any(line.startswith("case 2 of 2, push nonassociative: numerical iteration 3, ") for line in shown)
    # What is over leaves an empty line behind.
    assert shown[-2].strip() == shown[-1] == ""


@pytest.mark.parametrize("given", [{"progress": False}, {"listeners": [lambda event: None]}])
def test_nothing_is_shown_where_it_is_not_wanted(small_model, small_cases, monkeypatch, given):
    terminal = on_terminal(monkeypatch)
    bs.run(small_model, small_cases[:1], **given)
    assert terminal.getvalue() == ""
    with pytest.raises(bs.errors.ModelError, match="progress is 'always'; give True, False or 'auto'"):
        bs.AnalysisManager(small_model, progress="always")


def test_a_notebook_has_one_output_that_is_replaced(small_model, small_cases, monkeypatch):
    shown = []

    class Handle:
        def update(self, content, *, raw):
            shown[-1] = content["text/plain"]

    class Kernel:
        kernel = object()

    class IPython:
        get_ipython = Kernel

        class display:  # noqa: N801 - the name of the module
            @staticmethod
            def display(content, *, raw, display_id):
                shown.append(content["text/plain"])
                return Handle()

    monkeypatch.setitem(sys.modules, "IPython", IPython)
    analysis = bs.run(small_model, small_cases)
    count = analysis["push nonassociative"].n_iterations
    assert shown == [f"case 2 of 2, push nonassociative: converged after {count} numerical iterations"]
