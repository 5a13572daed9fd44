"""What is exported for ParaView, read again with VTK's reader."""

import numpy as np
import pytest
import pyvista as pv

import blockstruct as bs
from blockstruct.views.paraview import write_paraview
from structures import SELF_WEIGHT, push

CASE = "push nonassociative"


@pytest.fixture(scope="module")
def reader(small_analysis, tmp_path_factory):
    path = write_paraview(small_analysis, CASE, tmp_path_factory.mktemp("vtk") / "wall ü.pvd")
    return pv.get_reader(path)


@pytest.mark.parametrize("iteration", [0, -1])
def test_counts_and_values_are_those_of_the_history(reader, small_analysis, iteration):
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
    found = bs.mechanism(result.history.isel(iteration=[iteration]))
    np.testing.assert_allclose(moved, found.translation, atol=1e-12)

    assert interfaces.n_cells == 2 * len(model.interfaces)
    assert interfaces.area == pytest.approx(sum(i.area for i in model.interfaces), rel=1e-6)
    states = result.states.isel(iteration=iteration).to_numpy()
    np.testing.assert_array_equal(interfaces["sliding"][::2], ["sliding" in state for state in states])
    used = bs.utilisation(result.history).sliding.isel(iteration=iteration)
    np.testing.assert_allclose(interfaces["utilisation of sliding [dimensionless]"][::2], used)

    np.testing.assert_allclose(forces.points, history.contact_position)
    np.testing.assert_allclose(forces["normal force [newton]"], history.contact_force.sel(component="n"))
    size = np.linalg.norm(forces["contact force [newton]"], axis=1)
    np.testing.assert_allclose(size, np.linalg.norm(history.contact_force, axis=1), rtol=1e-9)

    N = result.resultants.force.sel(component="n").isel(iteration=iteration).to_numpy()
    assert resultants.n_points == (N > 0).sum()
    assert resultants.field_data["load factor [dimensionless]"][0] == float(history.load_factor)


def test_bad_input_is_refused(small_analysis, small_model, tmp_path):
    with pytest.raises(bs.UnknownNameError, match="no case 'x'"):
        write_paraview(small_analysis, "x", tmp_path / "a.pvd")
    with pytest.raises(bs.StorageError, match=r"ends in \.pvd"):
        write_paraview(small_analysis, CASE, tmp_path / "a.vtk")
    (tmp_path / "a").write_text("in the way", encoding="utf-8")
    with pytest.raises(bs.StorageError, match="cannot be written"):
        write_paraview(small_analysis, CASE, tmp_path / "a.pvd")

    def stop(event):
        raise KeyboardInterrupt

    case = bs.LimitCase("case", SELF_WEIGHT, push(1, 0, 0))
    cut = bs.AnalysisManager(small_model, listeners=[stop]).run([case])
    with pytest.raises(bs.ModelError, match="no iteration to export"):
        write_paraview(cut, "case", tmp_path / "b.pvd")
