"""What the first page of a report must not leave unsaid."""

import dataclasses
import html
import io
import re

import numpy as np
import pypdf
import pytest
from matplotlib.figure import Figure

import blockstruct as bs
from blockstruct import Q_
from blockstruct.assess.lines import HIGHER
from blockstruct.limit import Outcome
from blockstruct.text import report
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.views import figures
from blockstruct.views.figures import drawings
from blockstruct.views.report import report_html, write_report
from blockstruct.vocabulary import Reason
from structures import SELF_WEIGHT, model_of, push, settings_of, single_block

SINKS = bs.SettlementCase("sinks", SELF_WEIGHT, ["ground"], "-z", flow="associative")
SITE = bs.assess.ntc_spectrum(Q_(0.15, "g_0"), 2.4, "0.3 s", "B")


@pytest.fixture(autouse=True)
def few_pictures(monkeypatch, no_pictures):
    """Pictures of cases are tested where they are drawn, and take longer than all the rest."""
    monkeypatch.setattr("blockstruct.views.report.contents.drawings", lambda result: drawings(result)[:1])


def head_of(html):
    return html[html.index('<section class="summary">') : html.index('id="after-summary"')]


def summary(analysis, checks=()):
    return html.unescape(head_of(report_html(analysis, checks=checks))).replace("\u00a0", " ")


def checked(result, **of_state):
    """Its check, with other numbers at the limit state relied on."""
    check = bs.assess.local_mechanism(result, 1.35, SITE)
    state = dataclasses.replace(check.verdict.state, **of_state)
    return dataclasses.replace(check, limit_states={**check.limit_states, check.relied_on: state})


def ended(analysis, **statuses):
    """The analysis, some cases of which ended otherwise, without a load factor."""

    def outcome(status):
        return Outcome(bs.Status(status), np.nan, Reason.NO_CERTIFICATE)

    ended = {name: analysis[name].changed(outcome=outcome(status)) for name, status in statuses.items()}
    return analysis.replaced(results={**analysis, **ended})


@pytest.fixture(scope="module")
def block():
    """A block that bears its site, and that falls where a thrust is part of the dead load."""
    thrust = bs.PointLoad("block", Q_([0, 0.5, 1.9], "m"), Q_([30, 0, 0], "kN"))
    dead = bs.LoadPattern("dead + thrust", [bs.SelfWeight(), thrust])
    cases = [
        bs.LimitCase("good", SELF_WEIGHT, push(1, 0, 0)),
        bs.LimitCase("back", SELF_WEIGHT, bs.LoadPattern("push back", push(-1, 0, 0).loads)),
        bs.LimitCase("falls", dead, push(1, 0, 0)),
    ]
    return bs.run(model_of(*single_block(0.8, 2.0)), cases)


@pytest.fixture(scope="module")
def stands(block):
    return block.replaced(results={name: block[name] for name in ("good", "back")})


def test_no_check_makes_up_for_a_case_that_falls(block):
    check, failed = checked(block["good"]), checked(block["good"], ag=0.5 * SITE.ag, capacity=0.6, demand=1.0)
    assert check.satisfied
    for given in ([], [check, checked(block["back"])], [failed]):
        head = summary(block, given)
        assert "“falls” is unstable under dead load" in head
        assert "Relied on" not in head
        assert "<b>none</b>" in head
        assert "satisfied" not in head.replace("not satisfied", "")
    assert "Other checks: capacity / demand 0.6 of “good” (SLV, linear), not satisfied." in head


@pytest.mark.parametrize("status", ["interrupted", "not_converged", "depends_on_self_stress"])
def test_no_check_makes_up_for_a_case_without_an_end(stands, status):
    found = ended(stands, back=status)
    head = summary(found, [checked(found["good"])])
    assert "There is no load factor to rely on: “back” " in head
    assert "The verification is not satisfied." in head
    # Of several, the worst is named.
    assert "“back” is not converged" in summary(ended(stands, good="interrupted", back="not_converged"))


def test_a_settlement_governs_alone(block):
    """Without a push the report relies on the reaction, which is no load factor."""
    both = bs.AnalysisManager(block.model).run([block["good"].case, SINKS])
    assert "Relied on: capacity / demand" in summary(ended(both, sinks="interrupted"), [checked(both["good"])])
    alone = summary(both.replaced(results={"sinks": both["sinks"]}))
    assert f"Relied on: reaction {both['sinks'].headline.number} of “sinks”" in alone
    assert "load factor" not in alone


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
def test_a_load_factor_that_has_not_settled_satisfies_no_demand(small_model):
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    settings = settings_of(procedure="fictitious", patience=3, load_factor_tolerance=1e-15)
    found = bs.AnalysisManager(small_model, settings=settings).run([case])
    check = checked(found["push"])
    assert (found["push"].drifts, check.verdict.state.satisfied, check.satisfied) == (True, True, False)
    for head in (summary(found), summary(found, [check])):
        assert head.count("NOT SETTLED") >= 2
        assert "satisfied" not in head


