"""The report that an engineer signs: what stands on its first page, its verification, and its pages as PDF."""

import dataclasses
import html
import io
import re

import numpy as np
import pytest
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct import Q_
from blockstruct.assess.lines import HIGHER
from blockstruct.text import Note, NoteCode, Severity, report
from blockstruct.views import figures
from blockstruct.views.figures import drawings
from blockstruct.views.report import report_html, write_report
from structures import SELF_WEIGHT, model_of, push, single_block

pypdf = pytest.importorskip("pypdf")
SITE = bs.assess.ntc_spectrum(Q_(0.15, "g_0"), 2.4, "0.3 s", "B")


def case(name="push", direction=(1, 0, 0), flow="nonassociative"):
    return bs.LimitCase(name, SELF_WEIGHT, bs.LoadPattern(f"push of {name}", push(*direction).loads), flow)


@pytest.fixture(autouse=True)
def few_pictures(monkeypatch, no_pictures):
    """Pictures of cases are tested where they are drawn, and take longer than all the rest."""
    monkeypatch.setattr("blockstruct.views.report.contents.drawings", lambda result: drawings(result)[:1])


@pytest.fixture(scope="module")
def block():
    blocks, joint = single_block(0.4, 4.0)
    return bs.AnalysisManager(model_of(blocks, joint, "block of Lucca")).run([case()])


@pytest.fixture(scope="module")
def check(block):
    return bs.assess.local_mechanism(block["push"], 1.35, SITE)


@pytest.fixture(scope="module")
def paper(tmp_path_factory):
    """A check, its page, and the texts of the pages of its PDF; a digit after the 0 of d_C,0 would begin a line."""
    blocks, joint = single_block(0.4094, 4.0)
    analysis = bs.AnalysisManager(model_of(blocks, joint)).run([case()])
    check = bs.assess.local_mechanism(analysis["push"], 1.35, SITE)
    with pytest.MonkeyPatch.context() as patch:
        # As in the tests: pictures take longer than all the rest.
        patch.setattr("blockstruct.views.report.contents.drawings", lambda result: drawings(result)[:1])
        path = tmp_path_factory.mktemp("paper") / "r.pdf"
        write_report(analysis, path, project={"client": "Town of Lucca"}, checks=[check])
        assert path.read_bytes().startswith(b"%PDF")
        return check, report_html(analysis, checks=[check]), pages(path)


@pytest.fixture(scope="module")
def spread(small_model):
    return bs.AnalysisManager(small_model).run([case()], spread=["steep", "shifted"])


def summary(html):
    return html[html.index('<section class="summary">') : html.index('id="after-summary"')]


def pages(path):
    return [page.extract_text() for page in pypdf.PdfReader(io.BytesIO(path.read_bytes())).pages]


def test_arguments_of_a_wrong_type_are_refused(block, check):
    for checks, given in ((check, "LocalMechanismCheck"), (["SLV"], "str")):
        with pytest.raises(bs.errors.ModelError, match=rf"checks: {given}; give a list .* checks=\[check\]"):
            report_html(block, checks=checks)
    with pytest.raises(bs.errors.ModelError, match="project 'Lucca'; give names and texts"):
        report_html(block, project="Lucca")


def test_the_same_check_is_shown_once(block):
    check, again = (bs.assess.local_mechanism(block["push"], 1.35, SITE) for _ in range(2))
    assert report_html(block, checks=[check, check, again]) == report_html(block, checks=[check])


def test_the_first_page_has_the_number_relied_on(block, check):
    head = summary(report_html(block, checks=[check]))
    assert "Relied on: capacity / demand 0.823 of “push” (SLV, linear), with α = 0.1." in head
    for text in (
        "<b>0.1</b>",
        "<b>0.823</b>",
        "<b>0.1235\u00a0g</b>",
        "not satisfied",
        "site 0.15\u00a0g",
        'class="key missed"',
    ):
        assert text in head, text
    assert head.count("<img") == 1
    plain = summary(report_html(block))
    assert "Relied on: load factor 0.1 of “push”. It is checked against no demand." in plain
    assert plain.count("<b>") == 1


