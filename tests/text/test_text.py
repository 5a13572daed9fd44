"""The words of every note and of the other sentences on results, each pinned once: the notes in ``notes.txt``."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blockstruct.limit import Outcome
from blockstruct.text import assessment as a
from blockstruct.text import assumptions as assumptions_text
from blockstruct.text import case as case_text
from blockstruct.text import mechanism as mechanism_text
from blockstruct.text import note as note_text
from blockstruct.text import report, study
from blockstruct.text.note import NoteCode
from blockstruct.text.numbers import LOAD_FACTOR, Answer
from blockstruct.vocabulary import CurveDoubt, PathEnd, Procedure, Reason, SolverStatus, Status

REACTION = Answer("reaction", "R", "force", -1e3)
FIRST, INF = (Status.CONVERGED, 0.5, Reason.CERTIFIED), np.inf
SETTLED = Outcome(*FIRST, Procedure.LOADING_PATH, settled=True)
DRIFTING = Outcome(*FIRST, Procedure.LOADING_PATH)
STANDS_IN = Outcome(*FIRST, Procedure.FICTITIOUS, settled=True, path_end=PathEnd.LIMIT_REACHED)
RAISED = Outcome(*FIRST, Procedure.LOADING_PATH, drift=(0.6, 0.6), without_crushing=0.5)
UNBOUNDED = Outcome(Status.UNBOUNDED, INF, Reason.GROWS_WITHOUT_LIMIT)


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


def test_the_words_of_every_note():
    pinned = Path(__file__).with_name("notes.txt").read_text(encoding="utf-8").splitlines()
    assert [f"{note.code} ({note.severity}): {note}" for note in NOTES] == pinned
    assert {note.code for note in NOTES} == set(NoteCode) - {NoteCode.MASSES}


def test_effects_below_one_percent_have_no_note():
    assert note_text.effect_note(NoteCode.CORNER_TORSION, 0.5, 0.4951, LOAD_FACTOR) is None
    assert note_text.effect_note(NoteCode.CORNER_TORSION, 0.5, 0.4949, LOAD_FACTOR) is not None


def test_a_settled_bounded_number_has_no_caveat():
    assert caveats(SETTLED) == caveats(UNBOUNDED, bound=INF, is_searched=False) == ()


@pytest.mark.parametrize(
    ("ratio", "satisfied", "words"),
    [
        (np.nan, False, "not checked: no spectrum of this limit state"),
        (1.2, True, "satisfied"),
        (0.9, True, "below 1, but satisfied: a_g,SLV counts as no less than a_g,SLD (C8.7.1.2.1.8)"),
        (0.9, False, "not satisfied"),
        (1.2, False, "not satisfied: a weaker ground motion already demands as much"),
    ],
)
def test_outcomes_of_limit_states(ratio, satisfied, words):
    assert a.state_outcome("SLV, linear", ratio, satisfied=satisfied) == words


def test_every_end_has_its_sentence():
    for status in Status:
        for reason in Reason:
            outcome = Outcome(status, 0.3, reason, Procedure.FICTITIOUS, path_end=PathEnd.CLOSED)
            assert case_text.why(outcome, LOAD_FACTOR)
            assert case_text.sentence(outcome, LOAD_FACTOR)
        assert case_text.certificate_sentence(None, status, LOAD_FACTOR, has_ties=False).endswith(".")
    ends = {case_text.sentence(Outcome(*FIRST, Procedure.FICTITIOUS, path_end=end), LOAD_FACTOR) for end in PathEnd}
    assert len(ends) == len(PathEnd)


@pytest.mark.parametrize(
    ("reason", "words"),
    [
        (Reason.NEVER_SETTLES, "from 0.385 to 0.4017 over the last tenfold displacement, and not settled"),
        (Reason.JAMS, "still rising at 0.4017, the blocks jam"),
    ],
)
def test_a_load_factor_that_varies_jams_only_without_a_bound(reason, words):
    varies = Outcome(Status.NOT_CONVERGED, np.nan, reason, drift=(0.385, 0.4017))
    assert case_text.sentence(varies, LOAD_FACTOR) == f"no load factor: {words}"


def test_the_ends_of_a_range_have_one_unit():
    moment = Answer("reaction", "R", "moment")
    assert moment.ends((2256.8, 456.3)) == ("0.4563 kN·m", "2.257 kN·m")
    assert moment.format(-456.3, alongside=np.inf) == moment.format(-456.3) == "-456.3 N·m"


@pytest.mark.parametrize(("of_sld", "at"), [(False, "equal at a_g"), (True, "borne is a_g = a_g,SLD")])
def test_verdicts(of_sld, at):
    assert a.verdict("SLD", 0.823, "not satisfied", 1.211, ("0.1235 g", "0.15 g"), of_sld=of_sld) == (
        f"SLD: capacity / demand = 0.823, not satisfied; {at} = 1.211 m/s² = 0.1235 g (site 0.15 g)."
    )


def test_doubts_on_a_curve():
    facts = (0.01, 0.02), (0.3, 0.4), 0.02, "fictitious"
    clauses = [f"{doubt}: {case_text.doubtful_part(doubt, *facts, has_ties=True)}" for doubt in CurveDoubt]
    assert clauses == Path(__file__).with_name("doubts.txt").read_text(encoding="utf-8").splitlines()
    alone = case_text.doubtful_part(CurveDoubt.RISES, *facts[:3], "loading path", has_ties=False)
    assert alone == clauses[1].removeprefix("rises: ").split(", or ")[0]


LEAST_TIES = [
    (5e3, "solved", "load factor", True, True),
    (np.nan, "infeasible", "dead load", True, False),
    (np.nan, "failed", "load factor", True, False),
    (5e3, "solved", "dead load", True, True),
    (5e3, "solved", "load factor", True, False),
    (5e3, "solved", "load factor", False, True),
    (5e3, "solved", "both", True, False),
]


def test_least_ties():
    sentences = [
        mechanism_text.least_ties_sentence(
            0.5, {"tie": force}, SolverStatus(status), what, is_associative=flow, proven=proven
        )
        for force, status, what, flow, proven in LEAST_TIES
    ]
    assert sentences == Path(__file__).with_name("least_ties.txt").read_text(encoding="utf-8").splitlines()


def test_unit_sizes():
    sizes, values = [1.2, 0.6, 0.4], [0.327, 0.294, 0.277]
    assert a.unit_sizes("load factor", sizes, values, 0.2545, 0.003) == (
        "With units of 1.2 m the load factor is 0.327. 0.6 m gives -10%; 0.4 m gives -15%. A fine bond would give "
        "about 0.2545 ± 0.003."
    )


def test_an_interrupted_building():
    assert a.building_interrupted(["push +x"], None).startswith("1 run ended (push +x): give a store")
    assert a.building_interrupted([], "b.h5").startswith("b.h5 keeps what was done, no run ended")


def test_a_tie_that_reaches_its_limit():
    lengthens = {"lengthens": 0.5, "elongation_limit": 0.03, "at": 0.06}
    assert mechanism_text.tie_sentence("left", "yielding", 4e4, 4e4, "yield", **lengthens) == (
        "Tie left: yielding, 40 kN of 40 kN (yield); it lengthens by 0.5 times the largest block displacement and "
        "reaches its limit of 30 mm at 60 mm, to first order."
    )


@pytest.mark.parametrize(
    ("radii", "words"),
    [
        ([0], "corners stay sharp."),
        ([0.02], "corners have a radius of 20 mm."),
        ([0, 0.02], "corners have a radius of none in push 0, 20 mm in push 1."),
    ],
)
def test_assumptions_on_corners(small_model, radii, words):
    flags = ("settles", "pushes", "is_associative", "is_nonassociative", "rotates", "is_checked")
    corners = {f"push {k}": radius for k, radius in enumerate(radii)}
    scope = assumptions_text.Scope(**dict.fromkeys(flags, False), has_curve=True, corners=corners)
    (sentence,) = [
        s for s in assumptions_text.assumption_sentences(small_model, scope, [], [], "") if "finite displacements" in s
    ]
    assert sentence.endswith(words)


def test_the_first_page_without_a_number():
    alone = report.no_number("push", Status.UNSTABLE, LOAD_FACTOR, cases=1, checks=0)
    assert alone == "There is no load factor to rely on: “push” is unstable under dead load."
    others = report.no_number("push", Status.UNSTABLE, LOAD_FACTOR, cases=3, checks=2)
    assert others == (
        "There is no load factor to rely on: “push” is unstable under dead load, the worst of 3 cases. The "
        "verification is not satisfied. The 2 checks of other cases do not cover it."
    )


@pytest.mark.parametrize(
    ("status", "cases", "words"),
    [
        (Status.COLLAPSES, 2, "The structure collapses in “x”, the worst of 2 cases."),
        (Status.UNDECIDED, 1, "It is undecided whether the structure stands in “x”."),
        (Status.STANDS, 2, "The structure stands in all of 2 cases. It moves furthest in “x”. The response "),
    ],
)
def test_the_first_page_of_a_record(status, cases, words):
    assert report.no_number("x", status, LOAD_FACTOR, cases=cases, checks=0).startswith(words)


def test_lines_on_samples():
    assert study.sample_line("push", 20, 20, 0.3, 0.0123) == "push: 20 runs, mean 0.3, standard deviation 0.012"
    assert study.sample_line("push", 20, 18, 0.3, 0.01).endswith(" of the 18 with a finite load factor")
    line = study.fractile_line(0.05, 0.25, (-np.inf, np.nan), 0.95)
    assert line == "5% fractile 0.25 (95% confidence: −∞ to none)"
