"""Facts to sentences: the only room that words results.

Every function takes facts and returns text or a :class:`Note`. Nothing reads a text back.
"""

from blockstruct.text import assessment, report, study
from blockstruct.text.assumptions import Scope, assumption_sentences, masses_below
from blockstruct.text.case import (
    admissible_state,
    capitalised,
    certificate_sentence,
    curve_end,
    doubtful_part,
    ended,
    found_by,
    no_curve,
    pushed_masses,
    pushed_states,
    range_text,
    response_sentences,
    sentence,
    settled_schedules,
    statics_range,
    tilting_table,
    why,
)
from blockstruct.text.mechanism import (
    NO_COLLAPSE_STATE,
    SMALL,
    STEPS_OF_PATH,
    STEPS_OF_PROGRAMS,
    body_sentences,
    breaking_clause,
    crushed_joints,
    direction_text,
    failure_clause,
    holding_ties,
    joints_sentence,
    kilonewton,
    least_ties_sentence,
    more_breaks,
    more_ties,
    motion_clause,
    moving_sentence,
    roller_sentences,
    smaller_bodies,
    tie_sentence,
    tie_title,
)
from blockstruct.text.note import (
    EFFECT,
    Note,
    NoteCode,
    Severity,
    biaxial_note,
    caveats,
    cells_note,
    effect_note,
    torsion_note,
)
from blockstruct.text.numbers import BEYOND, LOAD_FACTOR, Answer, in_g, ratio_text, shown, told_apart

__all__ = ["BEYOND", "in_g", "ratio_text", "shown", "told_apart"]
__all__ += ["assessment", "Note", "NoteCode", "Severity", "biaxial_note", "caveats", "cells_note", "EFFECT"]
__all__ += ["effect_note", "torsion_note"]
__all__ += ["Scope", "assumption_sentences", "masses_below", "report", "study"]
__all__ += ["admissible_state", "capitalised", "certificate_sentence", "curve_end", "doubtful_part", "no_curve"]
__all__ += ["pushed_masses", "pushed_states", "response_sentences", "settled_schedules", "statics_range"]
__all__ += ["tilting_table"]
__all__ += ["LOAD_FACTOR", "Answer", "ended", "found_by", "range_text", "sentence", "why"]
__all__ += ["SMALL", "NO_COLLAPSE_STATE", "STEPS_OF_PATH", "STEPS_OF_PROGRAMS", "body_sentences"]
__all__ += ["direction_text", "failure_clause", "joints_sentence", "more_ties", "motion_clause", "moving_sentence"]
__all__ += ["smaller_bodies"]
__all__ += ["crushed_joints", "holding_ties", "roller_sentences"]
__all__ += ["breaking_clause", "least_ties_sentence", "more_breaks", "kilonewton", "tie_sentence", "tie_title"]
