"""What the tests of views share."""

from functools import lru_cache
from io import BytesIO

import pytest
from matplotlib.figure import Figure

from blockstruct.views.figures.sheet import Drawing


@pytest.fixture
def blank_pictures(monkeypatch):
    """Pictures of a report are drawn, and take their place on its pages, but are not turned into pixels."""

    def blank(drawing):
        drawing.draw(Figure(figsize=drawing.size).add_subplot(projection=drawing.projection))
        return white(drawing.size)

    monkeypatch.setattr(Drawing, "picture", blank)


@lru_cache
def white(size):
    stream = BytesIO()
    Figure(figsize=size).savefig(stream, format="png", dpi=200)
    return stream.getvalue()
