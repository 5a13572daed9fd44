"""Blocks from COMPAS JSON files, in the layouts that its packages have written over the years."""

import json

import numpy as np
import pytest

import blockstruct as bs
from meshes import CUBE, QUADS
from refusals import refused
from structures import STONE

JOINT = bs.JointMaterial("joint", 0.6)


def mesh(level, keys=int, name="Mesh"):
    """Data of a cube at a level, with vertices keyed by text and faces of keys."""
    return {
        "attributes": {"name": name},
        "vertex": {str(i): {"x": x, "y": y, "z": z + level} for i, (x, y, z) in enumerate(CUBE)},
        "face": {str(i): [keys(k) for k in face] for i, face in enumerate(QUADS)},
    }


def typed(dtype, data):
    return {"dtype": dtype, "data": data, "guid": "0"}


def assembly(kind="block"):
    """The layout of compas 1 and 2: a graph whose nodes hold blocks."""
    nodes = {str(i): {kind: typed("compas_assembly.datastructures/Block", mesh(i))} for i in range(3)}
    nodes["0"]["is_support"] = True
    data = {"node": nodes, "edge": {}, "default_node_attributes": {"is_support": False}}
    content = {"attributes": {"name": "Assembly"}, "graph": typed("compas.datastructures/Graph", data)}
    return typed("compas_assembly.datastructures/Assembly", content)


def network():
    """The layout of compas 0: nodes of the assembly itself, data below a value."""
    nodes = {str(i): {"block": {"dtype": "Block", "value": {"data": mesh(i), "compas": "0.18"}}} for i in range(3)}
    return {"dtype": "Assembly", "value": {"data": {"node": nodes, "dna": {}}, "compas": "0.18"}}


def first():
    """The oldest layout: blocks beside a network whose vertices tell the supports."""
    vertices = {str(i): {"is_support": i == 0} for i in range(3)}
    return {"assembly": {"vertex": vertices}, "blocks": {str(i): mesh(i, str) for i in range(3)}}


def model(**changes):
    """The layout of compas_model and compas_dem: elements, each with a place."""
    elements = {}
    for i in range(3):
        lift = {"matrix": np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, i], [0, 0, 0, 1]]).tolist()}
        data = {"geometry": typed("compas.datastructures/Mesh", mesh(0)), "is_support": i == 0, "features": []}
        data |= {"transformation": typed("compas.geometry/Translation", lift), "name": f"stone {i}"}
        elements[f"guid-{i}"] = typed("compas_dem.elements/Block", data | changes)
    return typed("compas_dem.models/BlockModel", {"transformation": None, "elements": elements})


def framed(x):
    """The model with a frame of each element."""
    axes = {"point": [x, 0.0, 0.0], "xaxis": [1.0, 0.0, 0.0], "yaxis": [0.0, 1.0, 0.0]}
    return model(frame=typed("compas.geometry/Frame", axes))


def with_data(**changes):
    content = model()
    content["data"] |= changes
    return content


def polyhedra():
    points = [[typed("compas.geometry/Point", [x, y, z + i]) for x, y, z in CUBE] for i in range(3)]
    return [[typed("compas.geometry/Polyhedron", {"vertices": p, "faces": QUADS}) for p in points]]


def read(tmp_path, content, **options):
    path = tmp_path / "assembly.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return bs.imports.read_assembly(path, **{"unit": "m", "material": STONE} | options)


@pytest.mark.parametrize(
    ("content", "names", "supports"),
    [
        (assembly(), ["0", "1", "2"], 1),
        (assembly("part"), ["0", "1", "2"], 1),
        (network(), ["0", "1", "2"], 0),
        (first(), ["0", "1", "2"], 1),
        (model(), ["stone 0", "stone 1", "stone 2"], 1),
        (model(name="Block"), ["0", "1", "2"], 1),
        (framed(0), ["stone 0", "stone 1", "stone 2"], 1),
        ([typed("Mesh", mesh(i, name=f"m{i}")) for i in range(3)], ["m0", "m1", "m2"], 0),
        (polyhedra(), ["0", "1", "2"], 0),
    ],
)
def test_every_layout(tmp_path, content, names, supports):
    found = read(tmp_path, content)
    assert [b.name for b in found.blocks] == names
    assert [b.fixed for b in found.blocks] == [supports > 0, False, False]
    for i, block in enumerate(found.blocks):
        assert block.centroid == pytest.approx((0.5, 0.5, i + 0.5))
    assert found.report.warnings == ()
    assert bs.detect_interfaces(found.blocks, joint_material=JOINT).report.accepted == 2


