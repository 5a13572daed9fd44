"""Ties of a pushover in the figure, the page, ParaView, the report, and in words: one that breaks, one that holds."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest
from test_page import coordinates, opened, settle, slide

import blockstruct as bs
from blockstruct import Q_
from blockstruct.text import report
from blockstruct.views import analysis_summary, figures, result_text
from blockstruct.views.page import write_page
from blockstruct.views.page.payload import payload
from blockstruct.views.paraview import write_paraview
from blockstruct.views.report.contents import contents
from blockstruct.views.report.pushovers import curve_sentences
from blockstruct.views.words import pushover_words
from structures import SELF_WEIGHT, box, model_of, push

pv = pytest.importorskip("pyvista")


@pytest.fixture(scope="module")
def analysis():
    blocks = [
        box("ground", [-3, 0, -0.5], [6, 1, 0.5], fixed=True),
        box("post", [-2.5, 0, 0], [0.5, 1, 2], fixed=True),
        box("block", [0, 0, 0], [0.5, 1, 2]),
    ]
    ties = [
        bs.Tie(name, ("post", Q_([-2, 0.5, z], "m")), ("block", Q_([0, 0.5, z], "m")), yield_force="2 kN", **limit)
        for name, z, limit in (("high", 1.5, {"elongation_limit": "60 mm"}), ("low", 0.5, {}))
    ]
    model = model_of(blocks, bs.JointMaterial("rough", 2.0)).with_ties(ties)
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=10)
    return bs.run(model, case)


@pytest.fixture(scope="module")
def result(analysis):
    return analysis["push"]


@pytest.fixture(scope="module")
def last(result):
    return result.capacity.sizes["step"] - 1


def test_states(result, last):
    state = bs.results.pushed_tie_state(result.model, result.capacity)
    broken = result.capacity["tie_elongation"].sel(tie="high") > 0.06
    assert state.sel(tie="high").to_numpy().tolist() == np.where(broken, "broken", "yielding").tolist()
    assert set(state.sel(tie="low").to_numpy().tolist()) == {"yielding"}


def test_the_first_page_of_ties_that_break_in_turn(analysis):
    """The first break has its numbers, and more breaks are mentioned."""
    (one,) = curve_sentences(analysis, "push", [])
    assert "tie high breaks" in one
    assert report.MORE_BREAKS not in one
    model, case = analysis["push"].model, analysis["push"].case
    low = bs.Tie(
        "low",
        ("post", Q_([-2, 0.5, 0.5], "m")),
        ("block", Q_([0, 0.5, 0.5], "m")),
        yield_force="2 kN",
        elongation_limit="40 mm",
    )
    both = bs.Model("both", model.blocks, model.interfaces, ties=[model.ties[0], low])
    (two,) = curve_sentences(bs.run(both, case), "push", [])
    assert "tie high breaks" in two
    assert two.endswith(f"; {report.MORE_BREAKS}.")


def test_figure(result):
    ax = figures.capacity(result)
    assert [text.get_text() for text in ax.texts][1:] == ["high breaks"]
    at = result.broken_ties["displacement [meter]"].item()
    assert any(np.allclose(line.get_xdata(), at) for line in ax.lines if line.get_linestyle() == ":")


def test_what_a_tie_bears_is_lost_where_it_breaks(analysis, result):
    """α falls between a state just before and one just behind, and then goes on as it will behind them."""
    at, before, after = result.broken_ties[["displacement [meter]", "load factor before", "load factor after"]].iloc[0]
    d, alpha = (result.capacity[name].to_numpy() for name in ("displacement", "load_factor"))
    k = int(np.searchsorted(d, at)) - 1
    assert tuple(alpha[k : k + 2]) == (before, after)
    assert d[k] <= at <= d[k + 1] < d[k] + 3e-3 * (d[k] - d[k - 1])
    slope = np.diff(alpha[k + 1 :]) / np.diff(d[k + 1 :])
    assert slope[0] < 0
    assert slope[0] == pytest.approx(slope[1], rel=0.1)
    assert f"falls from {before:.4g} to {after:.4g}" in bs.results.breaking_words(result.capacity)[0]
    drawn = payload(analysis)["cases"][0]["pushover"]
    assert (drawn["displacement"], drawn["values"]) == (d.tolist(), alpha.tolist())
    line = figures.capacity(result).lines[0]
    assert line.get_ydata().tolist() == alpha.tolist()


def test_page_has_the_ties_of_every_step(analysis, result, last):
    rows = payload(analysis)["cases"][0]["pushover"]["tie"]
    assert len(rows) == last + 1
    # Ties stretch a little before the first state.
    assert rows[0] == [("yielding", pytest.approx(2e3), pytest.approx(0.0, abs=1e-5))] * 2
    (state, force, longer), (held, *_) = rows[-1]
    assert (state, force, held) == ("broken", 0.0, "yielding")
    assert longer == result.capacity["tie_elongation"][-1, 0].item() > 0.06


@pytest.mark.slow
def test_page_shows_them(browser, analysis, last, tmp_path):
    def cells(page):
        return [row.all_text_contents() for row in (r.locator("td") for r in page.locator("#ties tr").all())]

    with opened(browser, write_page(analysis, tmp_path / "page.html")) as page:
        assert cells(page) == [["high", "yielding", "2 kN"], ["low", "yielding", "2 kN"]]
        slide(page, "step", last)
        high, low = cells(page)
        assert high[:3] == ["high", "broken", "0 N"]
        assert low[:3] == ["low", "yielding", "2 kN"]
        assert high[3].endswith(" mm longer")
        settle(page)
        # Two ends of the one that is left, and the gap behind it.
        assert coordinates(page, 8).shape == (3, 3)
        slide(page, "amplitude", 0.1)
        assert cells(page)[0] == ["high", "yielding", "2 kN"]


def test_paraview(result, last, tmp_path):
    write_paraview(result, tmp_path / "push.pvd")
    listed = ElementTree.parse(tmp_path / "push-pushover.pvd").findall(".//DataSet")
    assert [e.get("name") for e in listed[:2]] == ["blocks", "ties"]
    assert len(listed) == 2 * (last + 1)
    piece = pv.read(tmp_path / listed[-1].get("file"))
    assert piece.cell_data["broken"].tolist() == [1, 0]
    np.testing.assert_allclose(piece.cell_data["tension [newton]"], [0, 2e3], rtol=1e-4)
    ends = piece.points.reshape(2, 2, 3)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    np.testing.assert_allclose(piece.cell_data["elongation [meter]"], length - 2, atol=1e-6)
    assert len(list((tmp_path / "push").glob("pushed-ties-*.vtp"))) == last + 1


def test_report_and_console_list_broken_ties(analysis, result):
    page = contents(analysis, {})
    (case,) = page["cases"]
    said = " ".join(case["pushover"])
    assert said.startswith(f"Beyond collapse {result.capacity.sizes['step']} states were found, all of them certified")
    assert f"Tie high breaks at a displacement of {1e3 * result.broken_ties.iloc[0, 0]:.4g} mm, 60 mm longer" in said
    assert "Tie low holds: it lengthens by at most" in said
    assert f"{result.curve_ended[1:]}." in said
    assert all(sentence in result_text(result).plain for sentence in pushover_words(result))
    assumed = " ".join(page["assumptions"])
    assert "Displacements are small, except beyond the collapse state of a pushover: equilibrium" in assumed
    assert "corners stay sharp, and ties break at their elongation limits." in assumed


def test_json(analysis, result):
    (case,) = json.loads(json.dumps(analysis_summary(analysis)))["cases"]
    found = case["pushover"]
    assert found["d0"] == result.capacity["d0"].item()
    assert found["states"] == found["certified"] == result.capacity.sizes["step"]
    assert found["ended"] == result.curve_ended
    (broken,) = found["broken_ties"]
    assert broken["tie"] == "high"
    assert broken["elongation [meter]"] == 0.06
