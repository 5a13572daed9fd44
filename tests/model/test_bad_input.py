"""Bad input: every refusal names the object, the value, the limit and the remedy."""

import math
import re

import numpy as np
import pytest

import blockstruct as bs
from blockstruct import Q_
from blockstruct.geometry import polyhedron
from structures import model_of, push, single_block, solve

STONE = bs.Material("stone", "20 kN/m^3")
JOINT = bs.JointMaterial("joint", 0.65)
CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def box(name, x=0.0, z=0.0, fixed=False):
    return bs.Block.box(name, Q_([x, 0, z], "m"), Q_([1, 1, 1], "m"), STONE, fixed=fixed)


def refused(error, *words):
    """Context that expects an error whose message has all words."""
    return pytest.raises(error, match="".join(f"(?=.*{re.escape(w)})" for w in words) + "(?s:.*)")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bs.Material("tuff", unit_weight=12), ["'tuff'", "12", "no unit", "Q_("]),
        (lambda: bs.Material("tuff", density=1800.0), ["'tuff'", "1800", "density"]),
        (lambda: bs.JointMaterial("j", friction_angle=30), ["'j'", "30", "angle"]),
        (lambda: bs.JointMaterial("j", 0.6, cohesion=0.1), ["'j'", "cohesion", "0.1"]),
        (lambda: bs.Block.box("b", [0, 0, 0], Q_([1, 1, 1], "m"), STONE), ["'b'", "origin", "no unit"]),
        (lambda: bs.Block.from_faces("b", CUBE, FACES, STONE), ["'b'", "vertices", "no unit"]),
        (lambda: bs.PointLoad("b", Q_([0, 0, 0], "m"), [1, 0, 0]), ["'b'", "force", "no unit"]),
        (lambda: bs.Interface("i", "a", "b", CUBE[:4], JOINT), ["'i'", "polygon", "no unit"]),
        (lambda: bs.Material("tuff", Q_([1, 2], "kN/m^3")), ["'tuff'", "2 numbers", "give one"]),
        (lambda: bs.JointMaterial("j", [0.1, 0.2]), ["'j'", "2 numbers"]),
        (lambda: bs.JointMaterial("j", True), ["'j'", "True"]),
        (lambda: bs.Moment("b", [1, 0, 0]), ["'b'", "moment", "no unit"]),
        (lambda: bs.detect_interfaces([], JOINT, tolerance=0.001), ["tolerance", "0.001", "no unit"]),
        (lambda: bs.Material("tuff", "heavy"), ["'tuff'", "'heavy'", "'0.4 m'"]),
        (lambda: bs.Material("tuff", "12 9**9**9"), ["'tuff'", "is not a unit"]),
        (lambda: bs.Material("tuff", "12 kN/(m"), ["'tuff'", "is no"]),
        (lambda: bs.Material("tuff", "12 +++"), ["'tuff'", "is no"]),
        (lambda: bs.Material("tuff", "1e 5 kN"), ["'tuff'", "is no"]),
        (lambda: bs.Material("tuff", ""), ["'tuff'", "is not a quantity"]),
        (lambda: bs.Material("tuff", "12 kN/m3"), ["'tuff'", "m3", "'12 kN/m^3'"]),
        (lambda: bs.Material("tuff", "12,5 kN/m^3"), ["'tuff'", "12,5", "is not a quantity"]),
        (lambda: bs.BodyForce("[1, 0, 0"), ["[1, 0, 0", "has no end"]),
        (lambda: bs.JointMaterial("j", "0,65"), ["'j'", "0,65", "is not a quantity"]),
        (lambda: bs.Material("tuff", "__import__('os') kN/m^3"), ["'tuff'", "is not a quantity"]),
        # To pint they are 907 kg.
        (lambda: bs.Material("tuff", density="1.8 ton/m^3"), ["'tuff'", "1000 kg", "907 kg", "give 't' or 'tf'"]),
        (lambda: bs.Material("tuff", Q_(1.8, "ton_force/m^3")), ["'tuff'", "'US_force_ton'"]),
        (lambda: bs.PointLoad("b", Q_([0, 0, 0], "m"), "[0, 0, -2] kiloton_force"), ["'b'", "907 kg"]),
    ],
)
def test_a_unit_is_due(make, words):
    with refused(bs.errors.UnitError, *words):
        make()
    with pytest.raises(TypeError):
        make()