def test_the_verification_gives_every_formula(block):
    check = bs.assess.local_mechanism(block["push"], 1.35, SITE, method="displacement")
    html = report_html(block, checks=[check])
    first, part = html[: (begin := html.index('<section class="case">'))], html[begin:]
    # No line ends between a number and its unit, or between a symbol and its value.
    assert "d<sub>SLV</sub>\u00a0=\u00a00.4 d<sub>0</sub>\u00a0=\u00a00.4 · 0.2\u00a0m =\u00a00.08\u00a0m" in part
    assert re.search(r"T<sub>SLV</sub>\u00a0=\u00a01\.68\u00a0π\u00a0√\(d/a\) =\u00a01\.68\u00a0π\u00a0√\(", part)
    part = part.replace("\u00a0", " ")
    tables = "".join(re.findall(r'<table class="calculation">.*?</table>', part, re.DOTALL))
    rows = re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td><td>(.*?)</td></tr>", tables)
    assert len(rows) == sum(len(section.lines) for section in check.sections)
    assert ("capacity", "d<sub>SLV</sub> = 0.4 d<sub>0</sub> = 0.4 · 0.2 m = 0.08 m", "C8.7.1.2.1.6") in rows
    assert "SLV, by displacement: capacity / demand" in part
    # The picture stands with the limit state relied on, and in the appendix for any other.
    linear = report_html(block, checks=[bs.assess.local_mechanism(block["push"], 1.35, SITE)])
    caption, appendix = "Capacity curve and demand at SLV", '<section class="appendix">'
    assert html.index(caption) < html.index(appendix)
    assert linear.index(appendix) < linear.index(caption)
    assert "Displacements are small, except along the capacity curve of a check: equilibrium" in first
    assert "a body turns through finite angles" in first
    assert "Displacements are small: equilibrium" in report_html(block)
    assert (first.count(HIGHER), part.count(HIGHER), report_html(block).count(HIGHER)) == (1, 1, 0)
    assert report.NO_DEMAND in report_html(block)


def test_changed_coefficients_stand_next_to_the_verdict(block):
    check = bs.assess.local_mechanism(block["push"], 1.35, SITE, coefficients=bs.assess.Coefficients(q=5))
    html = report_html(block, checks=[check])
    assert "satisfied" in summary(html)
    (note,) = check.notes
    assert note.text in summary(html)
    assert html.count(note.text) == 1


def test_a_long_table_has_its_titles_on_every_page(tmp_path):
    blocks, joint = single_block(0.4, 4.0)
    small = [bs.PointLoad("block", Q_([0, 0, 4], "m"), Q_([0, 0, -1 - k], "N")) for k in range(12)]
    cases = [
        bs.LimitCase(f"case {k}", bs.LoadPattern(f"dead {k}", [bs.SelfWeight(), *small]), push(1, 0, 0), "associative")
        for k in range(6)
    ]
    write_report(bs.AnalysisManager(model_of(blocks, joint)).run(cases), tmp_path / "report.pdf")
    listed = [page for page in pages(tmp_path / "report.pdf") if "on block block at" in page]
    assert len(listed) > 1
    assert all("pattern loads" in page for page in listed)


def test_a_check_of_another_number_is_refused(spread, block):
    s = spread.spread("push")
    bound = bs.assess.local_mechanism(s.upper_bound, 1.35, SITE)
    with pytest.raises(bs.errors.ModelError, match=r"check analysis\.spread\('push'\)"):
        report_html(spread, checks=[bound])
    assert "Relied on: capacity" in report_html(spread, checks=[bs.assess.local_mechanism(s, 1.35, SITE)])
    with pytest.raises(bs.errors.ModelError, match="is not part of it"):
        report_html(spread, checks=[bs.assess.local_mechanism(block["push"], 1.35, SITE)])


