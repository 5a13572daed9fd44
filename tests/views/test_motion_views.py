"""Pushovers and settlements in figure, page, ParaView, report and words."""

import dataclasses
import html
import json
import re
from xml.etree import ElementTree

import attrs
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from rich.console import Console
from test_page import coordinates, opened, slide, unpacked

import blockstruct as bs
from blockstruct import Q_
from blockstruct.text import report
from blockstruct.views import figures
from blockstruct.views.console import analysis_summary, archive_table, iteration_table, result_text
from blockstruct.views.page import write_page
from blockstruct.views.page.html import payload
from blockstruct.views.paraview import write_paraview
from blockstruct.views.report import report_html
from blockstruct.views.report.contents import contents
from blockstruct.views.report.summary import curve_sentences
from blockstruct.views.words import pushover_words
from refusals import refused
from structures import SELF_WEIGHT, beam_on_ledges, block_on_a_bar, box, model_of, push

pv = pytest.importorskip("pyvista")


def tie(name, z, **limit):
    ends = ("post", Q_([-2, 0.5, z], "m")), ("block", Q_([0, 0.5, z], "m"))
    return bs.Tie(name, *ends, yield_force="2 kN", **limit)


@pytest.fixture(scope="module")
def analysis():
    model = block_on_a_bar().with_ties([tie("high", 1.5, elongation_limit="60 mm"), tie("low", 0.5)])
    pushed = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=10)
    return bs.run(model, [pushed, bs.LimitCase("plain", SELF_WEIGHT, push(1, 0, 0))])


@pytest.fixture(scope="module")
def result(analysis):
    return analysis["push"]


@pytest.fixture(scope="module")
def last(result):
    return result.capacity.sizes["step"] - 1


def test_the_force_of_a_tie_is_lost_at_its_break(analysis, result):
    """α falls between two states on both sides of the break, and then follows the slope of the states after it."""
    at, before, after = result.broken_ties[["displacement [meter]", "load factor before", "load factor after"]].iloc[0]
    d, alpha = (result.capacity[name].to_numpy() for name in ("displacement", "load_factor"))
    k = int(np.searchsorted(d, at)) - 1
    assert tuple(alpha[k : k + 2]) == (before, after)
    assert d[k] <= at <= d[k + 1] < d[k] + 3e-3 * (d[k] - d[k - 1])
    slope = np.diff(alpha[k + 1 :]) / np.diff(d[k + 1 :])
    assert 0 > slope[0] == pytest.approx(slope[1], rel=0.1)
    assert f"falls from {before:.4g} to {after:.4g}" in bs.results.breaking_words(result.capacity)[0]
    ax = figures.capacity(result, label="block")
    assert ax.get_xlabel() == "displacement of block [m]"
    np.testing.assert_allclose(ax.lines[0].get_xydata(), np.column_stack([d, alpha]))
    assert [text.get_text() for text in ax.texts] == [f"d0 = {result.capacity['d0'].item():.4g} m", "high breaks"]
    assert any(np.allclose(line.get_xdata(), at) for line in ax.lines if line.get_linestyle() == ":")
    shown = {name: {d.name for d in figures.drawings(analysis[name])} for name in ("push", "plain")}
    assert shown["push"] - shown["plain"] == {"capacity"}


def test_a_case_without_a_curve_says_why(analysis, tmp_path, fails):
    with refused(bs.errors.ModelError, "'plain' Pushover"):
        figures.capacity(analysis["plain"])
    with refused(bs.errors.ModelError, "NoneType result.capacity"):
        bs.results.capacity_frame(analysis["plain"].capacity)
    case = attrs.evolve(analysis["push"].case, control=("block", (0, 1, 0)))
    found = bs.AnalysisManager(analysis.model, tmp_path / "rests.h5").run([case])
    with refused(bs.errors.ModelError, "+y 'block'"):
        figures.capacity(found["push"])
    fails("--pushover: case 'push': ", "history", tmp_path / "rests.h5", "push", "--pushover")
    assert found["push"].missing_curve in result_text(found["push"]).plain


def test_the_page_has_every_step(analysis, result, last):
    pushed, plain = payload(analysis)["cases"]
    assert "motion" not in plain
    curve, data = result.capacity, pushed["motion"]
    assert data["along"] == (1e3 * curve["displacement"]).to_numpy().tolist()
    assert data["values"] == curve["load_factor"].to_numpy().tolist()
    motion = unpacked(data["places"], "<f4", last + 1, 3, 12)
    # The block has turned about its edge (0.5, y, 0).
    R, c = motion[-1, 2, :9].reshape(3, 3), motion[-1, 2, 9:]
    np.testing.assert_allclose(c + R @ [0.25, 0, -1], [0.5, 0.5, 0], atol=1e-4)
    # Ties stretch a little before the first state.
    assert data["tie"][0] == [("yielding", pytest.approx(2e3), pytest.approx(0.0, abs=1e-5))] * 2
    (state, force, longer), (held, *_) = data["tie"][-1]
    assert (state, force, held) == ("broken", 0.0, "yielding")
    assert longer == curve["tie_elongation"][-1, 0].item() > 0.06