@pytest.mark.parametrize(("unit", "expected"), [("t", 9806.65), ("US_ton", 8896.443230521)])
def test_a_ton_of_one_meaning(unit, expected):
    assert bs.Material("tuff", density=f"1 {unit}/m^3").unit_weight == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bs.Material("tuff", Q_(12, "kN/m^2")), ["'tuff'", "kilonewton / meter ** 2", "force/volume"]),
        (lambda: bs.JointMaterial("j", Q_(0.6, "m")), ["'j'", "friction coefficient", "a plain number"]),
        (lambda: bs.Block.box("b", Q_([0, 0, 0], "s"), Q_([1, 1, 1], "m"), STONE), ["'b'", "second", "length"]),
        (lambda: bs.Block.box("b", Q_([0, 0], "m"), Q_([1, 1, 1], "m"), STONE), ["'b'", "2 components", "three"]),
        (lambda: bs.Material("tuff", Q_(math.nan, "kN/m^3")), ["'tuff'", "not finite"]),
        (lambda: bs.Block.box("b", Q_([0, 0, 0], "m"), Q_([1, math.inf, 1], "m"), STONE), ["'b'", "not finite"]),
        (lambda: bs.BodyForce((1, math.nan, 0)), ["direction", "not finite"]),
        (lambda: bs.Material("tuff", Q_(12, "degC")), ["'tuff'", "force/volume"]),
        # To pint an angle is a number: 35 degrees would pass for a friction coefficient of 0.61.
        (lambda: bs.JointMaterial("j", "35 deg"), ["'j'", "friction coefficient", "degree", "plain number"]),
        (lambda: bs.JointMaterial("j", Q_(0.6, "rad")), ["'j'", "radian", "plain number"]),
        (lambda: bs.JointMaterial("j", friction_angle="0.65"), ["'j'", "friction angle", "angle"]),
        (lambda: bs.JointMaterial("j", friction_angle=Q_(0.65, "")), ["'j'", "friction angle", "30 deg"]),
        (lambda: bs.JointMaterial("j", 0.5, dilatancy_angle="0.1 dimensionless"), ["'j'", "dilatancy angle"]),
        (lambda: bs.JointMaterial("j", "3 dB"), ["'j'", "'decibel'", "does not fit"]),
    ],
)
def test_wrong_dimension_or_no_number(make, words):
    with refused(bs.errors.DimensionError, *words):
        make()
    assert issubclass(bs.errors.DimensionError, ValueError)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bs.Material("tuff"), ["'tuff'", "either unit_weight or density"]),
        (lambda: bs.Material("tuff", "1 N/m^3", density="1 kg/m^3"), ["'tuff'", "either"]),
        (lambda: bs.Material("tuff", "-1 N/m^3"), ["'tuff'", "-1", "negative"]),
        (lambda: bs.Material("", "1 N/m^3"), ["''", "name"]),
        (lambda: bs.JointMaterial("j"), ["'j'", "friction_coefficient or friction_angle"]),
        (lambda: bs.JointMaterial("j", -0.1), ["'j'", "-0.1", "negative"]),
        (lambda: bs.JointMaterial("j", friction_angle="90 deg"), ["'j'", "90 degrees"]),
        (lambda: bs.JointMaterial("j", 35), ["'j'", "35", "friction_angle with its unit"]),
        (lambda: bs.LoadPattern("p", bs.SelfWeight()), ["'p'", "SelfWeight()", "is not a list"]),
        (lambda: bs.Model("m", [box("a")], "found"), ["'m'", "interfaces", "'found'"]),
        (lambda: bs.Model("m", bs.detect_interfaces([], JOINT), []), ["'m'", "blocks", "is not a list"]),
        (lambda: bs.AnalysisManager("m"), ["'m'", "give a Model"]),
        (lambda: bs.JointMaterial("j", 0.5, dilatancy_angle="40 deg"), ["'j'", "dilatancy", "friction angle"]),
        (lambda: bs.JointMaterial("j", 0.5, tensile_strength="-1 Pa"), ["'j'", "tensile strength", "negative"]),
        (
            lambda: bs.JointMaterial("j", 0.5, tensile_strength="1 Pa"),
            ["'j'", "tensile strength", "raise the cohesion"],
        ),
        (lambda: bs.Block.box("b", Q_([0, 0, 0], "m"), Q_([1, 1, 1], "m"), STONE, fixed="no"), ["'b'", "'no'", "True"]),
        (lambda: bs.JointMaterial("j", 0.5, compressive_strength="0 MPa"), ["'j'", "compressive strength", "infinite"]),
        (lambda: bs.BodyForce((0, 0, 0)), ["direction", "zero"]),
        (lambda: bs.BodyForce((2, 0, 0)), ["direction", "length 2", "share=2"]),
        (lambda: bs.BodyForce("y"), ["direction 'y'", "+x, -x, +y", "three numbers"]),
        (lambda: bs.BodyForce("+x", share=0), ["share 0"]),
        (lambda: bs.JointMaterial("j", 0.5, normal_stiffness="0 Pa/m"), ["normal stiffness", "0 Pa/m"]),
        (lambda: bs.LoadPattern("p", ["weight"]), ["'p'", "'weight'", "SelfWeight"]),
        (lambda: bs.LimitCase("c", bs.SelfWeight(), push(1, 0, 0)), ["'c'", "dead", "LoadPattern"]),
        (lambda: bs.LimitCase("c", push(1, 0, 0), push(1, 0, 0), "dilatant"), ["'c'", "'dilatant'", "associative"]),
        (lambda: bs.ProcedureSettings(schedule=bs.FictitiousSchedule(relaxation=2.0)), ["relaxation", "2.0", "1"]),
        (
            lambda: bs.ProcedureSettings(schedule=bs.FictitiousSchedule(max_programs=3.5)),
            ["max_programs", "3.5", "whole"],
        ),
        (
            lambda: bs.ProcedureSettings(numerics=bs.Numerics(yield_tolerance=0.1)),
            ["yield_tolerance", "0.1", "to 0.01"],
        ),
        (
            lambda: bs.ProcedureSettings(schedule=bs.FictitiousSchedule(relaxation_min=0.9)),
            ["relaxation_min", "0.9", "relaxation_max", "0.8"],
        ),
        (lambda: bs.ProcedureSettings.of({"speed": 1}), ["speed", "known are"]),
        (lambda: bs.detect_interfaces([], JOINT, tolerance="0 m"), ["tolerance", "0 m", "above zero"]),
        (lambda: bs.detect_interfaces([], "lime"), ["'lime'", "JointMaterial"]),
        (lambda: bs.Block("b", box("x").shape, "tuff"), ["'b'", "'tuff'", "Material"]),
    ],
)
def test_values_without_mechanical_meaning(make, words):
    with refused(bs.errors.ModelError, *words):
        make()