def test_the_worst_case_comes_first(small_model):
    cases = [case("along", (1, 0, 0)), case("across", (0, 1, 0)), case("down", (0, 0, -1))]
    analysis = bs.AnalysisManager(small_model).run(cases)
    head = summary(report_html(analysis))
    lowest = min(analysis.values(), key=lambda r: r.load_factor)
    assert f"load factor {lowest.load_factor:.4g} of “{lowest.name}”, the lowest of 3 cases" in head
    checks = [bs.assess.local_mechanism(analysis[name], 1.35, SITE) for name in ("along", "across")]
    said = "which of 2 checks bears the least share of its site's ground acceleration"
    assert said in html.unescape(summary(report_html(analysis, checks=checks)))


def test_the_report_is_a_pdf_of_numbered_pages(paper):
    *_, found = paper
    for number, text in enumerate(found, 1):
        assert f"{number} / {len(found)}" in text
        assert "Rigid-block limit analysis" in text
    # The summary is one page, and nothing else is on it.
    assert "Town of Lucca" in found[0]
    assert "capacity / demand" in found[0]
    assert "Model" not in found[0]
    assert "Model" in found[1]
    assert "partial safety factor" in found[1]
    assert "Settings and versions" in found[-1]


@pytest.mark.slow
def test_a_page_with_two_checks_and_notes_keeps_a_picture_that_can_be_read(block, tmp_path):
    analysis = bs.AnalysisManager(block.model).run([case("push +x"), case("push +y", (0, 1, 0))])
    checks = [bs.assess.local_mechanism(result, 1.35, SITE) for result in analysis.values()]
    project = dict.fromkeys(("client", "engineer", "place", "date", "protocol", "drawing"), "Lucca")
    found = pages(write_report(analysis, tmp_path / "r.pdf", project=project, checks=checks))
    assert "moves, to first order" in found[0].replace("\n", " ")
    assert "partial safety factor" in found[1]


@pytest.mark.slow
@pytest.mark.parametrize(("count", "on_first"), [(1, True), (12, False)])
def test_a_page_that_is_full_keeps_its_picture_and_moves_its_notes(block, tmp_path, count, on_first):
    check = bs.assess.local_mechanism(block["push"], 1.35, SITE)
    notes = tuple(Note(NoteCode.RANGE, Severity.CAUTION, f"{k} " + "note " * 60) for k in range(count))
    full = dataclasses.replace(check, notes=notes)
    found = pages(write_report(block, tmp_path / "r.pdf", checks=[full]))
    assert "moves, to first order" in found[0].replace("\n", " ")
    assert ["Notes on push" in page for page in found].index(True) == (0 if on_first else 3)
    assert "Model" in found[1]


def test_no_line_ends_within_a_quantity_or_an_index(paper):
    """A line that begins with the 0 of d_C,0 would read 0 = 0.2047 m."""
    check, said, found = paper
    assert f'{check.a0_star:.4g}\u00a0<span class="unit">m/s²</span>' in said
    assert "(g\u00a0·\u00a0" in said
    text = "\n".join(found)
    assert not re.search(r"(m/|\d)\n(s²|m|k?N)\b", text)
    assert "dC,0\u00a0=\u00a00.2047\u00a0m" in text


def test_a_long_word_does_not_push_numbers_off_the_page(tmp_path):
    name, places = "Overturning_of_the_western_façade_" * 4, []
    blocks, joint = single_block(0.4, 4.0)
    model = model_of(blocks, joint, "model " * 40)
    analysis = bs.AnalysisManager(model).run([case(name)])
    target = write_report(analysis, tmp_path / "long.pdf", project={"protocol": "x" * 200})
    page = pypdf.PdfReader(target).pages[0]
    page.extract_text(visitor_text=lambda text, cm, tm, *_: places.append((text.strip(), tm[4] * cm[0] + cm[4])))
    right = float(page.mediabox.width) - 20 / 25.4 * 72
    numbers = [x for text, x in places if text == "0.1"]
    assert len(numbers) >= 2
    assert max(x for text, x in places if text) < right


