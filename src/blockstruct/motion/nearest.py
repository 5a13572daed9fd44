"""Find the contact points that continue earlier ones."""

from collections.abc import Callable

import numpy as np

from blockstruct.arrays import Array, Index

#: Two blocks of each contact point.
Ends = tuple[Index, Index]


def nearest(before: Ends, after: Ends, distance: Callable[[Index, Index], Array]) -> tuple[Index, Index, Array]:
    """Return earlier contact points, the nearest later one of the same two blocks to each, and their distances.

    Earlier points without a later one of their blocks are left out.

    Parameters
    ----------
    before, after
        The blocks of the points; their order does not matter.
    distance
        Returns the distances of pairs of an earlier and a later point, given by their indices.
    """
    if not len(before[0]) or not len(after[0]):
        none = np.empty(0, dtype=np.int64)
        return none, none, np.empty(0)
    n = 1 + max(int(block.max()) for block in (*before, *after))
    wanted, code = (np.minimum(*ends) * n + np.maximum(*ends) for ends in (before, after))
    # The later points of the same two blocks are a range of the points that are sorted by their blocks.
    order = np.argsort(code, kind="stable")
    first, last = (np.searchsorted(code[order], wanted, side) for side in ("left", "right"))
    count = last - first
    row = np.repeat(np.arange(len(wanted)), count)
    at = order[np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)]
    apart = distance(row, at)
    chosen = np.lexsort((apart, row))
    chosen = chosen[np.append(True, np.diff(row[chosen]) > 0)] if len(chosen) else chosen
    return row[chosen], at[chosen], apart[chosen]
