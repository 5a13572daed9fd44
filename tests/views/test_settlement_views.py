"""Settlements and torsion in texts, figures, report and page."""

import html
import json
import re

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest
from rich.console import Console

import blockstruct as bs
from blockstruct import Q_, views
from blockstruct.views import figures
from blockstruct.views.page.html import payload
from blockstruct.views.report import report_html
from structures import SELF_WEIGHT, beam_on_ledges, box, model_of, push

mpl.use("Agg")


@pytest.fixture(scope="module")
def analysis(tmp_path_factory):
    cases = [
        bs.SettlementCase("goes down", SELF_WEIGHT, ["left"], "-z"),
        bs.SettlementCase("turns", SELF_WEIGHT, ["left"], "-y", about="[4, 0, 0] m", flow="associative"),
        bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0), "associative"),
    ]
    path = tmp_path_factory.mktemp("views") / "beam.h5"
    return bs.run(beam_on_ledges(), cases, path, spread="shifted"), path.parent


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


def test_the_console_shows_reactions(analysis):
    found, folder = analysis
    text = printed(views.result_text(found["goes down"]))
    assert "dead, left moves along (0, 0, -1), nonassociative flow" in text
    assert str(found["goes down"].headline) in text
    assert "Statics allows reactions from 20.57 kN to 27.43 kN under the dead load." in text
    for case, unit in (("goes down", "N"), ("turns", "N·m")):
        assert f"R [{unit}]" in printed(views.iteration_table(found[case].history))
    assert re.search(r"goes down .* 20571\.\d N", printed(views.archive_table(bs.Archive(folder).table())))
    # A spread of reactions is one of forces.
    assert str(found.spread("goes down")).count("20.57 kN") > 3


def test_json_has_reactions(analysis):
    found, _ = analysis
    summary = json.loads(json.dumps(views.analysis_summary(found), allow_nan=False))
    case = next(c for c in summary["cases"] if c["name"] == "goes down")
    assert (case["load_factor"], case["reaction"]["units"]) == (None, "newton")
    values = [case["reaction"]["value"], case["reaction"]["largest"], summary["headlines"]["goes down"]["reaction"]]
    assert values == pytest.approx([20571.43, 27428.57, 20571.43], rel=1e-5)
    assert "load_factor" not in summary["headlines"]["goes down"]
    assert summary["headlines"]["push"]["load_factor"] == pytest.approx(0.6, rel=1e-6)


def test_report_and_page_show_reactions(analysis):
    found, _ = analysis
    page = report_html(found.replaced(results={name: found[name] for name in ("goes down", "turns")}))
    assert "<strong>Reaction: 20.57 kN.</strong>" in page
    assert "<strong>Reaction: 82.29 kN·m.</strong>" in page
    assert "except for those of a settlement case" in page
    page = {case["name"]: case for case in payload(found)["cases"]}
    assert page["goes down"]["answer"] == {"name": "reaction", "symbol": "R", "unit": "kN"}
    assert page["goes down"]["head"]["number"] == "20.57 kN"
    assert page["goes down"]["answers"][-1] == pytest.approx(20.5714, rel=1e-5)
    assert page["push"]["answer"] == {"name": "load factor", "symbol": "α", "unit": "-"}


def test_figures_show_the_reaction(analysis):
    found, _ = analysis
    assert "R = 20.57 kN" in [text.get_text() for text in figures.mechanism(found["goes down"]).texts]
    assert figures.mechanism(found["turns"]).get_title("right") == "R = 82.29 kN·m"
    ax = figures.convergence(found["goes down"])
    assert ax.get_ylabel() == "reaction R [kN]"
    assert ax.lines[0].get_ydata()[0] == pytest.approx(27.4286, rel=1e-5)
    plt.close("all")


def test_every_view_has_the_note_on_corner_torsion(twisted):
    (note,) = twisted["twist"].notes
    assert note.text in " ".join(printed(views.result_text(twisted["twist"])).split())
    assert note.text in views.analysis_summary(twisted)["cases"][0]["warnings"]
    assert note.text in html.unescape(report_html(twisted))
    assert note.text in payload(twisted)["cases"][0]["head"]["below"]
