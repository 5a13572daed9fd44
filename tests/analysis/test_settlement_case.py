"""Settlement cases as users give, keep and read them."""

import json

import pytest

import blockstruct as bs
from blockstruct import Q_
from refusals import refused
from structures import SELF_WEIGHT, beam_on_ledges, box, model_of, push, single_block, stopping

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
