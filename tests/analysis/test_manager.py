"""Runs of cases, and settlements among them."""

import io
import json
import sys

import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import CaseFinished, CaseStarted, IterationDone
from refusals import refused
from structures import SELF_WEIGHT, beam_on_ledges, box, model_of, push, single_block, stopping


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


CASES = (
    bs.SettlementCase("left goes down", SELF_WEIGHT, ["left"], "-z"),
    bs.SettlementCase("left turns", SELF_WEIGHT, ["left"], (0, -0.96, 0.28), about="[1, 0, 0] m", flow="associative"),
    bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative"),
)


@pytest.fixture(scope="module")
def model():
    return beam_on_ledges(box("aside", [9, 0, -0.3], [0.5, 1, 0.3], fixed=True))


@pytest.fixture(scope="module")
def stored(model, tmp_path_factory):
    folder = tmp_path_factory.mktemp("settlement")
    return bs.run(model, CASES, folder / "beam.h5"), folder


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"supports": ["middle"]}, bs.errors.UnknownNameError, "'middle' left, right, aside"),
        ({"supports": ["left", "beam"]}, bs.errors.ModelError, "'beam' is free left, right, aside"),
        ({"supports": ["aside"]}, bs.errors.ModelError, "aside nothing is held"),
        ({"supports": []}, bs.errors.ModelError, "no support"),
        ({"supports": ["left", "left"]}, bs.errors.ModelError, "repeat"),
        ({"direction": (0, 0, -2)}, bs.errors.ModelError, "length 2"),
        ({"direction": Q_([0, 0, -1], "m")}, bs.errors.DimensionError, "direction"),
        ({"about": (0, 0, 0)}, bs.errors.UnitError, "about"),
        ({"dead": bs.LoadPattern("nothing", [])}, bs.errors.ModelError, "'nothing' zero"),
    ],
)
def test_bad_input(model, arguments, error, words):
    given = {"dead": SELF_WEIGHT, "supports": ["left"], "direction": "-z"} | arguments
    with refused(error, words):
        bs.run(model, bs.SettlementCase("case", **given))


#: A tie from the beam to a support that nothing stands on.
TIE = bs.Tie("tie", ("aside", "[9, 0.5, 0] m"), ("beam", "[4, 0.5, 0] m"), yield_force="50 kN")


def test_the_anchor_of_a_tie_settles_too(model):
    """It moves away and pulls the beam, which slides."""
    case = bs.SettlementCase("anchor", SELF_WEIGHT, ["aside"], "+x")
    result = bs.run(model.with_ties([TIE]), case, settings=bs.ProcedureSettings(procedure="fictitious"))["anchor"]
    assert result.reaction.m_as("kN") == pytest.approx(-0.6 * 48, rel=1e-5)
    assert result.ties["force [newton]"].item() == pytest.approx(0.6 * 48e3, rel=1e-5)
    with pytest.raises(bs.errors.ModelError, match="no tie pulls along"):
        bs.run(model.with_ties([TIE]), bs.SettlementCase("across", SELF_WEIGHT, ["aside"], "+y"))


def test_what_stands_on_the_support_that_moves_goes_with_it():
    """Nothing resists, and the reaction is the weight on the whole path."""
    blocks, joint = single_block(0.8, 2.0)
    result = bs.run(model_of(blocks, joint), bs.SettlementCase("sinks", SELF_WEIGHT, ["ground"], "-z"))["sinks"]
    assert result.reaction.m_as("kN") == pytest.approx(0.8 * 2.0 * 20, rel=1e-6)
    assert (result.outcome.path_end, result.settled) == ("closed", True)


@pytest.mark.parametrize("spread", [3, None, ["steep", 3]])
def test_a_spread_of_no_schedules_is_refused(model, spread):
    with pytest.raises(bs.errors.ModelError, match=r"spread: .* give a list"):
        bs.run(model, CASES[0], spread=spread)