def test_a_template_that_loads_other_files_is_refused(block, tmp_path):
    own = tmp_path / "firm.html.j2"
    own.write_text(
        '{% extends "report.html.j2" %}{% block foot %}<img src="file:///etc/hostname">{% endblock %}', encoding="utf-8"
    )
    with pytest.raises(bs.errors.StorageError, match="not part of the report"):
        write_report(block, tmp_path / "r.pdf", template=own)
    assert not (tmp_path / "r.pdf").exists()


def test_the_drawn_demand_matches_the_check(check):
    curve, demand, ray, *_ = figures.verification(check, ax=Figure().add_subplot()).get_lines()
    state = check.limit_states["SLV, by displacement"]
    np.testing.assert_allclose(curve.get_xydata(), [[0, check.a0_star], [0.2, 0]], rtol=1e-5, atol=1e-12)
    meeting = np.array([state.demand, np.interp(state.demand, *ray.get_xydata().T)])
    assert np.abs(demand.get_xydata() / meeting - 1).max(axis=1).min() < 0.01
    # All of the demand is the spectrum, also beyond the edge of the picture.
    d, a = demand.get_xydata().T
    periods = 2 * np.pi * np.sqrt(d / a)
    np.testing.assert_allclose(a, SITE.acceleration(periods, 0.08), rtol=1e-6)
    assert len(a) == 400
    sliding = dataclasses.replace(check, curve=None, missing_curve="no capacity curve")
    with pytest.raises(bs.errors.ModelError, match="there is none to draw"):
        figures.verification(sliding)


def test_a_reaction_is_no_load_factor(block):
    """The report relies on the load factor of a push, and on a reaction only without one."""
    settlement = bs.SettlementCase(
        "ground sinks", dead=SELF_WEIGHT, supports=["ground"], direction=(0, 0, -1), flow="associative"
    )
    both = bs.AnalysisManager(block.model).run([settlement, case()])
    assert "Relied on: load factor 0.1 of “push”." in summary(report_html(both))
    alone = bs.AnalysisManager(block.model).run([settlement])
    head = summary(report_html(alone))
    assert "Relied on: reaction 32\u00a0kN of “ground sinks”" in head
    assert "load factor" not in head


@pytest.mark.slow
def test_many_cases_leave_the_summary_on_one_page(tmp_path, monkeypatch):
    monkeypatch.setattr("blockstruct.views.report.contents.drawings", lambda result: [])
    blocks, joint = single_block(0.4, 4.0)
    angles = np.radians(np.arange(0, 360, 30))
    cases = [case(f"towards {a:.2f}", (np.cos(a), np.sin(a), 0), "associative") for a in angles]
    analysis = bs.AnalysisManager(model_of(blocks, joint)).run(cases)
    html = report_html(analysis)
    assert html.startswith("<!doctype html>")
    assert "And 4 more cases, below." in summary(html)
    assert "pushed in 12 directions" in html
    assert html.count("<td>converged</td>") == 8 + 12
    found = pages(write_report(analysis, tmp_path / "r.pdf"))
    assert "Model" in found[1]


@pytest.mark.slow
def test_the_name_of_a_tie_stays_whole(tmp_path, monkeypatch):
    monkeypatch.setattr("blockstruct.views.report.contents.drawings", lambda result: [])
    blocks, joint = single_block(0.4, 4.0)
    ends = ("ground", ["0.35 m", "0.25 m", "-0.15 m"]), ("block", ["0.15 m", "0.25 m", "2.75 m"])
    tie = bs.Tie("catena", *ends, yield_force="10 kN", elongation_limit="30 mm")
    tied = model_of(blocks, joint).with_ties([tie])
    found = pages(write_report(bs.AnalysisManager(tied).run([case("push", (1, 0, 0))]), tmp_path / "r.pdf"))
    rows = next(page for page in found if "yield force 10 kN" in page).partition("tie kind from to")[2]
    assert "\ncatena tie ground at" in rows
