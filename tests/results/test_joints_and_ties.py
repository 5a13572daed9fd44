"""Results of ties, and of joints that crush."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv
from matplotlib import pyplot as plt
from matplotlib.collections import LineCollection

import blockstruct as bs
from blockstruct import Q_
from blockstruct.results.interfaces import lost_lever
from blockstruct.text.note import cells_note
from blockstruct.views import figures
from blockstruct.views.console import analysis_summary, result_text
from blockstruct.views.page.html import payload
from blockstruct.views.paraview import write_paraview
from refusals import refused
from structures import SELF_WEIGHT, box, divided, extruded, model_of, push, single_block, solve


@pytest.fixture(scope="module")
def model():
    """Two blocks on a support, tied to a pier, with a bar down to the support and a strip over their joint."""
    supports = ("ground", [-2, 0, -1], [4.5, 1, 1]), ("pier", [-1.5, 0, 0], [0.5, 1, 4])
    blocks = [*(box(*of, fixed=True) for of in supports), box("low", [0, 0, 0], [0.5, 1, 1])]
    blocks += [box("high", [0, 0, 1], [0.5, 1, 1.5])]
    of_tie = {"area": "30 mm^2", "strength": "235 MPa", "punching_force": "6 kN", "prestress": "1 kN"}
    of_bar = {"diameter": "10 mm", "bond_strength": "0.2 MPa", "strength": "235 MPa"}
    ends = ("pier", "[-1, 0.5, 2.3] m"), ("high", "[0, 0.5, 2.3] m")
    over = ("low", "[0, 0.2, 0.8] m"), ("high", "[0, 0.2, 1.2] m")
    ties = [
        bs.Tie("tie", *ends, **of_tie, elongation_limit="20 mm"),
        bs.ties.BondedBar("bar", "[0.2, 0.4, -0.5] m", "[0.2, 0.4, 2.3] m", **of_bar),
        bs.ties.Strip("strip", *over, area="50 mm^2", strength="1 GPa"),
    ]
    return model_of(blocks, bs.JointMaterial("joint", 0.8), "tied").with_ties(ties)


@pytest.fixture(scope="module")
def cases():
    return [bs.LimitCase(f"push {flow}", SELF_WEIGHT, push(1, 0, 0), flow) for flow in bs.Flow]


@pytest.fixture(scope="module")
def stored(model, cases, tmp_path_factory):
    path = tmp_path_factory.mktemp("ties") / "tied.h5"
    return bs.AnalysisManager(model, store=path).run(cases), path


@pytest.fixture(scope="module")
def result(stored):
    return stored[0]["push nonassociative"]


def test_the_history_has_the_forces_of_ties(model, result):
    history = result.history
    assert history.sizes["tie"] == 4
    assert history["tie"].to_numpy().tolist() == ["tie", "bar [ground|low]", "bar [low|high]", "strip"]
    assert history["tie_force"].dims == ("iteration", "tie")
    assert history["tie_force"].attrs["units"] == "newton"
    # The mechanism turns about the toe: the tie at its limit, and the bar at the bond of its end in the ground.
    bond = math.pi * 0.01 * 0.2e6 * 0.5
    np.testing.assert_allclose(history["tie_force"][-1, :2], [6e3, bond], rtol=1e-4)
    assert result.ties["state"].tolist()[:2] == ["punching", "slipping"]
    W, b, h = 25e3, 0.5, 2.5
    alpha = (W * b / 2 + 6e3 * 2.3 + bond * 0.3) / (W * h / 2)
    assert result.load_factor == pytest.approx(alpha, rel=1e-4)
    # Work of the loads is that of the ties: α − Σ T ė = −w_D·u, with the weights lifted.
    rates = history["tie_elongation_rate"][-1].to_numpy()
    lifted = 20e3 * np.array([0.5, 0.75]) @ history["block_velocity"][-1, 2:, 2].to_numpy()
    assert history["tie_force"][-1].to_numpy() @ rates + lifted == pytest.approx(result.load_factor, rel=1e-4)
    assert result.history.blockstruct.frame("tie_force").index.names == ["iteration", "tie"]


def test_elongation_against_its_limit(result):
    row = result.ties.loc["tie"]
    assert row["displacement at limit [meter]"] == pytest.approx(0.02 / row["elongation"])
    assert np.isnan(result.ties.loc["strip", "displacement at limit [meter]"])
    sentences = bs.results.tie_sentences(result.history)
    assert sentences[0].startswith("tie: punching, 6 kN of 6 kN (punching); it lengthens by ")
    assert sentences[1].startswith("Tie bar [ground|low]: slipping, 3.142 kN of 3.142 kN (bond)")
    assert set(sentences) <= set(result.describe().splitlines())


def test_a_slack_tie_has_no_force(model, result):
    away = bs.run(model, bs.LimitCase("away", SELF_WEIGHT, push(-1, 0, 0), "associative"))["away"]
    slack = away.history.assign(tie_force=away.history["tie_force"].copy(data=[[1e3, -8.7e-10, 1e3, 1e3]]))
    assert bs.results.tie_forces(slack)[-1, 1] == 0.0 == bs.ties.ties_at_collapse(slack)["force [newton]"].iloc[1]


def test_files_keep_ties(model, stored):
    analysis, path = stored
    again = bs.open_analysis(path)
    assert again.model.hash == model.hash != model.with_ties(model.ties[:2]).hash != model.with_ties(()).hash
    assert again.model.ties == model.ties
    for name, result in analysis.items():
        assert again[name].history.identical(result.history)
    assert bs.results.contradictions(again) == []
    certificate = bs.results.recomputed_certificate(again, "push associative")
    assert certificate.flow_rule_gap == pytest.approx(again["push associative"].certificate.flow_rule_gap, abs=1e-7)
    assert bs.check_file(path)["status"] == "finished"


@pytest.mark.parametrize(
    ("variable", "factor", "said"),
    [
        ("tie_force", 1.01, "certificate"),
        ("tie_elongation_rate", 1.01, "rates of elongation"),
        ("tie_capacity", 2.0, "tie_capacity of the history"),
    ],
)
def test_changed_ties_are_found(stored, variable, factor, said):
    analysis, _ = stored
    result = analysis["push associative"]
    changed = replace(result, history=result.history.assign({variable: result.history[variable] * factor}))
    found = bs.results.contradictions(analysis.replaced(results={**analysis, result.name: changed}))
    assert any(said in what for _, what in found), found


def test_views_show_ties(model, stored, result, tmp_path):
    assert "ties: tie, bar, strip" in model.summary()
    assert "tie: punching, 6 kN of 6 kN" in result_text(stored[0]["push associative"]).plain
    summary = json.loads(json.dumps(analysis_summary(stored[0]), allow_nan=False))
    assert (summary["ties"], [tie["state"] for tie in summary["cases"][0]["ties"][:2]]) == (3, ["punching", "slipping"])
    texts = {text.get_text() for text in figures.structure(result, look="y").get_legend().get_texts()}
    assert {"tie, punching", "tie, slipping"} <= texts
    for draw in (figures.mechanism, figures.forces):
        ax = draw(result, look="y")
        assert len([c for c in ax.collections if isinstance(c, LineCollection) and len(c.get_segments()) == 4]) == 2
    assert "6 kN" in [text.get_text() for text in ax.texts]
    plt.close("all")
    rows = payload(stored[0])["cases"][1]["tie"]
    assert (len(rows), rows[-1][0]) == (result.n_iterations, ("punching", pytest.approx(6e3, rel=1e-4)))
    write_paraview(result, tmp_path / "tied.pvd")
    last = pv.read(tmp_path / "tied" / f"ties-{result.n_iterations - 1:04}.vtp")
    np.testing.assert_allclose(last.cell_data["tension [newton]"], result.history["tie_force"][-1])


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