@pytest.mark.parametrize(("mark", "fixed"), [(1, True), (0, False), (None, False), (True, True), (False, False)])
@pytest.mark.parametrize("layout", [assembly, first, model])
def test_a_support_may_be_marked_by_a_number(tmp_path, layout, mark, fixed):
    text = json.dumps(layout()).replace('"is_support": true', f'"is_support": {json.dumps(mark)}')
    assert [b.fixed for b in read(tmp_path, text).blocks] == [fixed, False, False]


@pytest.mark.parametrize("mark", ["true", 2, [True]])
def test_refused_marks_of_a_support(tmp_path, mark):
    text = json.dumps(assembly()).replace('"is_support": true', f'"is_support": {json.dumps(mark)}')
    with refused(bs.errors.GeometryFileError, f"block 0: is_support {mark!r}"):
        read(tmp_path, text)


CUT = typed("compas_model.modifiers/BooleanModifier", {})


@pytest.mark.parametrize(
    ("words", "content"),
    [
        ("empty", ""),
        ("assembly.json", "[" * 100_000),
        ("'0'", '{"node": {"0": {}, "0": {}}}'),
        ("COMPAS found a", {"a": 1}),
        ("COMPAS int", "3"),
        ("COMPAS", {"blocks": {"0": {}}, "assembly": [1]}),
        ("matrix 4 × 4", model(transformation=[[1, 0], [0, 1]])),
        ("COMPAS", {"graph": {"node": [1, 2]}}),
        ("node 0 block, part", {"node": {"0": {"x": 1}}}),
        ("COMPAS", {"elements": [1]}),
        ("element 0 features", model(features=[{}])),
        ("element 0 frame", framed(10)),
        ("element 1 group", with_data(tree={"root": {"children": [{"children": [{"element": "guid-0"}]}]}})),
        ("modify", with_data(graph={"node": {"0": {}, "1": {}}, "edge": {"0": {"1": {"modifiers": [CUT]}}}})),
        ("block 0 mesh", model(geometry={"xsize": 1})),
        ("block 0 three corners", [mesh(0) | {"face": {"0": [0, 1]}}]),
        ("block 0 KeyError: '99'", [mesh(0) | {"face": {"0": [0, 1, 99]}}]),
    ],
)
def test_refused_files(tmp_path, words, content):
    with refused(bs.errors.GeometryFileError, words):
        read(tmp_path, content)


def test_a_group_without_transformation_is_read(tmp_path):
    lifted = model()
    grouped = model(transformation=None)
    for i, element in enumerate(grouped["data"]["elements"].values()):
        element["data"]["geometry"] = typed("compas.datastructures/Mesh", mesh(i))
    group = {"transformation": None, "features": [], "name": "storey"}
    grouped["data"]["elements"]["storey"] = typed("compas_model.elements/Group", group)
    grouped["data"]["tree"] = {"root": {"children": [{"element": "storey", "children": [{"element": "guid-0"}]}]}}
    found, expected = (read(tmp_path, content).blocks for content in (grouped, lifted))
    assert [(b.name, b.fixed) for b in found] == [(b.name, b.fixed) for b in expected]
    assert np.array_equal([b.centroid for b in found], [b.centroid for b in expected])


def test_a_geometry_that_is_a_list_is_read(tmp_path):
    def plates(*geometries):
        kind = "compas_assembly2.element/Element"
        data = [{"name": f"plate {k}", "geometry": g, "attributes": {}} for k, g in enumerate(geometries)]
        data[0]["attributes"]["is_support"] = True
        return [typed(kind, one) for one in data]

    parts = [[typed("compas.datastructures/Mesh", mesh(3 * k + i)) for i in range(2)] for k in range(2)]
    found = read(tmp_path, plates(*parts))
    assert [b.name for b in found.blocks] == ["plate 0.1", "plate 0.2", "plate 1.1", "plate 1.2"]
    assert found.report.supports == ("plate 0.1", "plate 0.2")
    for geometry in ([3], [[]], [{}]):
        with pytest.raises(bs.errors.GeometryFileError):
            read(tmp_path, plates(geometry))
