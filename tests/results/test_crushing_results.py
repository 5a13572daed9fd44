"""States, utilisation and neutral axis of joints that crush; spreads by name; a study of strength and friction."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.results.interfaces import lost_lever
from blockstruct.text.note import cells_note
from refusals import refused
from structures import SELF_WEIGHT, box, divided, extruded, model_of, push, single_block, solve


def block(share, mu=0.9, b=0.5, h=1.0):
    blocks, _ = single_block(b, h, mu=mu)
    return model_of(blocks, bs.JointMaterial("soft", mu, compressive_strength=Q_(20e3 * h / share, "Pa")))


def test_a_crushing_hinge():
    """Rocking under share = W / (f_c A): the stress block is share × b deep, and full."""
    result = solve(block(0.4), push(1, 0, 0), effects=True)
    assert (result.states[-1].item(), result.notes) == ("hinge + crushing", ())
    used = result.utilisation.isel(iteration=-1)
    assert used.crushing.item() == pytest.approx(1.0, abs=1e-5)
    assert used.neutral_axis_depth.item() == pytest.approx(0.4 * 0.5, rel=1e-5)
    assert used.neutral_axis_depth.units == "meter"
    # V / (μ N) = α / μ.
    assert used.sliding.item() == pytest.approx(result.load_factor / 0.9, rel=1e-5)
    rigid = solve(model_of(*single_block(0.5, 1.0, mu=0.9)), push(1, 0, 0)).utilisation.isel(iteration=-1)
    assert (rigid.crushing.item(), rigid.neutral_axis_depth.item()) == pytest.approx((0.0, 0.0), abs=1e-6)
    heavy = solve(block(1.25), push(1, 0, 0), "nonassociative")
    assert heavy.status == "unstable_under_dead_load"
    assert "ground|block (crushing)" in heavy.message


def hexagon(strength, mu=0.9):
    """A prism of 2 m on a regular hexagon of 0.5 m, two sides of which are along x, and its ground."""
    corners = [(0.5 * np.cos(a), 0.5 * np.sin(a)) for a in np.radians(np.arange(0, 360, 60))]
    blocks = [box("ground", [-1, -1, -1], [2, 2, 1], fixed=True), extruded("prism", corners, 0, 2)]
    return model_of(blocks, bs.JointMaterial("soft", mu, compressive_strength=strength))


@pytest.mark.parametrize("cells", [64, 400])
def test_joints_in_cells_have_a_note_on_the_lever_they_lose(cells):
    """A hexagon that rocks about a side: the lever of 0.433 m loses about half a cell."""
    result = solve(hexagon("100 MPa"), push(0, 1, 0), crushing_cells=cells, effects=True)
    n = int((result.history.interface_of_contact_point == 0).sum())
    lost = lost_lever(result.history, 0)
    assert 0.5 * lost < 1 - result.load_factor / (0.5 * np.sqrt(0.75)) < 1.2 * lost
    assert result.notes == (cells_note(1, 1, (n, n), lost, is_reaction=False),)
    assert solve(hexagon(None), push(0, 1, 0), effects=True).notes == ()


def test_a_couple_about_the_vertical_axis_twists_a_joint():
    load = bs.LoadPattern("twist", [bs.Moment("block", Q_([0, 0, 1], "kN*m"))])
    result = solve(model_of(*single_block(1.0, 0.5, mu=0.3)), load, "nonassociative")
    assert result.states[-1].item() == "twisting"
    # Its centroid rests: the rotation times its distance to a corner of the base, half the root of 2.25 m², is one.
    assert np.abs(result.mechanism.rotation.sel(block="block")).to_numpy() == pytest.approx([0, 0, 4 / 3], abs=1e-4)
    assert np.abs(result.mechanism.translation).max() < 1e-4


def test_cells_agree_with_the_rectangle():
    result = solve(divided(block(0.4)), push(1, 0, 0), crushing_cells=400)
    used = result.utilisation.isel(iteration=-1)
    assert result.states[-1].item() == "hinge + crushing"
    assert used.crushing.item() == pytest.approx(1.0, abs=0.1)
    assert used.neutral_axis_depth.item() == pytest.approx(0.2, rel=0.1)


def test_utilisation_of_mortar_is_the_share_of_all_forces():
    """Push and weight grow together by 1 / utilisation until the block that rests on mortar is at its limit."""
    fc, ft, b, push_x = 2e5, 5e4, 0.5, 0.3
    strengths = {"cohesion": "1 MPa", "tensile_strength": Q_(ft, "Pa"), "compressive_strength": Q_(fc, "Pa")}
    model = model_of(single_block(b, 1.0)[0], bs.JointMaterial("mortar", 2.0, **strengths))
    dead = bs.LoadPattern("dead", [bs.SelfWeight(), bs.BodyForce((1, 0, 0), share=push_x)])
    both = bs.LoadPattern("both", [bs.BodyForce((0, 0, -1)), bs.BodyForce((1, 0, 0), share=push_x)])
    more = solve(model, both, dead=dead)
    N = more.resultants.force.sel(component="n")[-1].item()
    assert pytest.approx((1 + more.load_factor) * 20e3 * b) == N
    history = more.history.isel(iteration=[-1]).copy(deep=True)
    for factor in (1.0, 0.5, 0.02):
        history["contact_force"] = factor * more.history["contact_force"].isel(iteration=[-1])
        assert bs.results.utilisation(history).crushing.item() == pytest.approx(factor, rel=1e-5)


def test_spread_by_name_and_none(small_model):
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0, 0))
    manager = bs.AnalysisManager(small_model)
    steep = manager.run([case], spread="steep")
    assert set(steep) == {"push", "push [steep]", "push [associative]"}
    with refused(bs.errors.ModelError, "'gentle' path"):
        manager.run([case], spread=["gentle"])
    # Cases of similar names are no spread.
    alone = manager.run([case, *(r.case for name, r in steep.items() if name != "push")])
    with refused(bs.errors.ModelError, "'push' spread=True"):
        alone.spread("push")


def test_cells_leave_too_much_of_a_reaction():
    """A skew beam of 28 kN on ledges, one of which gives way: W (L/2 − a)/(L − a) = 8 kN is left if nothing crushes."""

    def plan(x0, x1):
        return [(x0, 0), (x1, 0), (x1 + 0.3, 0.7), (x0 + 0.3, 0.7)]

    ledges = [extruded(n, plan(*ends), -1, 0, fixed=True) for n, ends in (("left", (-1, 1.2)), ("right", (2.8, 5)))]
    soft = bs.JointMaterial("soft", 0.6, compressive_strength="50 MPa")
    model = model_of([*ledges, extruded("beam", plan(0, 4), 0, 0.5)], soft)
    result = bs.run(model, bs.SettlementCase("settles", SELF_WEIGHT, ["left"], "-z"))["settles"]
    assert 8.05e3 < result.reaction.to("N").magnitude < 8.3e3
    assert [note.code for note in result.notes] == ["crushing_cells"]