def test_a_misspelt_key_of_settings_is_told_the_one_that_was_meant():
    with refused(bs.errors.UnknownKeywordError, "FictitiousSchedule", "did you mean max_programs?"):
        bs.FictitiousSchedule.of({"max_program": 3})


@pytest.mark.parametrize(
    "call",
    [
        lambda long: bs.detect_interfaces([box("a")], {"*": long}),
        lambda long: bs.run(bs.Model("m", [box("a")], []), long),
        lambda long: bs.ProcedureSettings(numerics=bs.Numerics(solver=long)),
        lambda long: bs.AnalysisManager(bs.Model("m", [box("a")], []), long),
        lambda long: bs.imports.read_mesh("m.obj", unit="m", material=STONE, up=long),
    ],
)
def test_a_value_that_prints_at_length_is_cut_short_where_it_is_refused(call):
    with pytest.raises(bs.errors.BlockstructError) as caught:
        call([push(1, 0, 0)] * 1000)
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize("weight", ["18 kN/mm^3", "18 N/m^3", "4.9 kN/m^3", "91 kN/m^3"])
def test_an_unusual_unit_weight_is_asked_about(weight):
    words = r"'tuff': a unit weight of .* from 5 to 90 kN/m\^3; is its unit right"
    with pytest.warns(bs.errors.UnusualValueWarning, match=words) as caught:
        assert bs.Material("tuff", weight).unit_weight > 0
    # It names the line of the user.
    assert caught[0].filename == __file__