@pytest.mark.slow
def test_the_page_plays_a_record(browser, tmp_path):
    """A block that turns over is shown as it lies, and where it was; a page may have no other case."""
    blocks = [box("ground", [-2, 0, -1], [4, 1, 1], fixed=True), box("block", [0, 0, 0], [0.3, 1, 1.5])]
    model = model_of(blocks, bs.JointMaterial("joint", 0.6))
    case = bs.RecordCase("shock", SELF_WEIGHT, Q_([0, 1, 0], "g_0"), "0.3 s", "+x")
    analysis = bs.run(model, case, progress=False)
    result = analysis["shock"]
    with opened(browser, write_page(analysis, tmp_path / "page.html")) as page:
        assert page.inner_text("#load-factor") == f"{result.collapse_time:.4g} s"
        assert not page.is_visible("#play")
        still = np.concatenate([b.shape.vertices for b in model.blocks])[8:].mean(axis=0)
        for state in (-1, 0):
            states = result.response.sizes["time"]
            slide(page, "step", state % states)
            moved = coordinates(page, 1)[8:].mean(axis=0) - still
            displacement = result.response.displacement.isel(time=state).sel(block="block")
            np.testing.assert_allclose(moved, displacement, atol=1e-5)


@pytest.mark.slow
def test_the_page_shows_a_step(browser, analysis, last, tmp_path):
    with opened(browser, write_page(analysis, tmp_path / "page.html")) as page:
        slide(page, "step", last)
        assert page.locator("#step-value").text_content().startswith(f"{last} of {last}, ")
        high, low = (
            [cell.text_content() for cell in row.locator("td").all()] for row in page.locator("#ties tr").all()
        )
        assert (high[:3], low[:3]) == (["high", "broken", "0 N"], ["low", "yielding", "2 kN"])
        # Two ends of the tie that is left, and the gap after it.
        assert coordinates(page, 8).shape == (3, 3)


def test_paraview(analysis, result, last, tmp_path):
    write_paraview(result, tmp_path / "push.pvd")
    listed = ElementTree.parse(tmp_path / "push-pushover.pvd").findall(".//DataSet")
    assert [(e.get("timestep"), e.get("name")) for e in listed[-2:]] == [(str(last), "blocks"), (str(last), "ties")]
    assert len(listed) == 2 * (last + 1)
    blocks, ties = (pv.read(tmp_path / e.get("file")) for e in listed[-2:])
    control = blocks.field_data["displacement of the control point [meter]"]
    assert control == pytest.approx(float(result.capacity["displacement"][-1]))
    moved = blocks.points - blocks.point_data["displacement [meter]"]
    np.testing.assert_allclose(moved.max(axis=0), [3, 1, 2], atol=1e-6)
    assert ties.cell_data["broken"].tolist() == [1, 0]
    np.testing.assert_allclose(ties.cell_data["tension [newton]"], [0, 2e3], rtol=1e-4)
    length = np.linalg.norm(np.diff(ties.points.reshape(2, 2, 3), axis=1)[:, 0], axis=1)
    np.testing.assert_allclose(ties.cell_data["elongation [meter]"], length - 2, atol=1e-6)
    write_paraview(analysis["plain"], tmp_path / "push.pvd")
    assert not (tmp_path / "push-pushover.pvd").exists()
    assert not list((tmp_path / "push").glob("pushe*"))


def test_report_console_and_json_list_broken_ties(analysis, result):
    page = contents(analysis.replaced(results={"push": result}), {})
    words = " ".join(page["cases"][0]["pushover"])
    assert f"Tie high breaks at a displacement of {1e3 * result.broken_ties.iloc[0, 0]:.4g} mm, 60 mm longer" in words
    assert all(sentence in result_text(result).plain for sentence in pushover_words(result))
    found = json.loads(json.dumps(analysis_summary(analysis)))["cases"][0]["pushover"]
    assert (found["d0"], found["ended"]) == (result.capacity["d0"].item(), result.curve_ended)
    assert found["states"] == found["certified"] == result.capacity.sizes["step"]
    (broken,) = found["broken_ties"]
    assert (broken["tie"], broken["elongation [meter]"]) == ("high", 0.06)


