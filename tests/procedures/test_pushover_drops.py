"""Blocks that drop on the way of a pushover."""

from importlib import import_module

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.procedures.attempts import Attempts
from structures import SELF_WEIGHT, box, push, slid_from_under


def pushed(steps):
    """Curve of a pushed along until b has lost what it stands on."""
    push = bs.LoadPattern("push", [bs.PointLoad("a", Q_([1, 0.2, 0.1], "m"), Q_([1, 0, 0], "kN"))])
    case = bs.Pushover("push", SELF_WEIGHT, push, control=("a", (1, 0, 0)), steps=steps)
    return bs.run(slid_from_under(), case)["push"].capacity


@pytest.mark.parametrize(
    "steps", [6, pytest.param(10, marks=pytest.mark.slow), pytest.param(20, marks=pytest.mark.slow)]
)
def test_a_block_drops_where_nothing_holds_it(steps):
    """Whatever the steps, b turns onto the ledge once its centroid is beyond the edge of a, at 0.1 m.

    Before, α is friction on the ground, 0.3 (4 + 0.96) kN, and below b, 0.3 · 0.96 kN, over 1 kN. Behind, b is
    inclined by θ with sin θ = 0.01 / (0.1 + d). On the edge stands a force V, and pushed along the face V tan(φ − θ),
    in balance about the corner on the ledge: V (0.1 + d) − 0.01 V tan(φ − θ) = 0.96 (0.2 cos θ − 0.15 sin θ). With the
    drop on the way of a whole step, α was up to 9 % low on it, and behind it as far away as the step was long.
    """
    curve = pushed(steps)
    d, alpha = curve["displacement"].to_numpy(), curve["load_factor"].to_numpy()
    drops = d[curve["dropped"].to_numpy() == 1]
    begins = d[curve["drops_next"].to_numpy() == 1]
    assert 0.1 <= drops[0] < 0.11
    assert begins[0] < drops[0] < begins[0] + 0.005
    theta = np.arcsin(0.01 / (0.1 + d))
    slope = np.tan(np.arctan(0.3) - theta)
    V = 0.96 * (0.2 * np.cos(theta) - 0.15 * np.sin(theta)) / (0.1 + d - 0.01 * slope)
    assert alpha[d < 0.1] == pytest.approx(0.3 * 4.96 + 0.3 * 0.96, rel=1e-4)
    behind = (d > 0.115) & (d < 0.25)
    assert behind.sum() > 2
    assert alpha[behind] == pytest.approx((0.3 * (4 + V) + V * slope)[behind], rel=2e-3)
    assert float(curve["energy_error"].max()) < 5e-3


def test_a_drop_that_is_none_leaves_nothing_behind(monkeypatch):
    """A curve in which all drops are looked for in vain is, to the last digit, that in which none is looked for."""
    found = Attempts.alone

    def in_vain(*args):
        assert found(*args) is not None

    monkeypatch.setattr(Attempts, "alone", in_vain)
    looked_for = pushed(6)
    monkeypatch.setattr(import_module("blockstruct.procedures.pushover"), "drop_on", lambda *_: None)
    not_looked_for = pushed(6)
    assert int(looked_for["programs"].sum()) > int(not_looked_for["programs"].sum())
    spent = ["programs", "solver_iterations", "solver_time"]
    assert looked_for.drop_vars(spent).equals(not_looked_for.drop_vars(spent))


def cracked(steps):
    """Pushover of two panels that crack between base and stop."""
    blocks = [
        box("ground", [-2, 0, -1], [5, 1, 1], fixed=True),
        box("lower", [0, 0, 0], [0.3, 1, 1.8]),
        box("upper", [0, 0, 1.8], [0.3, 1, 1.2]),
        box("stop", [0.3, 0, 2.9], [0.5, 1, 0.6], fixed=True),
    ]
    joints = {"stop|*": bs.JointMaterial("smooth", 0.0), "*": bs.JointMaterial("dry", 0.7)}
    model = bs.Model("wall", blocks, bs.detect_interfaces(blocks, joint_material=joints))
    case = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("lower", (1, 0, 0)), steps=steps)
    return bs.run(model, case)["push"]


@pytest.mark.parametrize("steps", [pytest.param(6, marks=pytest.mark.slow), 10])
def test_what_a_long_step_opens_is_no_drop(steps):
    """The hinges of the panels move, and open by the square of the way of a step.

    What closed was taken for a drop, and steps begun anew behind it: the curve had no end after 5 times the steps.
    """
    curve = cracked(steps).capacity
    assert float(curve["dropped"].sum()) == 0
    assert curve.sizes["step"] < 40
    assert float(curve["load_factor"][-1]) < 0.02


def test_few_steps_are_given_time():
    """Steps that grow again behind what happened are as many, whatever was asked for."""
    result = cracked(5)
    assert "blocks fall" in result.curve_ended
    assert float(result.capacity["load_factor"][-1]) < 0.02