def test_the_range_of_a_spread_stands_next_to_its_number(stands):
    ranged = stands["good"].changed(path_dependence=(0.123456, 0.234567))
    head = summary(stands.replaced(results={"good": ranged}))
    assert head.count("0.1235 to 0.2346") == 2
    assert re.findall(r"<(?:b|strong)>(.*?)</", head) == [ranged.headline.number] * 2


def test_the_largest_reaction_is_relied_on(block):
    """Of forces alone: moments are no forces."""
    leans = bs.SettlementCase("leans", SELF_WEIGHT, ["ground"], (0.6, 0, -0.8), flow="associative")
    assert "the largest of 2 cases" in summary(bs.AnalysisManager(block.model).run([SINKS, leans]))
    turns = bs.SettlementCase("turns", SELF_WEIGHT, ["ground"], "-y", about="[1, 0, 0] m", flow="associative")
    assert "one of 2 cases, forces and moments" in summary(bs.AnalysisManager(block.model).run([SINKS, turns]))


def test_the_check_that_governs_need_not_have_the_least_ratio(stands):
    """By displacement, capacity over demand and the ground acceleration that is borne rank checks otherwise."""
    governs = checked(stands["good"], ag=1.05 * SITE.ag, capacity=1.14, demand=1.0)
    below = checked(stands["back"], ag=1.1 * SITE.ag, capacity=0.846, demand=1.0)
    head = summary(stands, [below, governs])
    assert "Relied on: capacity / demand 1.14 of “good” (SLV, linear), which of 2 checks bears the least share" in head
    assert "Other checks: capacity / demand 0.846 of “back” (SLV, linear), below 1, but satisfied" in head
    assert "Other checks" not in summary(stands, [governs, checked(stands["back"])])
    weaker = checked(stands["back"], ag=0.9 * SITE.ag, capacity=1.2, demand=1.0)
    lowest = checked(stands["good"], ag=0.8 * SITE.ag, capacity=0.9, demand=1.0)
    assert "1.2 of “back” (SLV, linear), not satisfied: a weaker" in summary(stands, [weaker, lowest])


def test_the_lowest_of_all_ways_governs(stands):
    bears = checked(stands["good"], ag=1.05 * SITE.ag, capacity=1.05, demand=1.0)
    less = dataclasses.replace(bears.verdict.state, ag=0.93 * SITE.ag, capacity=0.93)
    way = bs.assess.WayOfChecking(bs.assess.Way.UNIFORM_TORSION, 0.1, 0.98, less, load_factor=0.775)
    low = dataclasses.replace(checked(stands["back"], ag=1.2 * SITE.ag, capacity=1.2, demand=1.0), others=(way,))
    head = summary(stands, [bears, low])
    assert "Relied on: capacity / demand 0.93 of “back” (SLV, linear), which of 2 checks" in head
    assert "Other load factors, with the least motion of each, give up to 1.2." in head
    # An acceleration beyond the search is marked.
    assert "<b>more than 10 g</b>" in summary(stands, [checked(stands["good"], ag=np.inf)])


def pushover(**of_case):
    """A slender block pushed over."""
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=8, **of_case)
    return bs.run(model_of(*single_block(0.5, 3.0)), case)


def beginning(analysis, first):
    """The analysis, its curve as if it began at another load factor."""
    curve = analysis["push"].capacity.copy(deep=True)
    curve["load_factor"][0] = first
    return analysis.replaced(results={"push": dataclasses.replace(analysis["push"], capacity=curve)})


def test_a_curve_of_rounded_corners_stands_next_to_its_load_factor():
    rounded = pushover(corner_rounding="80 mm")
    result = rounded["push"]
    first = result.capacity["load_factor"].to_numpy()[0]
    assert first < 0.8 * result.load_factor
    said = f"the curve of rounded corners begins at {first:.4g}"
    for checks in ([], [bs.assess.local_mechanism(result, 1.35, SITE)]):
        assert f"<p>Pushover “push”: {said}" in summary(rounded, checks)
    assert f"<b>0.1667</b><span>{said}</span>" in report_html(rounded)