def test_the_first_page_of_ties_that_break_in_turn(analysis, result):
    """The first break has its numbers, and more breaks are mentioned."""
    (one,) = curve_sentences(analysis, "push", [])
    assert ("tie high breaks" in one, report.MORE_BREAKS in one) == (True, False)
    both = result.model.with_ties([result.model.ties[0], tie("low", 0.5, elongation_limit="40 mm")])
    (two,) = curve_sentences(bs.run(both, result.case), "push", [])
    assert ("tie high breaks" in two, two.endswith(f"; {report.MORE_BREAKS}.")) == (True, True)


mpl.use("Agg")


@pytest.fixture(scope="module")
def settled():
    cases = [
        bs.SettlementCase("goes down", SELF_WEIGHT, ["left"], "-z"),
        bs.SettlementCase("turns", SELF_WEIGHT, ["left"], "-y", about="[4, 0, 0] m", flow="associative"),
        bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative"),
    ]
    return bs.run(beam_on_ledges(), cases, spread="shifted")


@pytest.fixture(scope="module")
def twisted():
    blocks = [box("base", [-1, -1, -0.5], [3, 3, 0.5], fixed=True), box("block", [0, 0, 0], [1, 1, 0.5])]
    twist = bs.LoadPattern("twist", [bs.Moment("block", Q_([0, 0, 1], "kN*m"))])
    return bs.run(model_of(blocks, bs.JointMaterial("joint", 0.6)), bs.LimitCase("twist", SELF_WEIGHT, twist))


def printed(renderable):
    console = Console(width=200)
    with console.capture() as capture:
        console.print(renderable)
    return capture.get()


def test_the_console_shows_reactions(settled, tmp_path):
    text = printed(result_text(settled["goes down"]))
    assert str(settled["goes down"].headline) in text
    assert "Statics allows reactions from 20.57 kN to 27.43 kN under the dead load." in text
    for case, unit in (("goes down", "N"), ("turns", "N·m")):
        assert f"R [{unit}]" in printed(iteration_table(settled[case].history))
    bs.save_analysis(settled, tmp_path / "beam.h5")
    assert re.search(r"goes down .* 20571\.\d N", printed(archive_table(bs.Archive(tmp_path).table())))
    # A spread of reactions is one of forces.
    assert str(settled.spread("goes down")).count("20.57 kN") > 3


def test_json_has_reactions(settled):
    summary = json.loads(json.dumps(analysis_summary(settled), allow_nan=False))
    case = next(c for c in summary["cases"] if c["name"] == "goes down")
    assert (case["load_factor"], case["reaction"]["units"]) == (None, "newton")
    values = [case["reaction"]["value"], case["reaction"]["largest"], summary["headlines"]["goes down"]["reaction"]]
    assert values == pytest.approx([20571.43, 27428.57, 20571.43], rel=1e-5)
    assert "load_factor" not in summary["headlines"]["goes down"]
    assert summary["headlines"]["push"]["load_factor"] == pytest.approx(0.6, rel=1e-6)


def test_report_and_page_show_reactions(settled):
    page = report_html(settled.replaced(results={name: settled[name] for name in ("goes down", "turns")}))
    assert "<strong>Reaction: 20.57 kN.</strong>" in page
    assert "<strong>Reaction: 82.29 kN·m.</strong>" in page
    page = {case["name"]: case for case in payload(settled)["cases"]}
    assert page["goes down"]["answer"] == {"name": "reaction", "symbol": "R", "unit": "kN"}
    assert page["goes down"]["head"]["number"] == "20.57 kN"
    assert page["goes down"]["answers"][-1] == pytest.approx(20.5714, rel=1e-5)
    assert page["push"]["answer"] == {"name": "load factor", "symbol": "α", "unit": "-"}


def test_figures_show_the_reaction(settled):
    assert "R = 20.57 kN" in [text.get_text() for text in figures.mechanism(settled["goes down"]).texts]
    assert figures.mechanism(settled["turns"]).get_title("right") == "R = 82.29 kN·m"
    ax = figures.convergence(settled["goes down"])
    assert ax.get_ylabel() == "reaction R [kN]"
    assert ax.lines[0].get_ydata()[0] == pytest.approx(27.4286, rel=1e-5)
    plt.close("all")


def test_every_view_has_all_notes(twisted):
    """On the torsion of corners, and on a load without a bound."""
    history = twisted["twist"].history.copy(deep=True)
    history["load_factor"][0] = np.inf
    result = dataclasses.replace(twisted["twist"], history=history)
    found = twisted.replaced(results={"twist": result})
    assert len(result.notes) == 2
    for note in result.notes:
        assert note.text in " ".join(printed(result_text(result)).split())
        assert note.text in analysis_summary(found)["cases"][0]["warnings"]
        assert note.text in html.unescape(report_html(found))
        assert note.text in " ".join(payload(found)["cases"][0]["head"]["below"])
