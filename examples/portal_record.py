"""A portal of two columns and a lintel under a ground motion: whether it stands, and how far it moves.

The record is a synthetic one: a sine of one second that swells and fades. Replace it by a recorded one,
``Q_(values, "g_0")`` with the time between its samples.
"""

import numpy as np

import blockstruct as bs
from blockstruct import Q_


def portal() -> bs.Model:
    """Two columns of three drums and a lintel: 3 m wide, 3.3 m high."""
    stone = bs.Material("limestone", unit_weight=Q_(24, "kN/m^3"))
    blocks = [bs.Block.box("ground", Q_([-1, -1, -0.3], "m"), Q_([5, 2.6, 0.3], "m"), stone, fixed=True)]
    for side, x in (("left", 0.0), ("right", 2.4)):
        for k in range(3):
            origin, size = Q_([x, 0, 0.9 * k], "m"), Q_([0.6, 0.6, 0.9], "m")
            blocks.append(bs.Block.box(f"{side} {k}", origin, size, stone))
    blocks.append(bs.Block.box("lintel", Q_([0, 0, 2.7], "m"), Q_([3, 0.6, 0.6], "m"), stone))
    return bs.Model("portal", blocks, bs.detect_interfaces(blocks, bs.JointMaterial("dry joint", 0.7)))


def main() -> dict[str, bs.Status]:
    """Status of the portal under the record and its multiples."""
    t = np.arange(0, 3, 0.01)
    record = 0.2 * np.sin(2 * np.pi * t) * np.sin(np.pi * t / 3)
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    one = bs.RecordCase("record", dead, Q_(record, "g_0"), time=Q_(0.01, "s"), direction="+x")
    analysis = bs.run(portal(), [one, one.scaled(2), one.scaled(7)])
    for result in analysis.values():
        print(result.describe(), end="\n\n")
    return {result.name: result.status for result in analysis.values()}


if __name__ == "__main__":
    main()