def test_usual_and_zero_unit_weights_are_not_asked_about():
    assert [bs.Material("m", w).unit_weight for w in ("0 N/m^3", "5 kN/m^3", "90 kN/m^3")] == [0, 5e3, 9e4]
    assert bs.Material("m", density="2000 kg/m^3").unit_weight == pytest.approx(19613.3)


def test_a_long_text_of_a_unit_is_not_searched():
    with refused(bs.errors.UnitError, "'tuff'", "300 characters", "write one as '12 kN/m^3'"):
        bs.Material("tuff", "1 " + "k" * 298)


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (CUBE, FACES[:-1], ["'b'", "open at edge", "add the missing face"]),
        (CUBE, [f[::-1] for f in FACES], ["'b'", "inside out", "counter-clockwise"]),
        (CUBE, [FACES[0][::-1], *FACES[1:]], ["'b'", "edge", "same way"]),
        (CUBE * [1, 1, 0], FACES, ["'b'", "no area"]),
        (CUBE + np.eye(8, 3) * 0.01, FACES, ["'b'", "not planar", "m off its plane"]),
        (CUBE, [*FACES[:-1], [3, 0, 4, 9]], ["'b'", "(3, 0, 4, 9)", "outside 0..7"]),
        (CUBE, [*FACES[:-1], [3, 0, 0, 7]], ["'b'", "each named once"]),
        (CUBE[:3], FACES[:1], ["'b'", "four points"]),
        (np.vstack([CUBE, [9, 9, 9]]), FACES, ["'b'", "no face uses", "[8]"]),
        (CUBE, None, ["'b'", "None", "list of faces"]),
        (CUBE, [[0.4, 3, 2, 1], *FACES[1:]], ["'b'", "whole vertex numbers"]),
        (CUBE, FACES[:3], ["'b'", "3 faces"]),
    ],
)
def test_shapes_that_are_no_block(vertices, faces, words):
    with refused(bs.errors.GeometryError, *words):
        bs.Block.from_faces("b", Q_(vertices, "m"), faces, STONE)


def test_boxes_without_volume():
    with refused(bs.errors.GeometryError, "'b'", "above zero"):
        bs.Block.box("b", Q_([0, 0, 0], "m"), Q_([1, 0, 1], "m"), STONE)


@pytest.mark.parametrize(
    ("blocks", "error", "words"),
    [
        ([box("a", fixed=True), box("a", z=1)], bs.errors.ModelError, ["more than once", "a"]),
        ([box("a"), box("b", z=1)], bs.errors.ModelError, ["no block is fixed", "fixed=True"]),
        ([box("a", fixed=True)], bs.errors.ModelError, ["every block is fixed"]),
        (
            [box("a", fixed=True), box("b", z=1), box("c", x=9)],
            bs.errors.ModelError,
            ["floating blocks, 1 in all", "c", "tolerance"],
        ),
        ([box("a", fixed=True), box("b", z=1.01)], bs.errors.ModelError, ["floating", "b"]),
        ([box("a", fixed=True), box("b", z=0.5)], bs.errors.GeometryError, ["'a' and 'b' by 0.5 m", "move or cut"]),
    ],
)
def test_models_that_cannot_stand(blocks, error, words):
    with refused(error, *words):
        model_of(blocks, JOINT)


def test_overlapping_blocks_are_named_with_their_depth():
    blocks = [box("a", fixed=True), box("b", z=1), box("c", x=0.25, z=1.0)]
    with refused(bs.errors.GeometryError, "'b'", "'c'", "0.75 m", "move or cut"):
        model_of(blocks, JOINT)


def test_an_interface_of_an_unknown_block():
    polygon = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], dtype=float)
    interface = bs.Interface("i", "a", "nobody", Q_(polygon, "m"), JOINT)
    with refused(bs.errors.UnknownNameError, "'i'", "'nobody'"):
        bs.Model("m", [box("a", fixed=True), box("b", z=1)], [interface])
    with pytest.raises(KeyError):
        bs.Model("m", [box("a", fixed=True), box("b", z=1)], [interface])


