"""A façade, free, of small blocks and tied, pushed out of its plane and checked."""

from functools import partial

import numpy as np

import blockstruct as bs
import structures
from blockstruct import Q_
from structures import SELF_WEIGHT, model_of, push

STONE, DRY = bs.Material("stone", "18 kN/m^3"), bs.JointMaterial("dry", 0.7)
SITE = bs.assess.ntc_spectrum(Q_(0.15, "g_0"), 2.4, "0.3 s", "B")
#: Façade 5 m × 0.6 m × 6 m, and its edge at the foot, outside.
LENGTH, DEPTH, HEIGHT = 5.0, 0.6, 6.0
EDGE = Q_([[0, 0, 0], [LENGTH, 0, 0]], "m")
#: A check takes the remedies of torsion and crushing.
solve = partial(structures.solve, effects=True)


def box(name, origin, size, *, fixed=False):
    return bs.Block.box(name, Q_(origin, "m"), Q_(size, "m"), STONE, fixed=fixed)


GROUND = box("ground", [-5, -5, -1], [15, 15, 1], fixed=True)


def facade(joint=DRY):
    return model_of([GROUND, box("façade", [0, 0, 0], [LENGTH, DEPTH, HEIGHT])], joint, "façade")


def portal():
    """Columns of 27 kN, and a lintel of 22.5 kN on them."""
    columns = (box(f"column {x}", [x, 0, 0], [0.5, 1, 3]) for x in (0, 2))
    return model_of([GROUND, *columns, box("lintel", [0, 0, 3], [2.5, 1, 0.5])], DRY)


def small_blocks(joint=DRY, courses=12):
    size = {"length": Q_(LENGTH, "m"), "unit_height": Q_(HEIGHT / courses, "m"), "thickness": Q_(DEPTH, "m")}
    blocks = bs.wall(**size, unit_length="1 m", courses=courses, material=STONE)
    return model_of(blocks, joint, "façade of small blocks")


def case(variable=None, dead=SELF_WEIGHT, flow="nonassociative"):
    return bs.LimitCase("out of plane", dead, push(0, -1, 0) if variable is None else variable, flow)


def run(model, of=None):
    return bs.AnalysisManager(model).run([of or case()])["out of plane"]


def codes(check):
    return [note.code for note in check.notes]


def checked(result, *args, **more):
    """The check without crushing, at the site of the tests."""
    return bs.assess.local_mechanism(result, 1.35, SITE, *args, **more)


def by_hand(result, edge=EDGE, **more):
    """The whole façade about an edge."""
    return bs.assess.overturning(result.model, result.case, ["façade"], edge, **more)


def tied(breaks_at=None, force=20, bars=1, to=(4, 5), fixed=False, joint=DRY, **more):
    """The façade with ties at 5 m to a wall 4 m behind it, or to another point (y, z)."""
    back = box("back", [0, min(to[0], 4), 0], [LENGTH, 3, max(HEIGHT, to[1])], fixed=fixed)
    blocks = [*facade().blocks, back]
    more |= {"yield_force": Q_(force, "kN")}
    more |= {} if breaks_at is None else {"elongation_limit": Q_(breaks_at, "m")}
    ties = [
        bs.Tie(f"bar {k}", ("façade", Q_([x, 0, 5], "m")), ("back", Q_([x, *to], "m")), **more)
        for k, x in enumerate(np.linspace(0, LENGTH, bars + 2)[1:-1])
    ]
    return model_of(blocks, joint, "tied façade").with_ties(ties)


def pushed_over(model, steps=10, block="façade", **more):
    """The pushover by the displacement of a block along the push."""
    pushed = bs.Pushover("out of plane", SELF_WEIGHT, push(0, -1, 0), control=(block, (0, -1, 0)), steps=steps, **more)
    return bs.run(model, pushed)["out of plane"]
