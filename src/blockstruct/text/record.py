"""Sentences on the response to a record."""

from collections.abc import Sequence

from blockstruct.vocabulary import listed


def response_sentences(
    *,
    largest: tuple[float, str],
    remaining: tuple[float, str],
    fallen: Sequence[str],
    end: float,
    step: float,
    steps: int,
) -> list[str]:
    """Return the sentences on a response.

    Parameters
    ----------
    largest, remaining
        Largest displacement during the motion and at its end, m, each with its block.
    fallen
        Blocks that have fallen.
    end
        Time of the last state, s.
    step, steps
        Length of the steps, s, and their number.

    Examples
    --------
    >>> at = {"largest": (0.12, "b2"), "remaining": (0.002, "b1")}
    >>> print(*response_sentences(**at, fallen=[], end=8, step=2e-3, steps=4100))
    The largest displacement is 120 mm, of b2. At the end, 8 s, 2 mm remain, of b1. It took 4100 steps of at most 2 ms.
    """
    found = [f"The largest displacement is {1e3 * largest[0]:.4g} mm, of {largest[1]}."]
    if fallen:
        found.append(f"At {end:.4g} s {listed(fallen, 3)} {'has' if len(fallen) == 1 else 'have'} fallen.")
    else:
        found.append(f"At the end, {end:.4g} s, {1e3 * remaining[0]:.4g} mm remain, of {remaining[1]}.")
    return [*found, f"It took {steps} steps of at most {1e3 * step:.4g} ms."]
