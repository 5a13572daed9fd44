"""Blocks from Rhino files, written by rhino3dm."""

import numpy as np
import pytest

import blockstruct as bs

r3 = pytest.importorskip("rhino3dm")
STONE, TUFF = bs.Material("stone", "20 kN/m^3"), bs.Material("tuff", "12 kN/m^3")


@pytest.fixture
def drawn(tmp_path):
    """Return a function that writes a file in mm with layers and gives its path; it fills the file first."""

    def write(*fillings, layers=("Base", "Wall"), unit="Millimeters"):
        file = r3.File3dm()
        file.Settings.ModelUnitSystem = getattr(r3.UnitSystem, unit)
        for name in layers:
            layer = r3.Layer()
            layer.Name = name
            file.Layers.Add(layer)
        for fill in fillings:
            fill(file)
        assert file.Write(str(tmp_path / "made.3dm"), 8)
        return tmp_path / "made.3dm"

    return write


def attributes(layer, name=""):
    made = r3.ObjectAttributes()
    made.LayerIndex, made.Name = layer, name
    return made


def brep(low, high):
    return r3.Brep.CreateFromBox(r3.Box(r3.BoundingBox(r3.Point3d(*low), r3.Point3d(*high))))


def outline(*corners):
    line = r3.Polyline(len(corners) + 1)
    for x, y in (*corners, corners[0]):
        line.Add(x, y, 0)
    return line.ToPolylineCurve()


def base(file):
    file.Objects.AddBrep(brep((-500, 0, -200), (500, 500, 0)), attributes(0))


def mesh(file):
    made = r3.Mesh()
    for x, y, z in np.ndindex(2, 2, 2):
        made.Vertices.Add(500.0 * x, 500.0 * y, 500.0 * z)
    for face in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
        made.Faces.AddFace(*face)
    file.Objects.AddMesh(made, attributes(1, "mesh"))


def inserted(file):
    """A stone drawn at the origin, inserted on top of the mesh, 100 mm to the right."""
    file.InstanceDefinitions.Add(
        "stone", "", "", "", r3.Point3d(0, 0, 0), (brep((0, 0, 0), (500, 500, 500)),), (attributes(1),)
    )
    place = r3.Transform.Translation(r3.Vector3d(100, 0, 500))
    file.Objects.AddInstanceObject(r3.InstanceReference(file.InstanceDefinitions[0].Id, place), attributes(1))


def test_layers_give_material_and_support_and_the_file_its_unit(drawn):
    path = drawn(base, mesh, inserted)
    found = bs.imports.read_rhino(path, material={"Base": STONE, "Wall": TUFF}, supports=["Base"])
    assert [(b.name, b.material.name, b.fixed, round(b.volume, 9)) for b in found.blocks] == [
        ("Base.1", "stone", True, 0.1),
        ("mesh", "tuff", False, 0.125),
        ("Wall.2", "tuff", False, 0.125),
    ]
    np.testing.assert_allclose(found.blocks[2].shape.vertices.min(axis=0), [0.1, 0, 0.5], atol=1e-12)
    assert found.report.scale == 1e-3
    assert found.report.left_out == ()


def test_an_extrusion_with_a_hole_keeps_its_hole(drawn):
    def frame(file):
        made = r3.Extrusion.Create(outline((0, 0), (4, 0), (4, 3), (2, 5), (0, 3)), 2.0, True)
        assert made.AddInnerProfile(outline((1, 1), (1, 2), (2, 2), (2, 1)))
        file.Objects.AddExtrusion(made, attributes(1))

    (block,) = bs.imports.read_rhino(drawn(frame, unit="Meters"), material=STONE).blocks
    assert block.volume == pytest.approx((4 * 3 + 4 - 1) * 2)


def test_what_is_not_a_block_is_listed(drawn):
    def others(file):
        file.Objects.AddPoint(r3.Point3d(0, 0, 0))
        drum = r3.Brep.CreateFromCylinder(r3.Cylinder(r3.Circle(1.0), 2.0), True, True)
        file.Objects.AddBrep(drum, attributes(1, "drum"))
        file.Layers[0].Visible = True

    path = drawn(base, others)
    with pytest.warns(bs.errors.GeometryWarning, match="left out"):
        found = bs.imports.read_rhino(path, material=STONE, fixed="lowest")
    assert len(found.report.left_out) == 2
    assert "drum" in found.report.left_out[0]
    with pytest.raises(bs.errors.UnknownNameError, match=r"no layer 'Walls'; it has Base, Wall"):
        bs.imports.read_rhino(path, material={"Walls": STONE})
    with pytest.raises(bs.errors.GeometryFileError, match=r"its unit is 0\.001 m"):
        bs.imports.read_rhino(path, material=STONE, unit="m")
    (tmp := path.with_name("bad.3dm")).write_bytes(b"no rhino file")
    with pytest.raises(bs.errors.GeometryFileError, match="not a readable Rhino file"):
        bs.imports.read_rhino(tmp, material=STONE)
