"""What is exported for ParaView, read again with VTK's reader."""

import numpy as np
import pytest
import pyvista as pv

import blockstruct as bs
from blockstruct.views.paraview import write_paraview
from refusals import refused
from structures import box, model_of, push, solve

CASE = "push nonassociative"


@pytest.fixture(scope="module")
def reader(small_analysis, tmp_path_factory):
    path = write_paraview(small_analysis[CASE], tmp_path_factory.mktemp("vtk") / "wall ü.pvd")
    return pv.get_reader(path)


@pytest.mark.parametrize("iteration", [0, -1])
def test_counts_and_values_match_the_history(reader, small_analysis, iteration):
    model, result = small_analysis.model, small_analysis[CASE]
    assert reader.time_values == list(range(result.n_iterations))
    reader.set_active_time_point(iteration % result.n_iterations)
    blocks, interfaces, forces, resultants = reader.read()
    history = result.history.isel(iteration=iteration)

    assert blocks.n_points == 8 * len(model.blocks)
    assert blocks.n_cells == 12 * len(model.blocks)
    # The file keeps them as given, in double precision.
    np.testing.assert_array_equal(blocks.points, np.concatenate([b.shape.vertices for b in model.blocks]))
    assert blocks.field_data["block names"].tolist() == [b.name for b in model.blocks]
    assert blocks.volume == pytest.approx(sum(b.volume for b in model.blocks), rel=1e-6)
    moved = blocks["mechanism"].reshape(-1, 8, 3).mean(axis=1)
    found = bs.results.mechanism(result.history.isel(iteration=[iteration]))
    np.testing.assert_allclose(moved, found.translation, atol=1e-12)

    assert interfaces.n_cells == 2 * len(model.interfaces)
    assert interfaces.area == pytest.approx(sum(i.area for i in model.interfaces), rel=1e-6)
    states = result.states.isel(iteration=iteration).to_numpy()
    np.testing.assert_array_equal(interfaces["sliding"][::2], ["sliding" in state for state in states])
    used = bs.results.utilisation(result.history).sliding.isel(iteration=iteration)
    np.testing.assert_allclose(interfaces["utilisation of sliding [dimensionless]"][::2], used)

    np.testing.assert_allclose(forces.points, history.contact_point_position)
    np.testing.assert_allclose(forces["normal force [newton]"], history.contact_force.sel(component="n"))
    size = np.linalg.norm(forces["contact force [newton]"], axis=1)
    np.testing.assert_allclose(size, np.linalg.norm(history.contact_force, axis=1), rtol=1e-9)

    N = result.resultants.force.sel(component="n").isel(iteration=iteration).to_numpy()
    assert resultants.n_points == (N > 0).sum()
    assert resultants.field_data["load factor [dimensionless]"][0] == float(history.load_factor)


def test_names_are_kept_in_any_script(tmp_path):
    boxes = [box("地", [0, 0, -1], [1, 1, 1], fixed=True), box("clé", [0, 0, 0], [1, 1, 1])]
    result = solve(model_of(boxes, bs.JointMaterial("joint", 0.65)), push(1, 0, 0))
    blocks, interfaces, *_ = pv.read(write_paraview(result, tmp_path / "a.pvd"))
    assert blocks.field_data["block names"].tolist() == ["地", "clé"]
    assert interfaces.field_data["interface names"].tolist() == ["地|clé"]


def test_iterations_without_forces_have_no_resultants(small_model, tmp_path):
    blocks, _, _, resultants = pv.read(write_paraview(solve(small_model, push(0, 0, -1)), tmp_path / "down.pvd"))
    assert (blocks.n_cells, resultants.n_points) == (12 * len(small_model.blocks), 0)


def test_pieces_of_an_earlier_case_do_not_stay(small_analysis, tmp_path):
    path = write_paraview(small_analysis[CASE], tmp_path / "a.pvd")
    own = path.with_suffix("") / "notes-0009.vtp"
    own.write_text("mine", encoding="utf-8")
    write_paraview(small_analysis["push associative"], path)
    pieces = {f"{kind}-0000.vtp" for kind in ("blocks", "interfaces", "forces", "resultants")}
    assert {p.name for p in path.with_suffix("").iterdir()} == pieces | {own.name}


def test_bad_input_is_refused(small_analysis, tmp_path):
    (tmp_path / "a").write_text("in the way", encoding="utf-8")
    for error, words, shown, name in (
        (bs.errors.ModelError, "Analysis CaseResult", small_analysis, "a.pvd"),
        (bs.errors.StorageError, ".pvd", small_analysis[CASE], "a.vtk"),
        (bs.errors.StorageError, "a.pvd written", small_analysis[CASE], "a.pvd"),
    ):
        with refused(error, words):
            write_paraview(shown, tmp_path / name)
