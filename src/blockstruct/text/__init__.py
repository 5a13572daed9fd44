"""Facts to sentences: the only room that words results.

Every function takes facts and returns text or a :class:`Note`. Nothing reads a text back.
"""

from blockstruct.text import assessment, report, study
from blockstruct.text.answer import LOAD_FACTOR, Answer
from blockstruct.text.assumptions import Scope, assumption_sentences, masses_below
from blockstruct.text.case import (
    admissible_state,
    capitalised,
    certificate_sentence,
    ended,
    found_by,
    no_curve,
    pushed_states,
    range_text,
    response_sentences,
    sentence,
    settled_schedules,
    statics_range,
    tilting_table,
    why,
)
from blockstruct.text.caveats import caveats
from blockstruct.text.curve import curve_end, doubtful_part
from blockstruct.text.joints import EFFECT, biaxial_note, cells_note, effect_note, torsion_note
from blockstruct.text.masses import pushed_masses
from blockstruct.text.mechanism import (
    NO_COLLAPSE_STATE,
    SMALL,
    STEPS_OF_PATH,
    STEPS_OF_PROGRAMS,
    body_sentences,
    direction_text,
    failure_clause,
    joints_sentence,
    more_ties,
    motion_clause,
    moving_sentence,
    smaller_bodies,
)
from blockstruct.text.note import Note, NoteCode, Severity
from blockstruct.text.numbers import BEYOND, FEW, LISTED, in_g, ratio_text, shown, told_apart
from blockstruct.text.ties import (
    breaking_clause,
    holding_ties,
    kilonewton,
    least_ties_sentence,
    more_breaks,
    roller_sentences,
    tie_sentence,
    tie_title,
)

__all__ = [
    # numbers
    "BEYOND",
    "FEW",
    "in_g",
    "ratio_text",
    "shown",
    "told_apart",
    # notes
    "assessment",
    "Note",
    "NoteCode",
    "Severity",
    "biaxial_note",
    "caveats",
    "cells_note",
    "EFFECT",
    "effect_note",
    "torsion_note",
    # reports
    "Scope",
    "assumption_sentences",
    "masses_below",
    "report",
    "study",
    # cases
    "admissible_state",
    "capitalised",
    "certificate_sentence",
    "curve_end",
    "doubtful_part",
    "no_curve",
    "pushed_masses",
    "pushed_states",
    "response_sentences",
    "settled_schedules",
    "statics_range",
    "tilting_table",
    # the number of a case
    "LOAD_FACTOR",
    "Answer",
    "ended",
    "found_by",
    "range_text",
    "sentence",
    "why",
    # mechanisms
    "LISTED",
    "SMALL",
    "NO_COLLAPSE_STATE",
    "STEPS_OF_PATH",
    "STEPS_OF_PROGRAMS",
    "body_sentences",
    "direction_text",
    "failure_clause",
    "joints_sentence",
    "more_ties",
    "motion_clause",
    "moving_sentence",
    "smaller_bodies",
    # supports
    "holding_ties",
    "roller_sentences",
    # ties
    "breaking_clause",
    "least_ties_sentence",
    "more_breaks",
    "kilonewton",
    "tie_sentence",
    "tie_title",
]
