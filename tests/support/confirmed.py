"""Whatever a procedure finds must stand the checks of a file."""

import pytest

from blockstruct.analysis import AnalysisManager
from blockstruct.results import contradictions


@pytest.fixture(autouse=True)
def confirmed(monkeypatch):
    run = AnalysisManager.run

    def checked(manager, *args, **options):
        analysis = run(manager, *args, **options)
        assert contradictions(analysis) == []
        return analysis

    monkeypatch.setattr(AnalysisManager, "run", checked)