def test_files_and_documents_keep_settlements(stored, model):
    analysis, folder = stored
    for name in ("beam.yaml", "beam.json"):
        assert bs.read_document(bs.write_document(folder / name, model, CASES)).cases == CASES
    for name in ("reaction", "reaction_range"):
        with pytest.raises(bs.errors.ModelError, match="'push': has a load factor and no reaction"):
            getattr(analysis["push"], name)
    read = bs.open_analysis(folder / "beam.h5")
    assert read.cases == CASES
    for case in CASES:
        assert read[case.name].history.identical(analysis[case.name].history)
    result = read["left goes down"]
    assert result.reaction == analysis["left goes down"].reaction
    assert result.history["reaction"].attrs["units"] == "newton"
    assert result.history["reaction"].to_numpy()[-1] == result.reaction.magnitude
    assert read["left turns"].history["reaction"].attrs["units"] == "newton * meter"
    assert "reaction" not in read["push"].history
    assert bs.results.contradictions(read) == []
    bs.check_file(folder / "beam.h5")
    assert bs.reproduce(read).agrees()


def test_archives_have_a_column_for_reactions(stored):
    analysis, folder = stored
    archive = bs.Archive(folder)
    table = archive.table().set_index("case")
    assert table.loc["left goes down", "reaction"] == analysis["left goes down"].reaction.magnitude
    assert table.loc["left turns", "reaction_moment"] == analysis["left turns"].reaction.magnitude
    assert table.attrs["units"]["reaction"] == "newton"
    # A reaction is not a load factor, and never passes for one.
    assert table["load_factor"].notna().to_list() == [case.name == "push" for case in CASES]
    assert archive.select("load_factor < 0.6 or load_factor > 0")["case"].to_list() == ["push"]
    assert archive.select("reaction > 20000")["case"].to_list() == ["left goes down"]


def test_comparisons_compare_reactions(stored, model, tmp_path):
    analysis, folder = stored
    heavier = bs.LoadPattern("dead", [bs.SelfWeight(), bs.BodyForce("-z", share=0.1)])
    cases = [bs.SettlementCase(c.name, heavier, c.supports, c.direction, flow=c.flow) for c in CASES[:1]]
    other = bs.run(model, cases, tmp_path / "beam.h5")
    found = bs.results.compare(analysis, other).cases.loc["left goes down"]
    assert found["load_factor"] == analysis["left goes down"].reaction.magnitude
    assert found["relative_difference"] == pytest.approx(0.1, rel=1e-5)
    tables = bs.Archive(folder).difference(bs.Archive(tmp_path)).xs("left goes down", level="case")
    assert tables["relative_difference"].item() == pytest.approx(0.1, rel=1e-5)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"kind": "settlment"}, "/cases/0/kind settlement"),
        ({"variable": "push"}, "/cases/0 variable"),
        ({"about": [0, 0, 0]}, "/cases/0/about"),
        ({"suports": ["left"]}, "suports did you mean supports"),
    ],
)
def test_documents_that_are_no_settlement(model, tmp_path, entry, words):
    bs.write_document(tmp_path / "beam.json", model, CASES[:1])
    content = json.loads((tmp_path / "beam.json").read_text(encoding="utf-8"))
    content["cases"][0] |= entry
    (tmp_path / "bad.json").write_text(json.dumps(content), encoding="utf-8")
    with refused(bs.errors.DocumentError, words):
        bs.read_document(tmp_path / "bad.json")


def test_a_killed_settlement_goes_on(model, tmp_path):
    kill = stopping(bs.analysis.IterationDone, at=3, error=RuntimeError)
    manager = bs.AnalysisManager(model, tmp_path / "beam.h5", listeners=[kill])
    with pytest.raises(RuntimeError):
        manager.run(CASES[:1])
    again = bs.AnalysisManager.resume(tmp_path / "beam.h5")["left goes down"]
    whole = bs.run(model, CASES[0])["left goes down"]
    assert again.reaction.magnitude == pytest.approx(whole.reaction.magnitude, rel=1e-9)
    assert again.history["stage"].to_numpy().tolist() == whole.history["stage"].to_numpy().tolist()