def test_a_curve_that_begins_half_a_per_cent_off_is_marked():
    sharp = pushover()
    alpha = sharp["push"].load_factor
    low = beginning(sharp, 0.9 * alpha)
    for factor, marked in ((0.996, False), (1.004, False), (0.994, True), (1.006, True), (1.1, True)):
        head = summary(beginning(sharp, factor * alpha))
        assert (f"the curve begins at {factor * alpha:.4g}" in head) is marked
        assert "rounded corners" not in head
    assert f"<p>Pushover “push”: {sharp['push'].curve_ended}.</p>" in summary(sharp)
    doubt, *_ = bs.results.doubtful_parts(low["push"].capacity, low["push"].settings.procedure)
    assert str(doubt) in summary(low)


def test_the_first_page_has_the_bound_between_directions():
    around = bs.directions(model_of(*single_block(0.4, 4.0, t=0.4)), SELF_WEIGHT, 4, flow="associative")
    assert around.least_between < 0.99 * around.load_factor
    said = f"With associative flow no direction is below load factor {around.least_between:.4g} between those"
    found = around.analysis
    assert f"It is checked against no demand. {said}" in summary(found)
    assert said in summary(found, [bs.assess.local_mechanism(r, 1.35, SITE) for r in found.values()])
    assert "no direction is below" not in summary(ended(found, **{next(iter(found)): "not_converged"}))


def test_the_first_page_marks_uncovered_directions(stands):
    said = "Directions between those that were run are not covered, and one of them may be lower."
    around = bs.directions(stands.model, SELF_WEIGHT, 4)
    assert said in summary(around.analysis)
    part = bs.directions(stands.model, SELF_WEIGHT, Q_([60, 120], "deg"), flow="associative")
    told = f"{said[:-1]}: none was run for 300 deg, from 120 to 60 deg."
    assert told in summary(part.analysis)
    # Two pushes are no compass.
    assert said[:-1] not in summary(stands)
    assert "no direction is below" not in summary(stands)


def test_each_note_stands_once_and_is_cited_by_number(stands):
    shared, own = Note(NoteCode.RANGE, Severity.CAUTION, "both."), Note(NoteCode.MASSES, Severity.CAUTION, "one.")
    good, back = (bs.assess.local_mechanism(result, 1.35, SITE) for result in stands.values())
    checks = [dataclasses.replace(good, notes=(shared,)), dataclasses.replace(back, notes=(own, shared))]
    page = report_html(stands, checks=checks)
    notes = re.findall(r"&ensp;(.*?)</p>", page)
    assert [sum(note.text in text for text in notes) for note in (shared, own)] == [1, 1]
    rows = re.findall(r"<tr><td>(good|back)</td>.*?<td class=\"number\">([\d, –]+)</td></tr>", page)
    cited = {name: set(numbers.split(", ")) for name, numbers in rows}
    assert cited["good"] < cited["back"]


def case(name="push", direction=(1, 0, 0), flow="nonassociative"):
    return bs.LimitCase(name, SELF_WEIGHT, bs.LoadPattern(f"push of {name}", push(*direction).loads), flow)


@pytest.fixture(scope="module")
def slender():
    return bs.run(model_of(*single_block(0.4, 4.0), "block"), case())


@pytest.fixture(scope="module")
def check(slender):
    return bs.assess.local_mechanism(slender["push"], 1.35, SITE)


def pages(path):
    return [page.extract_text() for page in pypdf.PdfReader(io.BytesIO(path.read_bytes())).pages]


def test_arguments_of_a_wrong_type_are_refused(slender, check):
    for checks, given in ((check, "LocalMechanismCheck"), (["SLV"], "str")):
        with pytest.raises(bs.errors.ModelError, match=rf"checks: {given}; give a list .* checks=\[check\]"):
            report_html(slender, checks=checks)
    with pytest.raises(bs.errors.ModelError, match="project 'Lucca'; give names and texts"):
        report_html(slender, project="Lucca")


def test_the_first_page_has_the_number_relied_on(slender, check):
    head = head_of(report_html(slender, checks=[check]))
    assert "Relied on: capacity / demand 0.823 of “push” (SLV, linear), with α = 0.1." in head
    for words in ("<b>0.1</b>", "<b>0.823</b>", "<b>0.1235\u00a0g</b>", "site 0.15\u00a0g"):
        assert words in head, words
    plain = head_of(report_html(slender))
    assert "Relied on: load factor 0.1 of “push”. It is checked against no demand." in plain
    assert plain.count("<b>") == 1


