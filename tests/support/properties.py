"""How many examples hypothesis tries: a few by default, ten times as many with ``--hypothesis-profile=wide``."""

from hypothesis import HealthCheck, settings

#: Examples of the default profile, of which a test takes a share.
USUAL = 100

settings.register_profile(
    "usual", max_examples=USUAL, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
settings.register_profile("wide", settings.get_profile("usual"), max_examples=10 * USUAL, derandomize=False)


def few(count: int) -> settings:
    """Settings of a test for so many examples; ten times as many, and others every time, in the wide profile."""
    return settings(max_examples=count * settings.default.max_examples // USUAL)
