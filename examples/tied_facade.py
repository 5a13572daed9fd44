"""A façade that only leans against its sidewalls, before and after two ties at its top.

The ties run from plates on the façade to the far ends of the sidewalls. They nearly double the load factor, and do not
yield: the push now drags the upper courses of the sidewalls along. Stronger bars would be worth nothing.
"""

import blockstruct as bs
from blockstruct import Q_


def facade() -> bs.Model:
    tuff = bs.Material("tuff", unit_weight=Q_(12, "kN/m^3"))
    joints = {"base|*": bs.JointMaterial("ground", 0.6), "*": bs.JointMaterial("lime mortar", 0.65)}
    door = bs.structures.Opening(start="1.2 m", sill="0 m", width="0.8 m", height="1.6 m")
    sides = [
        bs.structures.Sidewall(name, at, "1.6 m", bonded=False) for name, at in (("left", "0 m"), ("right", "3 m"))
    ]
    size = {"unit_length": "40 cm", "unit_height": "20 cm", "thickness": "20 cm"}
    blocks = bs.wall(length="3.2 m", courses=12, **size, openings=[door], sidewalls=sides, material=tuff)
    return bs.Model("façade with butted sidewalls", blocks, bs.detect_interfaces(blocks, joints))


def ties() -> list[bs.Tie]:
    bar = {
        "area": Q_(201, "mm^2"),
        "strength": Q_(235, "MPa"),
        "punching_force": Q_(8, "kN"),
        "elongation_limit": Q_(40, "mm"),
    }
    return [
        bs.Tie(f"{side} tie", (block, Q_([x, 0, 2.1], "m")), (f"{side}.11.4", Q_([x, 1.8, 2.1], "m")), **bar)
        for side, block, x in (("left", "11.1", 0.1), ("right", "11.8", 3.1))
    ]


def main() -> dict[str, float]:
    model = facade().with_ties(ties())
    dead = bs.LoadPattern("dead", [bs.SelfWeight()])
    case = bs.LimitCase("push -y", dead, bs.LoadPattern("push -y", [bs.BodyForce("-y")]))

    both = bs.ties.with_and_without(model, [case])
    print(both)
    tied, bare = both.with_ties["push -y"], both.without_ties["push -y"]
    print(tied.ties[["force [newton]", "capacity [newton]", "governing", "state"]].to_string())

    least = bs.ties.least_tie_force(model, case, ["left tie", "right tie"], load_factor=0.12)
    print(least)
    return {
        "without": bare.load_factor,
        "with": tied.load_factor,
        "without, associative": bare.associative_load_factor,
        "with, associative": tied.associative_load_factor,
        "tie force": float(tied.ties["force [newton]"].max()),
        "least tie force": least.total,
    }


if __name__ == "__main__":
    main()
