"""Exports for other programs, read again with readers of their own."""

import json
import re
import struct

import numpy as np
import pandas as pd
import pytest
import pyvista as pv
import trimesh

import blockstruct as bs
from blockstruct.views import export
from blockstruct.views.paraview import write_paraview
from refusals import refused
from structures import SELF_WEIGHT, box, model_of, push, single_block, solve


@pytest.fixture(scope="module")
def analysis():
    """A block 0.3 m wide and 1.5 m high that rocks about a lower edge, as a mechanism and as a pushover."""
    pushed = bs.Pushover("push", SELF_WEIGHT, push(1, 0, 0), control=("block", (1, 0, 0)), steps=4)
    cases = [bs.LimitCase("plain", SELF_WEIGHT, push(1, 0, 0)), pushed]
    return bs.run(model_of(*single_block(0.3, 1.5, mu=2.0)), cases)


def animated(path):
    """Return the content of a GLB file, and the frames of the animation of the block: time, translation, rotation."""
    data = path.read_bytes()
    assert struct.unpack("<4sII", data[:12]) == (b"glTF", 2, len(data))
    size = struct.unpack("<I", data[12:16])[0]
    content, binary = json.loads(data[20 : 20 + size]), data[28 + size :]

    def values(index):
        accessor = content["accessors"][index]
        view = content["bufferViews"][accessor["bufferView"]]
        array = np.frombuffer(binary[view["byteOffset"] :][: view["byteLength"]], dtype="<f4")
        return array.reshape(accessor["count"], -1)

    (animation,) = content["animations"]
    frames = {c["target"]["path"]: animation["samplers"][c["sampler"]] for c in animation["channels"]}
    time = values(frames["translation"]["input"])[:, 0]
    return content, time, *(values(frames[name]["output"]) for name in ("translation", "rotation"))


@pytest.mark.parametrize("case", ["plain", "push"])
def test_a_block_rocks_about_its_edge_in_the_animation(analysis, case, tmp_path):
    path = export.write_glb(analysis[case], tmp_path / "block.glb")
    content, time, translation, rotation = animated(path)
    assert np.all(np.diff(time) > 0)
    block = analysis.model.blocks[1]
    corners = block.shape.vertices
    edge = corners[(corners[:, 2] == 0) & (corners[:, 0] == corners[:, 0].max())] - block.centroid
    turned = trimesh.transformations.quaternion_matrix
    for at, (x, y, z, w) in zip(translation, rotation, strict=True):
        np.testing.assert_allclose(at + edge @ turned((w, x, y, z))[:3, :3].T, edge + block.centroid, atol=2e-4)
    assert np.ptp(translation[:, 0]) > 0.05
    assert [node["name"] for node in content["nodes"]] == [*(b.name for b in analysis.model.blocks), "model"]
    scene = trimesh.load(path)
    assert scene.bounds[1, 1] == pytest.approx(1.5)


def test_moved_blocks_are_read_again(analysis, tmp_path):
    path = export.write_moved(analysis["plain"], tmp_path / "moved.obj", amplitude="10 cm")
    still = analysis.model.blocks[1]
    _, block = bs.imports.read_mesh(path, unit="m", material=still.material).blocks
    assert block.volume == pytest.approx(still.volume)
    # Along the arc about the edge, whose chord is a little shorter.
    assert 0.0995 < np.linalg.norm(block.centroid - still.centroid) < 0.1
    export.write_moved(analysis["push"], tmp_path / "moved.stl", step=-1)
    total = sum(b.volume for b in analysis.model.blocks)
    assert trimesh.load(tmp_path / "moved.stl").volume == pytest.approx(total, rel=1e-6)
    for case, step, words in (("plain", 0, "no states of a motion"), ("push", 99, "no state 99; it has 0 to")):
        with pytest.raises(bs.errors.ModelError, match=words):
            export.write_moved(analysis[case], tmp_path / "none.stl", step=step)


def test_an_assembly_holds_forces_in_equilibrium(analysis, tmp_path):
    result = analysis["plain"]
    path = export.write_assembly(result, tmp_path / "assembly.json")
    with pytest.warns(bs.errors.GeometryWarning, match="interfaces of 1 pair"):
        again = bs.imports.read_assembly(path, unit="m", material=analysis.model.blocks[0].material)
    assert [(b.name, b.fixed) for b in again.blocks] == [(b.name, b.fixed) for b in analysis.model.blocks]
    graph = json.loads(path.read_text())["data"]["graph"]["data"]
    (interface,) = graph["edge"]["0"]["1"]["interfaces"]
    forces = pd.DataFrame(interface["data"]["forces"])
    weight = analysis.model.blocks[1].weight
    assert forces["c_np"].sum() == pytest.approx(weight, rel=1e-6)
    assert np.hypot(forces["c_u"].sum(), forces["c_v"].sum()) == pytest.approx(result.load_factor * weight, rel=1e-6)
    np.testing.assert_allclose(np.linalg.norm(graph["node"]["1"]["displacement"][:3]), 1)
    compas = pytest.importorskip("compas")
    pytest.importorskip("compas_assembly")
    (line,) = compas.json_load(path).graph.edge_attribute((0, 1), "interfaces")[0].resultantforce
    assert line.length == pytest.approx(weight * np.hypot(1, result.load_factor), rel=1e-6)


