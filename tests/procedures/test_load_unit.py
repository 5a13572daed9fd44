"""A multiple of the variable load gives the same collapse, and so does the unit in which a force is given."""

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.analysis import IterationDone
from structures import SELF_WEIGHT, model_of, push, solve, stopping

SIZES = [1e-9, 1e-3, 1e6]
PROCEDURES = {
    "loading path": bs.ProcedureSettings(),
    "interior point": bs.ProcedureSettings(path_steps="interior point"),
    "fictitious": bs.ProcedureSettings(procedure="fictitious"),
    "shifted": bs.ProcedureSettings(procedure="shifted"),
    "associative": bs.ProcedureSettings(),
}
TUFF = bs.Material("tuff", "14 kN/m^3")


def wall(courses=5, friction=0.6, **joint):
    blocks = bs.wall(
        length="2 m", courses=courses, unit_length="0.4 m", unit_height="0.2 m", thickness="0.3 m", material=TUFF
    )
    model = model_of(blocks, bs.JointMaterial("dry", friction, **joint))
    return model, max((b for b in blocks if not b.fixed), key=lambda b: (b.centroid[2], -b.centroid[0]))


def solved(model, top, size, procedure, **options):
    force = bs.PointLoad(top.name, Q_(top.centroid, "m"), Q_([size, 0, 0], "kN"))
    flow = "associative" if procedure == "associative" else "nonassociative"
    case = bs.LimitCase("push", SELF_WEIGHT, bs.LoadPattern("push", [force]), flow)
    return bs.AnalysisManager(model, settings=PROCEDURES[procedure], **options).run([case])["push"]


def facts(result):
    """All that must not depend on the size of the load."""
    outcome, h = result.outcome, result.history
    return (
        (outcome.status, outcome.reason, outcome.procedure, outcome.settled, outcome.path_end, result.warnings),
        h.stage.to_numpy().tolist(),
        h.solver_iterations.to_numpy().tolist(),
    )


def assert_same(result, reference, size):
    """A result is that of one kN, but for the load factor and what is measured in it."""
    assert facts(result) == facts(reference)
    h, of_one = result.history, reference.history
    for name in ("load_factor", "flow_rule_gap", "flow_rule_gap_limit"):
        np.testing.assert_allclose(h[name] * size, of_one[name], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(h.contact_force, of_one.contact_force, rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(h.displacement, of_one.displacement, rtol=1e-6)
    last, of_last = h.block_velocity[-1] * size, of_one.block_velocity[-1]
    np.testing.assert_allclose(last, of_last, rtol=1e-6, atol=1e-6 * float(abs(of_last).max()))
    assert result.certificate.holds == reference.certificate.holds
    for name in ("load_factor", "peak"):
        np.testing.assert_allclose(getattr(result.outcome, name) * size, getattr(reference.outcome, name), rtol=1e-6)
    if reference.outcome.drift is not None:
        np.testing.assert_allclose(np.array(result.outcome.drift) * size, reference.outcome.drift, rtol=1e-6)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("procedure", PROCEDURES)
def test_any_size_of_the_load_gives_the_same_result(procedure, size):
    """Loads of 1e-6 kN did not settle along the loading path, and of 1e6 kN did not begin."""
    model, top = wall()
    reference = solved(model, top, 1.0, procedure)
    assert reference.status == "converged"
    assert_same(solved(model, top, size, procedure), reference, size)


@pytest.mark.parametrize("size", [1e-9, 1e6])
@pytest.mark.parametrize("procedure", ["loading path", "fictitious"])
def test_with_prestressed_ties_joints_that_crush_and_stiffness(procedure, size):
    """Their forces and strengths are given in newtons, whatever the load."""
    model, top = wall(friction=0.9, compressive_strength="200 kPa", normal_stiffness="1 GPa/m")
    ends = (top.name, Q_(top.centroid, "m")), ("base", Q_([*top.centroid[:2], 0], "m"))
    model = model.with_ties([bs.Tie("bar", *ends, yield_force="3 kN", prestress="1 kN")])
    reference, result = (solved(model, top, of, procedure) for of in (1.0, size))
    assert_same(result, reference, size)
    np.testing.assert_allclose(result.history.tie_force, reference.history.tie_force, rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_a_resumed_and_a_reopened_result_are_the_same(tmp_path, size):
    model, top = wall()
    whole = solved(model, top, size, "fictitious", store=tmp_path / "whole.h5")
    assert bs.open_analysis(tmp_path / "whole.h5")["push"].history.identical(whole.history)
    stop = stopping(IterationDone, at=4)
    solved(model, top, size, "fictitious", store=tmp_path / "part.h5", listeners=[stop])
    resumed = bs.AnalysisManager.resume(tmp_path / "part.h5")["push"]
    assert resumed.load_factor == pytest.approx(whole.load_factor, rel=1e-6)
    assert facts(resumed)[:2] == facts(whole)[:2]
    assert bs.results.contradictions(bs.open_analysis(tmp_path / "part.h5")) == []


def test_mass_proportional_loads_of_any_share():
    shares, (model, _) = (1e-6, 1.0, 1e6), wall()
    found = [solve(model, push(share, 0, 0), "nonassociative").load_factor * share for share in shares]
    assert found == pytest.approx([found[1]] * 3, rel=1e-6)


@pytest.mark.parametrize("friction", [1.0, 1.3, 1.7, 2.5, 5.0])
def test_fictitious_conditions_agree_with_the_path_at_any_friction(friction):
    """The load factor is that of a friction of 0.6; dilatancy of the first program must not wedge the wall."""
    model, _ = wall(6, friction)
    names = ("fictitious", "loading path")
    fictitious, path = (solve(model, push(1, 0, 0), "nonassociative", procedure=name) for name in names)
    assert fictitious.settled
    assert fictitious.load_factor == pytest.approx(0.57898, rel=5e-4)
    assert path.load_factor == pytest.approx(fictitious.load_factor, rel=5e-3)