def test_the_verification_gives_every_formula(slender):
    check = bs.assess.local_mechanism(slender["push"], 1.35, SITE, method="displacement")
    page = report_html(slender, checks=[check]).replace("\u00a0", " ")
    tables = "".join(re.findall(r'<table class="calculation">.*?</table>', page, re.DOTALL))
    rows = re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td><td>(.*?)</td></tr>", tables)
    assert len(rows) == sum(len(section.lines) for section in check.sections)
    assert ("capacity", "d<sub>SLV</sub> = 0.4 d<sub>0</sub> = 0.4 · 0.2 m = 0.08 m", "C8.7.1.2.1.6") in rows
    assert HIGHER in page
    assert report.NO_DEMAND in report_html(slender)


def test_a_check_of_another_number_is_refused(small_model, slender):
    spread = bs.AnalysisManager(small_model).run([case()], spread="steep")
    s = spread.spread("push")
    bound = bs.assess.local_mechanism(s.upper_bound, 1.35, SITE)
    with pytest.raises(bs.errors.ModelError, match=r"check analysis\.spread\('push'\)"):
        report_html(spread, checks=[bound])
    assert "Relied on: capacity" in report_html(spread, checks=[bs.assess.local_mechanism(s, 1.35, SITE)])
    with pytest.raises(bs.errors.ModelError, match="is not part of it"):
        report_html(spread, checks=[bs.assess.local_mechanism(slender["push"], 1.35, SITE)])


def test_the_report_is_a_pdf_of_numbered_pages(slender, check, tmp_path):
    paper = pages(write_report(slender, tmp_path / "r.pdf", project={"client": "Town of Lucca"}, checks=[check]))
    for number, text in enumerate(paper, 1):
        assert f"{number} / {len(paper)}" in text
    # The summary is one page, and nothing else is on it.
    assert "Town of Lucca" in paper[0]
    assert "capacity / demand" in paper[0]
    assert "Model" not in paper[0]
    assert "Model" in paper[1]
    assert "Settings and versions" in paper[-1]


def test_a_long_word_does_not_push_numbers_off_the_page(tmp_path):
    name, places = "Overturning_of_the_western_façade_" * 4, []
    analysis = bs.run(model_of(*single_block(0.4, 4.0), "model " * 40), case(name))
    target = write_report(analysis, tmp_path / "long.pdf", project={"protocol": "x" * 200})
    page = pypdf.PdfReader(target).pages[0]
    page.extract_text(visitor_text=lambda text, cm, tm, *_: places.append((text.strip(), tm[4] * cm[0] + cm[4])))
    right = float(page.mediabox.width) - 20 / 25.4 * 72
    numbers = [x for text, x in places if text == "0.1"]
    assert len(numbers) >= 2
    assert max(x for text, x in places if text) < right


def test_a_template_that_loads_other_files_is_refused(slender, tmp_path):
    own, image = tmp_path / "firm.html.j2", '<img src="file:///etc/hostname">'
    own.write_text('{% extends "report.html.j2" %}{% block foot %}' + image + "{% endblock %}", encoding="utf-8")
    with pytest.raises(bs.errors.StorageError, match="not part of the report"):
        write_report(slender, tmp_path / "r.pdf", template=own)
    assert not (tmp_path / "r.pdf").exists()


def test_the_drawn_demand_matches_the_check(check):
    curve, demand, ray, *_ = figures.verification(check, ax=Figure().add_subplot()).get_lines()
    state = check.limit_states["SLV, by displacement"]
    np.testing.assert_allclose(curve.get_xydata(), [[0, check.a0_star], [0.2, 0]], rtol=1e-5, atol=1e-12)
    meeting = np.array([state.demand, np.interp(state.demand, *ray.get_xydata().T)])
    assert np.abs(demand.get_xydata() / meeting - 1).max(axis=1).min() < 0.01
    # All of the demand is the spectrum, also beyond the edge of the picture.
    d, a = demand.get_xydata().T
    np.testing.assert_allclose(a, SITE.acceleration(2 * np.pi * np.sqrt(d / a), 0.08), rtol=1e-6)
    sliding = dataclasses.replace(check, curve=None, missing_curve="no capacity curve")
    with pytest.raises(bs.errors.ModelError, match="there is none to draw"):
        figures.verification(sliding)


@pytest.mark.slow
def test_many_cases_leave_the_summary_on_one_page(tmp_path):
    angles = np.radians(np.arange(0, 360, 30))
    cases = [case(f"towards {a:.2f}", (np.cos(a), np.sin(a), 0), "associative") for a in angles]
    analysis = bs.run(model_of(*single_block(0.4, 4.0)), cases)
    html = report_html(analysis)
    assert "And 4 more cases, below." in head_of(html)
    assert html.count("<td>converged</td>") == 8 + 12
    assert "Model" in pages(write_report(analysis, tmp_path / "r.pdf"))[1]
