"""Structures that are their own mirror image are solved by half of their unknowns, with the same results."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.limit import LimitProblem
from blockstruct.limit.mirror import Mirror
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, bonded, box, model_of, moved, push, rotation, solve

DRY = bs.JointMaterial("dry", 0.65)


@pytest.fixture(scope="module")
def wall(tuff):
    return bonded(3, 4, material=tuff)


@pytest.fixture(scope="module")
def dome():
    stone = bs.Material("limestone", unit_weight="22 kN/m^3")
    return bs.structures.dome(span="8 m", thickness="60 cm", courses=3, units=6, oculus="1.6 m", material=stone)


def problem_of(model, variable, dead=SELF_WEIGHT):
    return LimitProblem.of(Statics.of(model), bs.LimitCase("case", dead, variable, "associative"))


WEAK = bs.JointMaterial("weak", 0.65, cohesion="0.5 kPa", tensile_strength="0.3 kPa", compressive_strength="60 kPa")


@pytest.mark.parametrize(
    ("name", "joint", "settings"),
    [("wall", DRY, {}), ("dome", DRY, {}), ("wall", WEAK, {}), ("wall", WEAK, {"crushing": "linearised"})],
    ids=["wall", "dome", "weak", "linearised"],
)
def test_same_load_factor_certified_for_the_whole(name, joint, settings, request, monkeypatch):
    model = model_of(request.getfixturevalue(name), joint)
    problem = problem_of(model, push(1, 0, 0))
    mirror = Mirror.of(problem)
    assert 2 * mirror.half.n_points == problem.n_points + (np.bincount(mirror.point) == 1).sum()
    result = solve(model, push(1, 0, 0), "associative", **settings)
    monkeypatch.setattr(Mirror, "of", classmethod(lambda *_: None))
    whole = solve(model, push(1, 0, 0), "associative", **settings)
    assert result.load_factor == pytest.approx(whole.load_factor, rel=1e-7)
    assert result.certificate.holds
    assert result.history.sizes["contact_point"] == whole.history.sizes["contact_point"]


def test_what_is_not_its_mirror_image_is_not_reduced(wall):
    def is_reduced(blocks, joint=DRY, direction=(1, 0, 0)):
        return Mirror.of(problem_of(model_of(blocks, joint), push(*direction))) is not None

    assert is_reduced(wall)
    assert is_reduced(wall, direction=(0, 0, -1))
    assert not is_reduced(wall, direction=(1, 1e-6, 0))
    for aside in (0.0, 1e-6):
        load = bs.PointLoad(wall[-1].name, Q_([1.1, 0.1 + aside, 0.8], "m"), "[1, 0, 0] kN")
        problem = problem_of(model_of(wall, DRY), bs.LoadPattern("push", [load]))
        assert (Mirror.of(problem) is None) == bool(aside)
    # In another frame, with blocks in another order.
    turned = moved(wall, R := rotation((1, 2, 3), 0.7), (5, -3, 2))[::-1]
    dead = bs.LoadPattern("dead", [bs.BodyForce(R @ [0, 0, -1])])
    problem = problem_of(model_of(turned, DRY), push(*(R @ [1, 0, 0])), dead)
    assert 2 * Mirror.of(problem).half.n_points == problem.n_points
    shifted = moved(wall[-1:], np.eye(3), (0, 1e-6, 0))
    assert not is_reduced([*wall[:-1], *shifted])
    # Two equal blocks side by side, on joints of different friction.
    pair = [box(name, [0, y, 0], [1, 0.5, 1]) for name, y in (("a", 0), ("b", 0.5))]
    pair.append(box("ground", [-1, -1, -0.5], [4, 4, 0.5], fixed=True))
    assert is_reduced(pair)
    assert not is_reduced(pair, {"ground|b": bs.JointMaterial("smooth", 0.3), "*": DRY})