@pytest.mark.parametrize(
    ("polygon", "words"),
    [
        ([[0, 0, 0], [1, 0, 0]], ["'i'", "three or more"]),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], ["'i'", "no area"]),
        ([[0, 0, 0.3], [1, 0, -0.3], [1, 1, 0.3], [0, 1, -0.3]], ["'i'", "off the plane fitted", "divide the contact"]),
    ],
)
def test_interfaces_without_area_or_plane(polygon, words):
    with refused(bs.errors.GeometryError, *words):
        bs.Interface("i", "a", "b", Q_(np.array(polygon, dtype=float), "m"), JOINT)


SQUARE = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)


@pytest.mark.parametrize(
    ("polygons", "words"),
    [
        ([SQUARE[::-1]], ["'i0'", "does not lie on a face", "counter-clockwise"]),
        ([np.add(SQUARE, [5, 0, 3])], ["'i0'", "does not lie on a face"]),
        ([(SQUARE - 0.5) * [10, 10, 1] + 0.5], ["'i0'", "does not lie on a face"]),
        ([SQUARE[:, [2, 0, 1]]], ["'i0'", "does not lie on a face"]),
        ([SQUARE, SQUARE * [0.5, 1, 1]], ["'i0'", "'i1'", "same area", "remove one"]),
        # The lever of a spike is that of its tip, with as good as no area and with none.
        ([np.insert(SQUARE, 2, [[1, 0.499, 1], [3, 0.5, 1], [1, 0.501, 1]], axis=0)], ["'i0'", "a corner 2 m beside"]),
        ([np.insert(SQUARE, 2, [[1, 0.5, 1], [3, 0.5, 1], [1, 0.5, 1]], axis=0)], ["'i0'", "a corner 2 m beside"]),
    ],
)
def test_interfaces_that_do_not_fit_their_blocks(polygons, words):
    interfaces = [bs.Interface(f"i{k}", "a", "b", Q_(p, "m"), JOINT) for k, p in enumerate(polygons)]
    with refused(bs.errors.GeometryError, *words):
        bs.Model("m", [box("a", fixed=True), box("b", z=1)], interfaces)


@pytest.mark.parametrize(("tip", "fits"), [(0.06, False), (0.01, False), (0.002, True)])
def test_a_spike_of_a_long_joint_is_held_against_its_width(tip, fits):
    """5 m × 0.3 m: with 60 mm more the lever across it would be 0.21 m and not 0.15 m."""
    blocks = [
        bs.Block.box(name, Q_([0, 0, z], "m"), Q_([5, 0.3, 1], "m"), STONE, fixed=z == 0)
        for z, name in enumerate(("a", "b"))
    ]
    spike = [[2.51, 0.3, 1], [2.5, 0.3 + tip, 1], [2.49, 0.3, 1]]
    polygon = np.array([[0, 0, 1], [5, 0, 1], [5, 0.3, 1], *spike, [0, 0.3, 1]])
    interface = bs.Interface("i", "a", "b", Q_(polygon, "m"), JOINT)
    if fits:
        bs.Model("m", blocks, [interface])
    else:
        with refused(bs.errors.GeometryError, "'i'", f"a corner {tip} m beside"):
            bs.Model("m", blocks, [interface])


def test_an_interface_of_which_rounded_corners_leave_the_tips():
    interface = bs.Interface("i", "a", "b", Q_((SQUARE - 0.5) * [1.004, 1.004, 1] + 0.5, "m"), JOINT)
    assert len(bs.Model("m", [box("a", fixed=True), box("b", z=1)], [interface]).interfaces) == 1