def test_tables(analysis, tmp_path):
    folder = export.write_tables(analysis, tmp_path / "tables")
    tables = {path.stem: pd.read_csv(path) for path in folder.iterdir()}
    assert set(tables) == {"cases", "blocks", "interfaces", "iterations", "pushover"}
    assert tables["cases"].set_index("case").loc["plain", "load factor"] == pytest.approx(0.2, rel=1e-4)
    assert tables["interfaces"]["N [newton]"].to_numpy() == pytest.approx(analysis.model.blocks[1].weight, rel=1e-6)
    assert len(tables["pushover"]) == analysis["push"].capacity.sizes["step"]
    pytest.importorskip("openpyxl")
    book = pd.read_excel(export.write_tables(analysis, tmp_path / "tables.xlsx"), sheet_name=None)
    for name, table in tables.items():
        pd.testing.assert_frame_equal(book[name], table, check_dtype=False, rtol=1e-12)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["-o", "a.glb", "--case", "plain", "--amplitude", "5 cm"], ""),
        (["-o", "a.stl", "--case", "push", "--step", "1"], ""),
        (["-o", "a.json", "--case", "plain"], ""),
        (["-o", "tables"], ""),
        (["-o", "a.glb"], "--case: .* has the cases 'plain', 'push'"),
        (["-o", "a.glb", "--case", "plain", "--step", "1"], "--step: does not apply"),
        (["-o", "a.docx", "--case", "plain"], "unknown kind of file"),
    ],
)
def test_the_command(analysis, call, tmp_path, monkeypatch, words, expected):
    monkeypatch.chdir(tmp_path)
    bs.save_analysis(analysis, "block.h5")
    code, out, err = call("export", "block.h5", *words)
    assert code == (2 if expected else 0)
    assert ("written" in out) == (tmp_path / words[1]).exists() == (code == 0)
    assert re.search(expected, err)


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
    # The file keeps them as given, in double precision.
    np.testing.assert_array_equal(blocks.points, np.concatenate([b.shape.vertices for b in model.blocks]))
    assert blocks.field_data["block names"].tolist() == [b.name for b in model.blocks]
    assert blocks.volume == pytest.approx(sum(b.volume for b in model.blocks), rel=1e-6)
    moved = blocks["mechanism"].reshape(-1, 8, 3).mean(axis=1)
    found = bs.results.mechanism(result.history.isel(iteration=[iteration]))
    np.testing.assert_allclose(moved, found.translation, atol=1e-12)

    assert interfaces.area == pytest.approx(sum(i.area for i in model.interfaces), rel=1e-6)
    states = result.states.isel(iteration=iteration).to_numpy()
    np.testing.assert_array_equal(interfaces["sliding"][::2], ["sliding" in state for state in states])
    used = bs.results.utilisation(result.history).sliding.isel(iteration=iteration)
    np.testing.assert_allclose(interfaces["utilisation of sliding [dimensionless]"][::2], used)

    np.testing.assert_allclose(forces.points, history.contact_point_position)
    np.testing.assert_allclose(forces["normal force [newton]"], history.contact_force.sel(component="n"))
    N = result.resultants.force.sel(component="n").isel(iteration=iteration).to_numpy()
    assert resultants.n_points == (N > 0).sum()
    assert resultants.field_data["load factor [dimensionless]"][0] == float(history.load_factor)


def test_names_are_kept_in_any_script(tmp_path):
    """An iteration without forces has no resultants."""
    boxes = [box("地", [0, 0, -1], [1, 1, 1], fixed=True), box("clé", [0, 0, 0], [1, 1, 1])]
    result = solve(model_of(boxes, bs.JointMaterial("joint", 0.65)), push(0, 0, -1))
    blocks, interfaces, _, resultants = pv.read(write_paraview(result, tmp_path / "a.pvd"))
    assert blocks.field_data["block names"].tolist() == ["地", "clé"]
    assert interfaces.field_data["interface names"].tolist() == ["地|clé"]
    assert resultants.n_points == 0


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
