"""The motion of least acceleration: its multiplier by virtual work, its e*, and what it does not depend on."""

import dataclasses
import random

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.assess.activation import _Search, least_activation
from blockstruct.assess.freedom import separate_mechanisms
from blockstruct.assess.local_mechanism import without_small
from blockstruct.assess.participation import HorizontalForces, of_bodies
from blockstruct.limit import LimitProblem
from blockstruct.limit.certificate import certify
from blockstruct.limit.motion import unit_of_velocity
from blockstruct.statics.statics import Statics
from facades import solve
from structures import SELF_WEIGHT, STONE, model_of, push, single_block

SITE = bs.assess.ntc_spectrum(Q_(0.1, "g_0"), 2.4, "0.3 s", "B")


def corner(*, mirrored=False, seed=None, **joint):
    """A façade with one sidewall, out of plane: bodies of unlike motion, at joints that crush, with a tie."""
    size = {"unit_length": "1 m", "unit_height": "0.5 m", "thickness": "0.5 m", "material": STONE}
    at = "2.5 m" if mirrored else "0 m"
    blocks = bs.wall(length="3 m", courses=6, sidewalls=[bs.structures.Sidewall("side", at=at, length="2.5 m")], **size)
    if seed is not None:
        random.Random(seed).shuffle(blocks)
    model = model_of(blocks, bs.JointMaterial("lime", 0.6, compressive_strength="3 MPa", **joint))
    x = 2.75 if mirrored else 0.25
    ends = [
        min((b for b in blocks if not b.fixed), key=lambda b: np.linalg.norm(b.centroid - [x, y, 2.75])).name
        for y in (0.25, 2.75)
    ]
    places = [Q_([x, y, 2.75], "m") for y in (0.0, 3.0)]
    return model.with_ties([bs.Tie("tie", (ends[0], places[0]), (ends[1], places[1]), yield_force="5 kN")])


@pytest.fixture(scope="module")
def result():
    return solve(corner(), push(0, -1, 0), "nonassociative")


def test_the_multiplier_of_a_motion_is_that_of_the_certificate(result):
    """The flow-rule gap of the same motion, by another code, is what its multiplier has beyond α0."""
    forces = HorizontalForces.of(result.model, result.case)
    (part,) = separate_mechanisms(result, forces, result.macro_blocks)
    whole, _ = of_bodies(result.model, forces, result.mechanism, part)
    everything = dataclasses.replace(whole, left_out=None)
    search = _Search.of(result, forces, part, everything)
    search = dataclasses.replace(search, body=np.maximum(search.body, 0))
    found = search.solved(10 * result.load_factor)
    statics = Statics.of(result.model)
    problem = LimitProblem.of(statics, result.case)
    last = result.history.isel(iteration=-1)
    x = last["contact_force"].to_numpy() / problem.force_unit[:, None]
    T = last["tie_force"].to_numpy() / problem.ties.force_unit
    moving = {name for body in part for name in body.blocks}
    u = np.zeros((problem.n_blocks, 6))
    u[[result.model.blocks[i].name in moving for i in statics.free]] = found.motion
    u = (u * unit_of_velocity(problem)).ravel()
    u /= problem.w_L @ u
    again = certify(problem, x, u, result.load_factor, result.settings, T)
    assert found.alpha > 1.02 * result.load_factor
    assert again.interpenetration < 1e-5
    assert found.alpha - result.load_factor == pytest.approx(again.flow_rule_gap, rel=1e-3)


def test_the_least_acceleration_lies_between_the_floor_and_the_collapse_mechanism(result):
    check = bs.assess.local_mechanism(result, spectrum=SITE, knowledge_level="LC1")
    (collapse,) = [one for one in check.verdict.ways if one.way is bs.assess.Way.COLLAPSE]
    (other,) = [one for one in check.verdict.ways if one.way is bs.assess.Way.OTHER_MOTION]
    assert check.alpha0 < other.alpha
    assert collapse.state.ratio * collapse.e_star <= other.state.ratio < 0.95 * collapse.state.ratio
    # The remedy of torsion takes 1 % off the load factor, and off what no motion goes below.
    assert check.verdict.governing.way is bs.assess.Way.UNIFORM_TORSION
    low = result.outcome.uniform_torsion / result.load_factor
    assert check.verdict.floor == pytest.approx(low * collapse.state.ratio * collapse.e_star, rel=1e-12)
    assert check.verdict.floor <= check.ratio == pytest.approx(low * other.state.ratio, rel=1e-9)
    assert check.ratio == pytest.approx(
        check.verdict.governing.alpha / check.e_star / check.confidence_factor / (SITE.peak / 9.80665 / 2), rel=1e-6
    )


@pytest.mark.slow
def test_the_ratio_follows_the_load_factor_and_nothing_else():
    """Mirrored, in another order, and with other steps: where α0 moves by less than 1 %, the ratio does by 2 %."""
    case = bs.LimitCase("case", SELF_WEIGHT, push(0, -1, 0))
    spread = bs.AnalysisManager(corner(), effects=False).run([case], spread=["half steps"]).spread("case")
    models = corner(mirrored=True), corner(seed=1)
    others = [bs.AnalysisManager(model, effects=False).run([case])["case"] for model in models]
    runs = (*spread.runs.values(), *others)
    checks = [bs.assess.local_mechanism(one, spectrum=SITE, knowledge_level="LC1") for one in runs]
    assert len(checks) == 4
    alphas, ratios = (np.array([getattr(check, name) for check in checks]) for name in ("alpha0", "ratio"))
    assert np.ptp(alphas) < 0.01 * alphas.min()
    assert np.ptp(ratios) < 0.02 * ratios.min()


def test_one_body_is_its_own_least_motion():
    """Nothing has a larger e* than one body that turns."""
    model = model_of(single_block(4.0, 3.0, 0.5)[0], bs.JointMaterial("dry", 0.7))
    result = solve(model, push(0, -1, 0), "nonassociative")
    forces = HorizontalForces.of(result.model, result.case)
    whole, _ = of_bodies(result.model, forces, result.mechanism, result.macro_blocks)
    least = least_activation(result, forces, result.macro_blocks, without_small(whole))
    assert (least.alpha, least.e_star, least.bodies) == pytest.approx((0.5 / 3, 1.0, 1), rel=1e-6)