def test_an_interface_beside_its_face_within_its_box():
    """A square on edge in plan: the box around it has twice its area."""
    turn = np.array([[1, -1, 0], [1, 1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)
    stone = bs.Block.from_faces("b", Q_((CUBE - [0.5, 0.5, 0]) @ turn.T + [0, 0, 1], "m"), FACES, STONE)
    ground = bs.Block.box("a", Q_([-2, -2, 0], "m"), Q_([4, 4, 1], "m"), STONE, fixed=True)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / np.sqrt(2)
    around = bs.Interface("i", "a", "b", Q_(np.column_stack([corners, np.ones(4)]), "m"), JOINT)
    with refused(bs.errors.GeometryError, "'i'", "'b'", "1 of its 2 m^2"):
        bs.Model("m", [ground, stone], [around])


def test_a_joint_in_mid_air_beside_large_blocks():
    ground = bs.Block.box("ground", Q_([-5, -5, -1], "m"), Q_([30, 10, 1], "m"), STONE, fixed=True)
    cube = bs.Block.box("cube", Q_([10, -5, 0], "m"), Q_([10, 10, 10], "m"), STONE)
    tile = bs.Block.box("tile", Q_([0, 0, 0.7], "m"), Q_([0.2, 0.2, 0.05], "m"), STONE)
    between = bs.Interface("air", "ground", "tile", Q_(SQUARE * [0.2, 0.2, 0.35], "m"), JOINT)
    found = bs.detect_interfaces([ground, cube, tile], JOINT, explicit=[between])
    with refused(bs.errors.GeometryError, "'air'", "'ground'", "0 of its 0.04 m^2", "up to 0.01 m before it"):
        bs.Model("m", [ground, cube, tile], found.interfaces)


def test_an_interface_between_supports():
    blocks = [box("a", fixed=True), box("b", z=1), box("c", x=1, fixed=True)]
    joint = bs.Interface("i", "a", "c", Q_(SQUARE[:, [2, 0, 1]], "m"), JOINT)
    found = bs.detect_interfaces(blocks, JOINT)
    with refused(bs.errors.ModelError, "'i' joins two supports, 'a' and 'c'", "remove it"):
        bs.Model("m", blocks, [*found.interfaces, joint])


def test_a_polygon_in_millimetres_is_in_millimetres():
    assert bs.Interface("i", "a", "b", Q_(1000 * SQUARE, "mm"), JOINT).area == pytest.approx(1.0)


def test_slight_penetration_is_contact_or_an_error_but_never_nothing():
    # 0.05 mm on blocks of 1 m: found as contact with a tolerance above it, refused as overlap below.
    blocks = [box("a", fixed=True), box("b", z=1), box("c", x=1 - 5e-5, z=1), box("g", x=1.0, fixed=True)]
    blocks[3] = box("g", x=1.0 + 1e-9, fixed=True)
    with refused(bs.errors.GeometryError, "'b' and 'c'", "tolerance above 5e-05 m"):
        model_of(blocks, JOINT)
    found = bs.detect_interfaces(blocks, JOINT, tolerance="0.1 mm")
    assert "b|c" in [i.name for i in bs.Model("m", blocks, found.interfaces).interfaces]


def test_arrays_of_a_model_are_frozen(small_model):
    with pytest.raises(ValueError, match="read-only"):
        small_model.interfaces[0].polygon[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        small_model.blocks[0].shape.vertices[0] = 0


def test_different_materials_of_one_name():
    other = bs.Material("stone", "21 kN/m^3")
    odd = bs.Block.box("b", Q_([0, 0, 1], "m"), Q_([1, 1, 1], "m"), other)
    with refused(bs.errors.ModelError, "different materials", "stone"):
        model_of([box("a", fixed=True), odd], JOINT)


@pytest.mark.parametrize(
    ("variable", "error", "words"),
    [
        ([], bs.errors.ModelError, ["'case'", "'v'", "zero on every free block"]),
        (
            [bs.PointLoad("ground", Q_([0, 0, 0], "m"), Q_([1, 0, 0], "N"))],
            bs.errors.ModelError,
            ["zero on every free"],
        ),
        (
            [bs.PointLoad("nobody", Q_([0, 0, 0], "m"), Q_([1, 0, 0], "N"))],
            bs.errors.UnknownNameError,
            ["'nobody'", "block"],
        ),
        (
            [bs.PointLoad("block", Q_([50, 50, 100], "m"), Q_([1, 0, 0], "N"))],
            bs.errors.ModelError,
            ["'block'", "outside", "Moment"],
        ),
        ([bs.FaceLoad("block", 6, Q_([1, 0, 0], "Pa"))], bs.errors.ModelError, ["'block'", "face 6", "0..5"]),
    ],
)
def test_loads_the_model_cannot_take(variable, error, words):
    model = model_of(*single_block(1.0, 1.0))
    with refused(error, *words):
        solve(model, bs.LoadPattern("v", variable))


def test_cases_are_checked_before_anything_is_solved(small_model, small_cases, tmp_path):
    manager = bs.AnalysisManager(small_model, tmp_path / "x.h5")
    with refused(bs.errors.ModelError, "no case"):
        manager.run([])
    with refused(bs.errors.ModelError, "more than once", small_cases[0].name):
        manager.run([small_cases[0], small_cases[0]])
    other = bs.LimitCase("other", bs.LoadPattern("dead", [bs.BodyForce("-z", share=2)]), push(1, 0, 0))
    with refused(bs.errors.ModelError, "'dead'", "different loads"):
        manager.run([small_cases[0], other])
    with refused(bs.errors.ModelError, "cases", "is not a list", "LimitCase"):
        manager.run(small_cases[0])
    with refused(bs.errors.ModelError, "settings", "ProcedureSettings"):
        bs.AnalysisManager(small_model, settings={"patience": 3})
    assert list(tmp_path.iterdir()) == []


def test_unknown_solvers(small_model):
    with refused(bs.errors.SolverError, "'mosek'", "clarabel"):
        bs.AnalysisManager(small_model, settings=bs.ProcedureSettings(numerics=bs.Numerics(solver="mosek")))
    with refused(bs.errors.SolverError, "'NOSUCH'", "not installed"):
        bs.AnalysisManager(small_model, settings=bs.ProcedureSettings(numerics=bs.Numerics(solver="cvxpy:NOSUCH")))
    with refused(bs.errors.SolverError, "'OSQP'", "no second-order cones", "CLARABEL"):
        bs.AnalysisManager(small_model, settings=bs.ProcedureSettings(numerics=bs.Numerics(solver="cvxpy:OSQP")))


def test_unknown_cases_are_named(small_analysis):
    with refused(bs.errors.UnknownNameError, "'nothing'", "push associative"):
        small_analysis["nothing"]
    assert small_analysis.get("nothing") is None


def test_paths_that_cannot_be_written_are_refused_before_the_run(small_model, tmp_path):
    with refused(bs.errors.StorageError, "is a folder"):
        bs.AnalysisManager(small_model, tmp_path)
    (tmp_path / "file").write_text("x")
    with refused(bs.errors.StorageError, "not a blockstruct analysis", "not replaced", "another name"):
        bs.AnalysisManager(small_model, tmp_path / "file")
    assert (tmp_path / "file").read_text() == "x"
    with refused(bs.errors.StorageError, "cannot be written", "choose a folder"):
        bs.AnalysisManager(small_model, tmp_path / "file" / "x.h5")
    with refused(OSError, "cannot be written"):
        bs.AnalysisManager(small_model, "/proc/blockstruct/x.h5")
    (tmp_path / "p.h5.partial").write_text("x")
    with refused(bs.errors.StorageError, "p.h5.partial: is a file", "move that file away, or choose another name"):
        bs.AnalysisManager(small_model, tmp_path / "p.h5")


def test_vertices_that_are_no_numbers_are_refused_wherever_they_come_from():
    corners = CUBE.copy()
    corners[3, 1] = np.nan
    with refused(bs.errors.GeometryError, "'b'", "vertex 3 is not finite"):
        polyhedron(corners, FACES, "b")


def test_a_joint_is_varied_by_its_friction_angle():
    assert JOINT.varied(friction_angle="45 deg").friction_coefficient == pytest.approx(1.0)


def test_settings_take_numbers_of_numpy():
    settings = bs.ProcedureSettings(
        schedule=bs.FictitiousSchedule(max_programs=np.int64(5)), numerics=bs.Numerics(gap_tolerance=np.float64(1e-4))
    )
    assert type(settings.schedule.max_programs) is int
    assert type(settings.numerics.gap_tolerance) is float
