"""How much tests try: hypothesis a few examples, twenty times as many with ``--hypothesis-profile=wide``."""

import pytest
from hypothesis import HealthCheck, settings

#: Examples of which a test names its share; by default half of them are tried.
ALL = 100

settings.register_profile(
    "usual", max_examples=ALL // 2, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
settings.register_profile("wide", settings.get_profile("usual"), max_examples=10 * ALL, derandomize=False)


def few(count: int) -> settings:
    """Settings of a test for half of so many examples; for ten times as many, and others, in the wide profile."""
    return settings(max_examples=count * settings.default.max_examples // ALL)


def slow_after(first: object, *others: object) -> list[object]:
    """Values of a parameter, all but the first one of slow tests."""
    return [first, *(pytest.param(value, marks=pytest.mark.slow) for value in others)]
