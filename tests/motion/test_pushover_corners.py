"""Pushovers of blocks with inner corners, which touch others at one point in two directions, and hinges that leap."""

import numpy as np
import pytest
from scipy.optimize import brentq

import blockstruct as bs
from blockstruct.structures.builder import prism
from structures import SELF_WEIGHT, STONE, box, model_of, moved, push, rotation

#: The procedure whose collapse state these curves begin with.
FICTITIOUS = bs.ProcedureSettings(procedure="fictitious")


def notched(friction):
    """A block of 1 m by 1.5 m on two supports, whose step it embraces: 0.2 m high, in the middle."""
    outline = [[0, 0], [0.5, 0], [0.5, 0.2], [1, 0.2], [1, 1.5], [0, 1.5]]
    supports = [
        box("low", [-1, 0, -0.5], [1.5, 1, 0.5], fixed=True),
        box("high", [0.5, 0, -0.5], [3, 1, 0.7], fixed=True),
    ]
    return model_of([*supports, prism("block", outline, (0, 1), STONE)], bs.JointMaterial("dry", friction))


def angular(friction):
    """Three blocks on the ground, one on the other, L-shaped in plan, with faces of two parts and more."""
    outline = [[0, 0], [1, 0], [1, 0.3], [0.3, 0.3], [0.3, 1], [0, 1]]
    courses = [prism(f"course {i}", outline, (i / 2, i / 2 + 0.5), STONE) for i in range(3)]
    ground = box("ground", [-1, -2, -0.5], [3, 3, 0.5], fixed=True)
    lying = moved(courses, rotation((1, 0, 0), np.pi / 2))
    return model_of([ground, *lying], bs.JointMaterial("dry", friction))


def case_of(model, direction, **more):
    block = model.blocks[-1].name
    return bs.Pushover("push", SELF_WEIGHT, push(*direction), control=(block, direction), steps=20, **more)


@pytest.mark.filterwarnings("ignore::blockstruct.errors.LoadFactorWarning")
@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0)])
@pytest.mark.parametrize("friction", [0.5, 0.65])
def test_a_notched_block(friction, direction):
    """At the top of the riser the tread has a contact point as well: each remembers its own force only."""
    model = notched(friction)
    result = bs.run(model, case_of(model, direction))["push"]
    curve = result.capacity["load_factor"].to_numpy()
    assert curve[0] == pytest.approx(result.load_factor, rel=2e-4)
    assert curve[1] == pytest.approx(curve[0], rel=0.04)


@pytest.mark.parametrize("friction", [0.4, 0.8])
def test_faces_in_parts(friction):
    model = angular(friction)
    result = bs.run(model, case_of(model, (1, 0, 0)), settings=FICTITIOUS)["push"]
    assert float(result.capacity["load_factor"][0]) == pytest.approx(result.load_factor, rel=1e-4)
    assert bool(result.capacity["holds"][:6].all())


#: Of an arch on piers, m.
INSIDE, OUTSIDE, SPRINGING, FOOT = 1.2, 1.65, 1.5, np.array([2.1, 0.0])


def joint(k, n, radius):
    """Where joint k of n voussoirs, from the left, is at a radius, in x and z."""
    angle = np.pi * (1 - k / n)
    return np.array([radius * np.cos(angle), SPRINGING + radius * np.sin(angle)])


def turned(angle, arm):
    """An arm in x and z that turns clockwise."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * arm[0] + s * arm[1], c * arm[1] - s * arm[0]])


def linkage(blocks, hinges, angle):
    """Load factor of a four-bar linkage: hinges of the arch at joints i, j and k, and of a pier at its foot.

    The bars are voussoirs i to j, those to k, and the others with the pier, which turns by an angle. The load factor is
    what the weights W do on their way down, over what they do on their way to the right: Σ W dz / Σ W dx.
    """
    n = len([b for b in blocks if b.name.isdigit()])
    i, j, k = hinges
    A, B, C = joint(i, n, INSIDE), joint(j, n, OUTSIDE), joint(k, n, INSIDE)
    bars = [[b for b in blocks if b.name.isdigit() and low < int(b.name) <= high] for low, high in ((i, j), (j, k))]
    bars.append([b for b in blocks if (b.name.isdigit() and int(b.name) > k) or b.name.startswith("right")])
    weights = np.array([sum(b.volume for b in bar) for bar in bars])
    centres = [sum(b.volume * b.centroid[[0, 2]] for b in bar) / w for bar, w in zip(bars, weights, strict=True)]

    def placed(angle):
        end = FOOT + turned(angle, C - FOOT)
        apart = np.linalg.norm(C - B)
        first = brentq(lambda a: np.linalg.norm(A + turned(a, B - A) - end) - apart, -0.1, 1.0, xtol=1e-14)
        crown = A + turned(first, B - A)
        (x, z), (p, q) = C - B, end - crown
        second = np.arctan2(z, x) - np.arctan2(q, p)
        return np.array(
            [
                A + turned(first, centres[0] - A),
                crown + turned(second, centres[1] - B),
                FOOT + turned(angle, centres[2] - FOOT),
            ]
        )

    way = weights @ (placed(angle + 1e-6) - placed(angle - 1e-6))
    return way[1] / way[0]


@pytest.mark.parametrize(
    ("voussoirs", "hinges", "steps"),
    [
        pytest.param(9, (4, 7), 35, marks=pytest.mark.slow),
        (7, (3, 5), 40),
        pytest.param(7, (3, 5), 60, marks=pytest.mark.slow),
    ],
)
def test_a_curve_goes_on_behind_a_leap(voussoirs, hinges, steps):
    """A hinge leaps to the next joint: the load factor is that of a four-bar linkage before, and of another after."""
    blocks = bs.structures.arch_on_piers(
        span="2.4 m",
        thickness="0.45 m",
        depth="0.6 m",
        voussoirs=voussoirs,
        pier_width="0.9 m",
        pier_height="1.5 m",
        pier_courses=1,
        material=STONE,
    )
    model = model_of(blocks, bs.JointMaterial("dry", 0.65))
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=(str(voussoirs), (1, 0, 0)), steps=steps)
    curve = bs.run(model, case)["push"].capacity
    alpha = curve["load_factor"].to_numpy()
    angle = curve["rotation"].sel(block="right.1", axis="y").to_numpy()
    one, other = (np.array([linkage(blocks, (first, *hinges), a) for a in angle]) for first in (0, 1))
    back = np.abs(curve["rotation"].sel(block="1", axis="y").to_numpy())
    leaps = int(back.argmax())
    state, stands = np.arange(len(alpha)), curve["falls"].to_numpy() == 0
    turns, rests = (state <= leaps) & stands, (state > leaps) & (back < 1e-3) & stands
    # Close to zero another voussoir drops.
    rests &= alpha > 0.1 * alpha[0]
    assert not np.logical_xor(stands, curve["inertia"].to_numpy() <= 1e-3).any()
    assert curve["energy_error"].max() < 1e-2
    assert leaps > 5
    assert rests.sum() > 10
    assert alpha[turns] == pytest.approx(one[turns], abs=5e-3 * alpha[0])
    assert alpha[rests] == pytest.approx(other[rests], abs=5e-3 * alpha[0])
    assert alpha[-1] < 0.1 * alpha[0]
