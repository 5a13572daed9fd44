"""The façade of the hand calculations, run once."""

import pytest

from facades import facade, run, small_blocks


@pytest.fixture(scope="session")
def result():
    return run(facade())


@pytest.fixture(scope="session")
def small():
    return run(small_blocks())
