"""Numbers as text, and how many names a text lists."""

import numpy as np

#: Names that a sentence lists, and names or bodies that a list has, before it counts the rest.
FEW, LISTED = 3, 5
#: An acceleration beyond the largest that a check tries.
BEYOND = "more than 10 g"


def shown(value: float, unit: str = "") -> str:
    """Return a number to four digits, with its unit.

    >>> shown(0.123456, "m/s²")
    '0.1235 m/s²'
    """
    return f"{value:.4g} {unit}".rstrip()


def told_apart(value: float, limit: float, digits: int = 4) -> tuple[str, str]:
    """Return a value and its limit with enough digits to distinguish them.

    >>> told_apart(0.99996, 1.0)
    ('0.99996', '1')
    >>> told_apart(1.5, 1.0)
    ('1.5', '1')
    """
    # 17 digits distinguish any two doubles.
    texts = [(f"{value:.{n}g}", f"{limit:.{n}g}") for n in range(digits, 18)]
    return next((pair for pair in texts if pair[0] != pair[1]), texts[0])


def ratio_text(ratio: float, digits: int = 4) -> str:
    """Return capacity over demand with enough digits to show on which side of one it lies."""
    return told_apart(ratio, 1.0, digits)[0]


def in_g(acceleration: float, gravity: float) -> str:
    """Return an acceleration in m/s² and as a share of gravity."""
    if np.isinf(acceleration):
        return BEYOND
    return f"{acceleration:.4g} m/s² = {acceleration / gravity:.4g} g"
