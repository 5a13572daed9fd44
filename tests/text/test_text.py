"""The words of every note and of the other sentences on results, each pinned once, in the texts beside this."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import blockstruct as bs
from blockstruct.limit import Outcome
from blockstruct.text import assessment as a
from blockstruct.text import assumptions as assumptions_text
from blockstruct.text import case as case_text
from blockstruct.text import mechanism as mechanism_text
from blockstruct.text import note as note_text
from blockstruct.text import report, study
from blockstruct.text.headline import Headline
from blockstruct.text.note import NoteCode
from blockstruct.text.numbers import LOAD_FACTOR, Answer
from blockstruct.vocabulary import CurveDoubt, Flow, PathEnd, Procedure, Reason, SolverStatus, Status

REACTION = Answer("reaction", "R", "force", -1e3)
FIRST, INF = (Status.CONVERGED, 0.5, Reason.CERTIFIED), np.inf
SETTLED = Outcome(*FIRST, Procedure.LOADING_PATH, settled=True)
DRIFTING = Outcome(*FIRST, Procedure.LOADING_PATH)
STANDS_IN = Outcome(*FIRST, Procedure.FICTITIOUS, settled=True, path_end=PathEnd.LIMIT_REACHED)
RAISED = Outcome(*FIRST, Procedure.LOADING_PATH, drift=(0.6, 0.6), without_crushing=0.5)
UNBOUNDED = Outcome(Status.UNBOUNDED, INF, Reason.GROWS_WITHOUT_LIMIT)


def headline(outcome):
    return Headline(outcome, Flow.NONASSOCIATIVE)


def caveats(outcome, answer=LOAD_FACTOR, bound=1.0, jammed=(), *, is_searched=True):
    return note_text.caveats(outcome, answer, bound=bound, is_searched=is_searched, jammed=jammed)


NOTES = [
    *caveats(DRIFTING),
    *caveats(RAISED),
    *caveats(STANDS_IN, REACTION),
    *caveats(SETTLED, bound=INF),
    *caveats(SETTLED, REACTION, bound=INF),
    *caveats(UNBOUNDED, bound=INF),
    *caveats(SETTLED, jammed=["a", "b", "c", "d"]),
    *caveats(replace(SETTLED, other_procedure=0.8 * SETTLED.load_factor), jammed=["a"]),
    *caveats(replace(SETTLED, other_procedure=SETTLED.load_factor), bound=INF),
    note_text.torsion_note(["a|b"], 1.848, 0.459, "load factor", at_corners=True),
    note_text.torsion_note(["a", "b", "c", "d", "e"], 1.848, None, "load factor", at_corners=True),
    note_text.torsion_note(["a|b"], 1.13, 0.1, "reaction", at_corners=False),
    note_text.torsion_note(["a|b"], 1.13, None, "reaction", at_corners=False),
    note_text.effect_note(NoteCode.CORNER_TORSION, 0.37, 0.315, LOAD_FACTOR),
    note_text.effect_note(NoteCode.CORNER_TORSION, 0.37, 0.315, LOAD_FACTOR, is_estimate=True),
    note_text.effect_note(NoteCode.BIAXIAL_CRUSHING, 1.0, 1.02, REACTION),
    note_text.biaxial_note(["a|b"], 1.5, is_reaction=False),
    note_text.cells_note(1, 2, (62, 64), 0.052, is_reaction=False),
    note_text.cells_note(1, 1, (64, 64), 0.052, is_reaction=True),
    a.associative_bound(),
    a.rounded_corners(0.03, 0.09, 0.1),
    a.curve_doubt("the load factor jumps"),
    a.curve_end(0.1, 0.05),
    a.anchorages(["bar 0", "bar 1"]),
    a.out_of_plane(),
    a.masses_differ(414e3, 324e3),
    a.small_motions(35.3e3, 195.3e3, 0.0306, e_star=1.0, a0_star=0.7264),
    a.other_motion(0.1, 0.104, 0.98, 2),
    a.other_motion(0.1, 0.1, 0.98, 1),
    a.separate_mechanisms(2, [("body 2 (wall 1)", 0.8), ("body 1 (wall 0)", 1.2)], []),
    a.separate_mechanisms(2, [("body 2 (wall 1)", 0.8)], ["body 1 (wall 0)"]),
    a.floor_below_ground(1.0, 1.765),
    a.ground_at_height(3.0, on_support=False),
    a.ground_at_height(9.0, on_support=True),
    a.floor_on_ground(2.0, 1.765),
    a.range_of_load_factor("0.08 to 0.1"),
    a.run_unsettled("half steps", "0.08", 1.25),
    a.run_unsettled("half steps", "0.08", 0.8),
    a.control_point(0.354, 0.3),
    a.overturns_alone(0.35, 0.25),
    a.state_left_out("SLV", "The last period is 2 s"),
    a.state_missed("SLD", 0.99996, "not satisfied"),
    a.changed_coefficients([("behaviour factor q", 1.5, 2.0, "C8.7.1.2.1.7")]),
    a.direction_without("push +x", Status.UNSTABLE),
    a.direction_unsettled("push +x", 3.477, 2.181, is_limit=True),
    a.direction_unsettled("push +x", 3.477, 2.181, is_limit=False),
    a.direction_open("push +x", 3.477, 2),
    a.unit_size(0.6, 0.8995),
    a.hand_is_higher(4.0),
    a.hand_is_lower(0.0784, 0.1),
    a.edge_is_long(5.0, 2.5, 0.1, 0.09),
    a.edge_overhangs(),
    a.edge_is_high(1.0, "façade", 2),
]

MOMENT = Answer("reaction", "R", "moment")
VARIES = Outcome(Status.NOT_CONVERGED, np.nan, Reason.NEVER_SETTLES, drift=(0.385, 0.4017))
DOUBTS = (0.01, 0.02), (0.3, 0.4), 0.02
A_G = ("0.1235 g", "0.15 g")


def least_ties(force, status="solved", what="load factor", *, flow=False, proven=False):
    state = SolverStatus(status)
    return mechanism_text.least_ties_sentence(0.5, {"tie": force}, state, what, is_associative=flow, proven=proven)


SENTENCES = [
    *(str(case_text.DoubtfulPart(doubt, *DOUBTS, "fictitious", has_ties=True)) for doubt in CurveDoubt),
    str(case_text.DoubtfulPart(CurveDoubt.RISES, *DOUBTS, "loading path", has_ties=False)),
    least_ties(5e3, flow=True, proven=True),
    least_ties(np.nan, "infeasible", "dead load", flow=True),
    least_ties(np.nan, "failed", flow=True),
    least_ties(5e3, what="dead load", flow=True, proven=True),
    least_ties(5e3, flow=True),
    least_ties(5e3, proven=True),
    least_ties(5e3, what="both", flow=True),
    mechanism_text.tie_sentence("left", 4e4, 4e4, "yield", "yielding", 0.5, 0.03, 0.06),
    a.state_outcome("SLV, linear", np.nan, satisfied=False),
    a.state_outcome("SLV, linear", 1.2, satisfied=True),
    a.state_outcome("SLV, linear", 0.9, satisfied=True),
    a.state_outcome("SLV, linear", 0.9, satisfied=False),
    a.state_outcome("SLV, linear", 1.2, satisfied=False),
    a.verdict("SLD", 0.823, "not satisfied", 1.211, A_G, of_sld=False),
    a.verdict("SLD", 0.823, "not satisfied", 1.211, A_G, of_sld=True),
    a.unit_sizes("load factor", [1.2, 0.6, 0.4], [0.327, 0.294, 0.277], 0.2545, 0.003),
    a.building_interrupted(["push +x"], None),
    a.building_interrupted([], "b.h5"),
    headline(VARIES).text(),
    headline(replace(VARIES, reason=Reason.JAMS)).text(),
    report.no_number("push", Status.UNSTABLE, LOAD_FACTOR, cases=1, checks=0),
    report.no_number("push", Status.UNSTABLE, LOAD_FACTOR, cases=3, checks=2),
    report.no_number("x", Status.COLLAPSES, LOAD_FACTOR, cases=2, checks=0),
    report.no_number("x", Status.UNDECIDED, LOAD_FACTOR, cases=1, checks=0),
    report.no_number("x", Status.STANDS, LOAD_FACTOR, cases=2, checks=0),
    study.sample_line("push", 20, 20, 0.3, 0.0123),
    study.sample_line("push", 20, 18, 0.3, 0.01),
    study.fractile_line(0.05, 0.25, (-np.inf, np.nan), 0.95),
    " to ".join(MOMENT.ends((2256.8, 456.3))),
    MOMENT.format(-456.3, alongside=np.inf),
    MOMENT.format(-456.3),
]


def pinned(name):
    return Path(__file__).with_name(name).read_text(encoding="utf-8").splitlines()


def test_the_words_of_every_note():
    assert [f"{note.code} ({note.severity}): {note}" for note in NOTES] == pinned("notes.txt")
    assert {note.code for note in NOTES} == set(NoteCode) - {NoteCode.MASSES}


def test_the_words_of_other_sentences():
    assert pinned("sentences.txt") == SENTENCES


def test_effects_below_one_percent_have_no_note():
    assert note_text.effect_note(NoteCode.CORNER_TORSION, 0.5, 0.4951, LOAD_FACTOR) is None
    assert note_text.effect_note(NoteCode.CORNER_TORSION, 0.5, 0.4949, LOAD_FACTOR) is not None


def test_a_settled_bounded_number_has_no_caveat():
    assert caveats(SETTLED) == caveats(UNBOUNDED, bound=INF, is_searched=False) == ()


def test_every_end_has_its_sentence():
    for status in Status:
        for reason in Reason:
            outcome = Outcome(status, 0.3, reason, Procedure.FICTITIOUS, path_end=PathEnd.CLOSED)
            assert headline(outcome).why
            assert headline(outcome).text()
        assert case_text.certificate_sentence(None, status).endswith(".")
    ends = {headline(Outcome(*FIRST, Procedure.FICTITIOUS, path_end=end)).text() for end in PathEnd}
    assert len(ends) == len(PathEnd)


@pytest.mark.parametrize(
    ("radii", "words"),
    [
        ([0], "corners stay sharp."),
        ([0.02], "corners have a radius of 20 mm."),
        ([0, 0.02], "corners have a radius of none in push 0, 20 mm in push 1."),
    ],
)
def test_assumptions_on_corners(small_model, radii, words):
    dead, pushed = bs.LoadPattern("dead", [bs.SelfWeight()]), bs.LoadPattern("push", [bs.BodyForce("+x")])
    cases = [
        bs.Pushover(f"push {k}", dead, pushed, control=("1.1", (1, 0, 0)), corner_rounding=f"{radius} m")
        for k, radius in enumerate(radii)
    ]
    sentences = assumptions_text.assumption_sentences(small_model, cases, has_curve=True)
    (sentence,) = [s for s in sentences if "finite displacements" in s]
    assert sentence.endswith(words)


def test_a_reaction_of_rounding_is_zero():
    reaction = Answer("reaction", "R", "force", -5e4)
    assert [reaction.text(alpha) for alpha in (1e-14, -0.5)] == ["0 N", "25 kN"]
    assert reaction.ends((1e-14, -0.5)) == ("0 kN", "25 kN")
