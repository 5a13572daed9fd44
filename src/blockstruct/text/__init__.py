"""Facts to sentences: the only room that words results.

Every function takes facts and returns text or a :class:`Note`. Nothing reads a text back.
"""
