"""Problems of COMPAS DEM, against closed forms and its own solver."""

import re
from pathlib import Path

import numpy as np
import pytest

import blockstruct as bs

pytest.importorskip("compas_dem")
from compas.geometry import Box, Frame
from compas_dem.material import Stone
from compas_dem.models import BlockModel
from compas_dem.problem import Problem, Solver

from blockstruct.adapters import compas_dem as adapter

#: Weight of a cube of 0.5 m, N.
WEIGHT = 2000 * 9.81 * 0.125


@pytest.fixture
def problem():
    """Three cubes of 0.5 m on a support, with friction 0.7 and a push of 1 kN on the highest."""
    boxes = [Box(1, 1, 0.2, frame=Frame([0, 0, -0.1], [1, 0, 0], [0, 1, 0]))]
    boxes += [Box(0.5, 0.5, 0.5, frame=Frame([0, 0, 0.25 + 0.5 * k], [1, 0, 0], [0, 1, 0])) for k in range(3)]
    model = BlockModel.from_boxes(boxes)
    model.add_support(0)
    stone = Stone(fck=20, density=2000)
    model.add_material(stone)
    model.assign_material(stone, elements=list(model.elements()))
    model.compute_contacts()
    made = Problem(model, name="stack")
    made.set_contact_model("MohrCoulomb", mu=0.7)
    made.add_boundary_condition("Live").add_point_load(3, [1000.0, 0.0, 0.0])
    return made


def test_a_stack_overturns_and_its_edges_carry_the_loads(problem):
    found = adapter.solve(problem, amplitude="1 cm")
    # About its lower edge: 3 W × 0.25 m = α × 1 kN × 1.25 m.
    push = 3 * WEIGHT * 0.25 / 1.25
    assert found.metadata["load_factor"] == pytest.approx(push / 1000, rel=1e-4)
    assert found.metadata["certified"]
    for level, edge in enumerate([(0, 1), (1, 2), (2, 3)]):
        np.testing.assert_allclose(found.resultant_global(edge), [-push, 0, (3 - level) * WEIGHT], atol=1e-3 * WEIGHT)
        data = found.contact_data(edge)
        assert sum(f["c_np"] for f in data.forces) == pytest.approx((3 - level) * WEIGHT, rel=1e-5)
        np.testing.assert_allclose(list(data.frame.zaxis), [0, 0, 1], atol=1e-12)
    # The stack turns about the edge at x = 0.25, z = 0, and 1 cm is the way of its highest centroid.
    matrix = np.array(found.transformation(3).matrix)
    np.testing.assert_allclose(matrix @ [0.25, 0, 0, 1], [0.25, 0, 0, 1], atol=1e-6)
    assert np.linalg.norm((matrix @ [0, 0, 1.25, 1])[:3] - [0, 0, 1.25]) == pytest.approx(0.01, rel=1e-3)
    np.testing.assert_allclose(np.array(found.transformation(0).matrix), np.eye(4), atol=1e-12)


def test_weights_agree_with_rigid_block_equilibrium(problem, capsys):
    pytest.importorskip("compas_cra")
    problem.set_solver(Solver.RBE())
    theirs, ours = problem.solve(), adapter.solve(problem)
    for edge in theirs.edges():
        assert ours.resultant_global(edge)[2] == pytest.approx(theirs.resultant_global(edge)[2], rel=1e-5)


def test_loads_dead_and_variable_and_detected_contacts(problem):
    model = problem.model
    for edge in list(model.graph.edges()):
        model.graph.edge_attribute(edge, "contacts", [])
    weights = problem.add_boundary_condition("weights")
    weights.add_surface_load(3, 0, [0.0, 0.0, -4 * WEIGHT])
    posed = adapter.posed(problem, variable="Live")
    assert len(posed.model.interfaces) == 3
    face = model.graph.node_element(3).modelgeometry.face_center(0)
    # The face has 0.25 m²: its load weighs as much as a block, at the middle of the face.
    lever = 3 * WEIGHT * 0.25 + WEIGHT * (0.25 - face[0])
    (result,) = bs.run(posed.model, [posed.case]).values()
    assert result.load_factor == pytest.approx(min(lever / 1.25, 2 * WEIGHT * 0.7) / 1000, rel=1e-3)
    problem.add_boundary_condition("quake").add_global_body_force(0.1 * 9.81, 0, 0)
    posed = adapter.posed(problem, variable=["quake"])
    assert [type(load).__name__ for load in posed.case.variable.loads] == ["BodyForce"]
    assert posed.case.variable.loads[0].share == pytest.approx(0.1)


def test_the_how_to_page():
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "compas.md").read_text(encoding="utf-8")
    names = {}
    exec(re.search(r"```py\n(.*?)```", page, re.DOTALL)[1], names)
    # Three free cubes of 0.5 m that turn about their lower edge.
    assert names["results"].metadata["load_factor"] == pytest.approx(3 * WEIGHT * 0.25 / 1.25 / 1000, rel=1e-4)


def test_bad_problems_are_refused(problem):
    with pytest.raises(bs.errors.UnknownNameError, match="no boundary condition 'Wind'; it has 'Live'"):
        adapter.posed(problem, variable="Wind")
    problem.boundary_conditions[0].add_displacement(0, dz=-0.01)
    with pytest.raises(bs.errors.ModelError, match="a displacement is prescribed"):
        adapter.posed(problem)
    empty = Problem(problem.model)
    with pytest.raises(bs.errors.ModelError, match="no boundary condition"):
        adapter.posed(empty)
    empty.add_boundary_condition("nothing")
    with pytest.raises(bs.errors.ModelError, match="no contact model"):
        adapter.posed(empty)
    empty.set_contact_model("MohrCoulomb", mu=0.7)
    with pytest.raises(bs.errors.ModelError, match="no load to multiply"):
        adapter.posed(empty)
