"""The façade of the hand calculations, run once."""

import pytest

from facades import facade, run


@pytest.fixture(scope="session")
def result():
    return run(facade())
