"""Facts to sentences: the only room that words the outcome of a case.

Every function takes facts and returns text. Nothing reads a text back.
"""

from blockstruct.text.answer import LOAD_FACTOR, Answer
from blockstruct.text.caveats import caveats
from blockstruct.text.curve import curve_end
from blockstruct.text.ending import ended, found_by, range_text, sentence, why

__all__ = ["LOAD_FACTOR", "Answer", "caveats", "curve_end", "ended", "found_by", "range_text", "sentence", "why"]
