"""Blocks from building models, written by ifcopenshell."""

import numpy as np
import pytest

import blockstruct as bs

ifcopenshell = pytest.importorskip("ifcopenshell")
STONE, BRICK = bs.Material("stone", "20 kN/m^3"), bs.Material("brick", "18 kN/m^3")


class Building:
    """A building model in mm with one storey; sizes in m."""

    def __init__(self):
        import ifcopenshell.api

        self.run = ifcopenshell.api.run
        self.file = self.run("project.create_file")
        project = self.made("IfcProject", "project")
        self.run("unit.assign_unit", self.file, length={"is_metric": True, "raw": "MILLIMETERS"})
        model = self.run("context.add_context", self.file, context_type="Model")
        kind = {"context_type": "Model", "context_identifier": "Body", "target_view": "MODEL_VIEW"}
        self.body = self.run("context.add_context", self.file, parent=model, **kind)
        self.storey = self.made("IfcBuildingStorey", "Ground floor")
        self.run("aggregate.assign_object", self.file, products=[self.storey], relating_object=project)

    def made(self, kind, name):
        return self.run("root.create_entity", self.file, ifc_class=kind, name=name)

    def box(self, kind, name, corner, size, material=None, within=None):
        """Add an element that is a box, or an opening within an element."""
        element = self.made(kind, name)
        sizes = dict(zip(("length", "thickness", "height"), size, strict=True))
        shape = self.run("geometry.add_wall_representation", self.file, context=self.body, **sizes)
        self.run("geometry.assign_representation", self.file, product=element, representation=shape)
        place = np.eye(4)
        place[:3, 3] = corner
        self.run("geometry.edit_object_placement", self.file, product=element, matrix=place)
        if within is not None:
            self.run("feature.add_feature", self.file, feature=element, element=within)
            return element
        self.run("spatial.assign_container", self.file, products=[element], relating_structure=self.storey)
        if material:
            given = self.run("material.add_material", self.file, name=material)
            self.run("material.assign_material", self.file, products=[element], material=given)
        return element


@pytest.fixture
def house(tmp_path):
    """A wall with a door on a footing, and a door leaf."""
    made = Building()
    made.box("IfcFooting", "footing", (0, 0, -0.3), (3, 0.4, 0.3), "concrete")
    wall = made.box("IfcWall", "south", (0, 0, 0), (3, 0.4, 2.4), "brick")
    made.box("IfcOpeningElement", "hole", (1, -0.1, 0), (1, 0.6, 1.8), within=wall)
    made.box("IfcDoor", "door", (1, 0.1, 0), (1, 0.05, 1.8))
    made.file.write(str(tmp_path / "house.ifc"))
    return tmp_path / "house.ifc"


def test_bodies_storeys_materials_and_unit_are_kept(house):
    with pytest.warns(bs.errors.GeometryWarning, match="1 IfcDoor"):
        found = bs.imports.read_ifc(house, material={"concrete": STONE, "brick": BRICK}, supports=["IfcFooting"])
    assert [(b.name, b.material.name, b.material.unit_weight, b.fixed, round(b.volume, 9)) for b in found.blocks] == [
        ("Ground floor.footing", "concrete", 20e3, True, 0.36),
        ("Ground floor.south", "brick", 18e3, False, round((3 * 2.4 - 1.8) * 0.4, 9)),
    ]
    assert found.report.scale == 1e-3


def test_walls_are_cut_into_units_of_the_bond(house):
    with pytest.warns(bs.errors.GeometryWarning, match="1 IfcDoor"):
        found = bs.imports.read_ifc(house, material=BRICK, unit_length="50 cm", unit_height="20 cm", fixed="*footing")
    units = {b.name.removeprefix("Ground floor.south."): b for b in found.blocks[1:]}
    assert sum(b.volume for b in units.values()) == pytest.approx((3 * 2.4 - 1.8) * 0.4)
    # Whole units, then a half at the ends of every second course; one lintel over the door with half a unit of bearing.
    assert [k for k in units if k.startswith("1.")] == ["1.1", "1.2", "1.3", "1.4"]
    second = [round(b.volume / 0.08, 6) for k, b in units.items() if k.startswith("2.")]
    assert second == [0.25, 0.5, 0.25] * 2
    lintel = max(units.values(), key=lambda b: b.volume)
    np.testing.assert_allclose(np.ptp(lintel.shape.vertices, axis=0), [1.5, 0.4, 0.2], atol=1e-9)
    assert lintel.shape.vertices[:, 2].min() == pytest.approx(1.8)
    joints = bs.detect_interfaces(found.blocks, joint_material=bs.JointMaterial("mortar", 0.6))
    model = bs.Model("house", found.blocks, joints)
    assert len(model.interfaces) > 2 * len(units)


def test_a_wall_that_is_no_prism_stays_whole(tmp_path):
    made = Building()
    wall = made.box("IfcWall", "stepped", (0, 0, 0), (3, 0.4, 2.4))
    made.box("IfcOpeningElement", "niche", (1, -0.1, 1), (1, 0.2, 1), within=wall)
    made.box("IfcWall", "plain", (5, 0, 0), (1, 0.4, 0.4))
    made.file.write(str(tmp_path / "walls.ifc"))
    with pytest.warns(bs.errors.GeometryWarning, match=r"1 wall .*stepped"):
        found = bs.imports.read_ifc(tmp_path / "walls.ifc", material=BRICK, unit_length="0.5 m", unit_height="0.2 m")
    assert [b.name.removeprefix("Ground floor.") for b in found.blocks] == [
        "stepped",
        *("plain.1.1", "plain.1.2", "plain.2.1", "plain.2.2", "plain.2.3"),
    ]


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"material": {"marble": STONE}}, "no material 'marble'; it has brick, concrete"),
        ({"unit_length": "50 cm"}, "give unit_length and unit_height"),
        ({"supports": "IfcWal"}, "IFC4 has no class 'IfcWal'"),
        ({"fixed": "attic"}, "no block 'attic' to fix"),
    ],
)
def test_bad_requests_are_refused(house, changes, expected):
    with pytest.raises(bs.errors.BlockstructError, match=expected):
        bs.imports.read_ifc(house, **({"material": STONE} | changes))


@pytest.mark.parametrize("content", [b"no ifc file", b"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;"])
def test_a_damaged_file_is_refused(tmp_path, content):
    (tmp_path / "bad.ifc").write_bytes(content)
    with pytest.raises(bs.errors.GeometryFileError, match="not a readable IFC file"):
        bs.imports.read_ifc(tmp_path / "bad.ifc", material=STONE)
