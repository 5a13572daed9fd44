"""Refused input: the class of the error, and the object, field, value and limit that it names."""

import math
from contextlib import nullcontext

import numpy as np
import pytest

import blockstruct as bs
import meshes
import structures
from blockstruct import Q_
from blockstruct.geometry.polyhedron import polyhedron
from refusals import refused
from structures import SELF_WEIGHT, STONE, model_of, push, settings_of, single_block, solve

JOINT = bs.JointMaterial("joint", 0.65)
CUBE, FACES = np.array(meshes.CUBE, dtype=float), meshes.QUADS
ORIGIN, OTHER = Q_([0, 0, 0], "m"), bs.Material("stone", "21 kN/m^3")
MODEL, UNIT, DIMENSION = bs.errors.ModelError, bs.errors.UnitError, bs.errors.DimensionError
GEOMETRY, UNKNOWN = bs.errors.GeometryError, bs.errors.UnknownNameError
A, B, LOW = ["0 m", "0 m", "2 m"], ["1 m", "1 m", "2 m"], ["0 m", "0 m", "1 m"]
FILL = "18 kN/m^3"


def box(name, x=0.0, z=0.0, size=(1, 1, 1), fixed=False):
    return structures.box(name, [x, 0, z], size, fixed=fixed)


@pytest.mark.parametrize(
    ("error", "words", "make"),
    [
        # A unit is missing, or the value is not one number.
        (UNIT, "'tuff' unit_weight 12 kN/m^3", lambda: bs.Material("tuff", unit_weight=12)),
        (UNIT, "'j' friction_angle 30", lambda: bs.JointMaterial("j", friction_angle=30)),
        (UNIT, "'b' force", lambda: bs.PointLoad("b", ORIGIN, [1, 0, 0])),
        (UNIT, "tolerance 0.001", lambda: bs.detect_interfaces([], JOINT, tolerance=0.001)),
        (UNIT, "'tuff' 2 numbers", lambda: bs.Material("tuff", Q_([1, 2], "kN/m^3"))),
        (UNIT, "'j' True", lambda: bs.JointMaterial("j", True)),
        # The text is not a quantity.
        *(
            (UNIT, f"'tuff' unit_weight {words}", lambda text=text: bs.Material("tuff", text))
            for text, words in [
                ("heavy", "'heavy'"),
                ("12 9**9**9", "9**9**9"),
                ("12 kN/(m", "kN/(m"),
                ("", "quantity"),
                ("12,5 kN/m^3", "12,5 '12.5 kN/m^3'"),
                ("__import__('os') kN/m^3", "quantity"),
                ("1 " + "k" * 298, "300"),
            ]
        ),
        (UNIT, "[1, 0, 0", lambda: bs.BodyForce("[1, 0, 0")),
        # To pint a ton is 907 kg.
        (UNIT, "'tuff' 1000 907 'tf'", lambda: bs.Material("tuff", density="1.8 ton/m^3")),
        # The dimension is wrong, or the value is not finite.
        (DIMENSION, "'tuff' kilonewton force/volume", lambda: bs.Material("tuff", Q_(12, "kN/m^2"))),
        (DIMENSION, "'tuff' finite", lambda: bs.Material("tuff", Q_(math.nan, "kN/m^3"))),
        (DIMENSION, "'b' origin 2 three", lambda: bs.Block.box("b", Q_([0, 0], "m"), Q_([1, 1, 1], "m"), STONE)),
        (DIMENSION, "BodyForce direction finite", lambda: bs.BodyForce((1, math.nan, 0))),
        # To pint an angle is a number: 35 degrees would pass for a friction coefficient of 0.61.
        (DIMENSION, "'j' friction_coefficient '35 deg'", lambda: bs.JointMaterial("j", "35 deg")),
        (DIMENSION, "'j' friction_angle", lambda: bs.JointMaterial("j", friction_angle=Q_(0.65, ""))),
        (DIMENSION, "'j' dilatancy_angle", lambda: bs.JointMaterial("j", 0.5, dilatancy_angle="0.1 dimensionless")),
        # The value has no mechanical meaning.
        (GEOMETRY, "'b' size 0.0", lambda: box("b", size=[1, 0, 1])),
        (GEOMETRY, "'b' vertex 3", lambda: polyhedron(np.where(np.arange(8) == 3, np.nan, CUBE.T).T, FACES, "b")),
        (MODEL, "'tuff' unit_weight density", lambda: bs.Material("tuff")),
        (MODEL, "'tuff' unit_weight -1", lambda: bs.Material("tuff", "-1 N/m^3")),
        (MODEL, "material '' name", lambda: bs.Material("", "1 N/m^3")),
        (MODEL, "'j' friction_coefficient friction_angle", lambda: bs.JointMaterial("j")),
        (MODEL, "'j' friction_coefficient 35 10 friction_angle", lambda: bs.JointMaterial("j", 35)),
        (MODEL, "'j' friction_angle 90°", lambda: bs.JointMaterial("j", friction_angle="90 deg")),
        (MODEL, "'j' dilatancy_angle 40° 26.5651°", lambda: bs.JointMaterial("j", 0.5, dilatancy_angle="40 deg")),
        (MODEL, "'j' tensile_strength cohesion", lambda: bs.JointMaterial("j", 0.5, tensile_strength="1 Pa")),
        (MODEL, "'j' compressive_strength 0", lambda: bs.JointMaterial("j", 0.5, compressive_strength="0 MPa")),
        (MODEL, "'j' torsion 'none' 'corners'", lambda: bs.JointMaterial("j", 0.5, torsion="none")),
        (MODEL, "'b' fixed 'no' True", lambda: bs.Block.box("b", ORIGIN, Q_([1, 1, 1], "m"), STONE, fixed="no")),
        (MODEL, "'b' material 'tuff' Material", lambda: bs.Block("b", box("x").shape, "tuff")),
        (MODEL, "BodyForce direction zero", lambda: bs.BodyForce((0, 0, 0))),
        (MODEL, "BodyForce direction length 2 share=2", lambda: bs.BodyForce((2, 0, 0))),
        (MODEL, "BodyForce direction 'y' +x, -x, +y", lambda: bs.BodyForce("y")),
        (MODEL, "BodyForce share 0", lambda: bs.BodyForce("+x", share=0)),
        (MODEL, "'p' loads SelfWeight() list", lambda: bs.LoadPattern("p", bs.SelfWeight())),
        (MODEL, "'p' loads 1 meter", lambda: bs.LoadPattern("p", Q_(1.0, "m"))),
        (MODEL, "'p' SelfWeight 3", lambda: bs.LoadPattern("p", [bs.SelfWeight()] * 3)),
        (MODEL, "'c' dead LoadPattern", lambda: bs.LimitCase("c", bs.SelfWeight(), push(1, 0, 0))),
        (MODEL, "'c' flow 'dilatant' 'associative'", lambda: bs.LimitCase("c", SELF_WEIGHT, SELF_WEIGHT, "dilatant")),
        (MODEL, "'m' interfaces 'found'", lambda: bs.Model("m", [box("a")], "found")),
        (MODEL, "'m' Model", lambda: bs.AnalysisManager("m")),
        (MODEL, "'m' blocks list", lambda: bs.Model("m", bs.detect_interfaces([], JOINT), [])),
        (MODEL, "tolerance 0 m", lambda: bs.detect_interfaces([], JOINT, tolerance="0 m")),
        (MODEL, "'lime' JointMaterial", lambda: bs.detect_interfaces([], "lime")),
        (MODEL, "relaxation 2.0", lambda: settings_of(relaxation=2.0)),
        (MODEL, "max_programs 3.5", lambda: settings_of(max_programs=3.5)),
        (MODEL, "relaxation_min 0.9 relaxation_max 0.8", lambda: settings_of(relaxation_min=0.9)),
        (MODEL, "yield_tolerance 0.1 0.01", lambda: settings_of(yield_tolerance=0.1)),
        (MODEL, "speed", lambda: bs.ProcedureSettings.of({"speed": 1})),
        (MODEL, "'uniaxial'", lambda: settings_of(crushing="linearised", crushing_interaction="biaxial")),
        # A load has no meaning, or two.
        (MODEL, "Weight 'b' weight -1 kN PointLoad", lambda: bs.Weight("b", A, "-1 kN")),
        (MODEL, "Weight block ''", lambda: bs.Weight("", A, "1 kN")),
        (MODEL, "LineLoad mass_share 1.001", lambda: bs.LineLoad("1 kN/m", A, B, mass_share=1.001)),
        (MODEL, "LineLoad weight_per_length 0 N/m", lambda: bs.LineLoad("0 kN/m", A, B)),
        (MODEL, "LineLoad start end (0.0, 0.0, 2.0) Weight", lambda: bs.LineLoad("1 kN/m", A, A)),
        (MODEL, "LineLoad z = 2 m 3 m block", lambda: bs.LineLoad("1 kN/m", A, ["1 m", "0 m", "3 m"])),
        (MODEL, "LineLoad spanning 1 True", lambda: bs.LineLoad("1 kN/m", A, B, spanning=1)),
        (MODEL, "AreaLoad start end block", lambda: bs.AreaLoad("1 kPa")),
        (MODEL, "AreaLoad (0, 0) (1, 0) area", lambda: bs.AreaLoad("1 kPa", A, ["1 m", "0 m", "2 m"])),
        (MODEL, "AreaLoad 'b' spanning rectangle", lambda: bs.AreaLoad("1 kPa", block="b", spanning=True)),
        (MODEL, "FillLoad z = 2 m box", lambda: bs.FillLoad(FILL, A, B)),
        (MODEL, "FillLoad lateral_coefficient -0.1", lambda: bs.FillLoad(FILL, LOW, B, lateral_coefficient=-0.1)),
        (MODEL, "FaceLoad 'b' traction pressure unit_weight level", lambda: bs.FaceLoad("b", 1)),
        (MODEL, "FaceLoad 'b' face -1", lambda: bs.FaceLoad("b", -1, pressure="1 kPa")),
        (MODEL, "FaceLoad 'b' unit_weight level", lambda: bs.FaceLoad("b", 1, unit_weight="9.81 kN/m^3")),
        (MODEL, "FaceLoad unit_weight -1 kN/m³", lambda: bs.FaceLoad("b", 1, unit_weight="-1 kN/m^3", level="1 m")),
        (UNIT, "LineLoad weight_per_length 5 kN/m", lambda: bs.LineLoad(5, A, B)),
        (DIMENSION, "AreaLoad weight_per_area", lambda: bs.AreaLoad("4 kN/m", A, B)),
    ],
)
def test_refused_values(error, words, make):
    assert issubclass(error, {UNIT: TypeError, DIMENSION: ValueError}.get(error, Exception))
    with refused(error, words):
        make()


@pytest.mark.parametrize(
    "call",
    [
        lambda long: bs.detect_interfaces([box("a")], {"*": long}),
        lambda long: bs.run(bs.Model("m", [box("a")], []), long),
        lambda long: settings_of(solver=long),
        lambda long: bs.AnalysisManager(bs.Model("m", [box("a")], []), long),
    ],
)
def test_messages_shorten_long_values(call):
    with pytest.raises(bs.errors.BlockstructError) as caught:
        call([push(1, 0, 0)] * 1000)
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize("weight", ["18 kN/mm^3", "18 N/m^3", "4.9 kN/m^3", "91 kN/m^3"])
def test_an_unusual_unit_weight_warns_at_the_line_of_the_user(weight):
    with pytest.warns(bs.errors.UnusualValueWarning, match="'tuff'") as caught:
        assert bs.Material("tuff", weight).unit_weight > 0
    assert caught[0].filename == __file__


def test_usual_and_zero_unit_weights_do_not_warn():
    assert JOINT.varied(friction_angle="45 deg").friction_coefficient == pytest.approx(1.0)
    assert [bs.Material("m", w).unit_weight for w in ("0 N/m^3", "5 kN/m^3", "90 kN/m^3")] == [0, 5e3, 9e4]
    for unit, weight in (("t", 9806.65), ("US_ton", 8896.443230521)):
        assert bs.Material("m", density=f"1 {unit}/m^3").unit_weight == pytest.approx(weight, rel=1e-12)


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (CUBE, FACES[:-1], "open edge"),
        (CUBE, [f[::-1] for f in FACES], "inside out"),
        (CUBE, [FACES[0][::-1], *FACES[1:]], "edge"),
        (CUBE * [1, 1, 0], FACES, "area"),
        (CUBE + np.eye(8, 3) * 0.01, FACES, "planar m"),
        (CUBE, [*FACES[:-1], [3, 0, 4, 9]], "(3, 0, 4, 9) 0..7"),
        (CUBE, [*FACES[:-1], [3, 0, 0, 7]], "(3, 0, 0, 7)"),
        (CUBE[:3], FACES[:1], "four points"),
        (np.vstack([CUBE, [9, 9, 9]]), FACES, "[8]"),
        (CUBE, [[0.4, 3, 2, 1], *FACES[1:]], "whole"),
        (CUBE, FACES[:3], "3 faces"),
    ],
)
def test_refused_shapes(vertices, faces, words):
    with refused(GEOMETRY, f"'b' {words}"):
        bs.Block.from_faces("b", Q_(vertices, "m"), faces, STONE)


def test_the_face_towards_a_direction():
    block = box("b")
    assert [block.face_towards(d) for d in ("-z", "+z", "-y", "+x", "+y", "-x")] == list(range(6))
    with refused(GEOMETRY, "'b' face 4 36.9 degrees"):
        block.face_towards((0.6, 0.8, 0))
    with refused(MODEL, "'b' direction length 2"):
        block.face_towards((2, 0, 0))


@pytest.mark.parametrize(
    ("blocks", "error", "words"),
    [
        ([box("a", fixed=True), box("a", z=1)], MODEL, "block names a"),
        ([box("a"), box("b", z=1)], MODEL, "fixed=True"),
        ([box("a", fixed=True)], MODEL, "every fixed"),
        ([box("a", fixed=True), box("b", z=1), box("c", x=9)], MODEL, "floating 1 c tolerance"),
        ([box("a", fixed=True), box("b", z=0.5)], GEOMETRY, "'a' 'b' 0.5 m"),
        ([box("a", fixed=True), bs.Block("b", box("b", z=1).shape, OTHER)], MODEL, "different materials stone"),
    ],
)
def test_refused_models(blocks, error, words):
    with refused(error, words):
        model_of(blocks, JOINT)


SQUARE = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)


def interface(polygon, plus="b", name="i", minus="a"):
    return bs.Interface(name, minus, plus, Q_(np.array(polygon, dtype=float), "m"), JOINT)


@pytest.mark.parametrize(
    ("polygon", "words"),
    [
        ([[0, 0, 0], [1, 0, 0]], "polygon (2, 3) three"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], "no area"),
        ([[0, 0, 0.3], [1, 0, -0.3], [1, 1, 0.3], [0, 1, -0.3]], "0.3 m 0.2 m plane"),
    ],
)
def test_interfaces_need_an_area_and_a_plane(polygon, words):
    with refused(GEOMETRY, f"'i' {words}"):
        interface(polygon)


@pytest.mark.parametrize(
    ("polygons", "words"),
    [
        ([SQUARE[::-1]], "'i0' counter-clockwise"),
        ([np.add(SQUARE, [5, 0, 3])], "'i0' face"),
        ([SQUARE[:, [2, 0, 1]]], "'i0' face"),
        ([SQUARE, SQUARE * [0.5, 1, 1]], "'i0' 'i1' area"),
        # A spike, with a small area or none, would move the lever to its tip.
        ([np.insert(SQUARE, 2, [[1, 0.499, 1], [3, 0.5, 1], [1, 0.501, 1]], axis=0)], "'i0' corner 2 m"),
        ([np.insert(SQUARE, 2, [[1, 0.5, 1], [3, 0.5, 1], [1, 0.5, 1]], axis=0)], "'i0' corner 2 m"),
    ],
)
def test_interfaces_must_fit_their_blocks(polygons, words):
    interfaces = [interface(p, name=f"i{k}") for k, p in enumerate(polygons)]
    with refused(GEOMETRY, words):
        bs.Model("m", [box("a", fixed=True), box("b", z=1)], interfaces)


@pytest.mark.parametrize(("tip", "fits"), [(0.01, False), (0.002, True)])
def test_the_limit_of_a_spike_is_relative_to_the_width_of_the_joint(tip, fits):
    """5 m × 0.3 m: with 60 mm more the lever across it would be 0.21 m and not 0.15 m."""
    blocks = [structures.box(name, [0, 0, z], [5, 0.3, 1], fixed=z == 0) for z, name in enumerate("ab")]
    spike = [[2.51, 0.3, 1], [2.5, 0.3 + tip, 1], [2.49, 0.3, 1]]
    joint = interface([[0, 0, 1], [5, 0, 1], [5, 0.3, 1], *spike, [0, 0.3, 1]])
    with nullcontext() if fits else refused(GEOMETRY, f"'i' corner {tip} m"):
        bs.Model("m", blocks, [joint])


def test_interfaces_join_known_blocks_that_are_not_both_supports():
    with refused(UNKNOWN, "'i' 'nobody'"):
        bs.Model("m", [box("a", fixed=True), box("b", z=1)], [interface(CUBE[:3], "nobody")])
    blocks = [box("a", fixed=True), box("b", z=1), box("c", x=1, fixed=True)]
    found = bs.detect_interfaces(blocks, JOINT)
    with refused(MODEL, "'i' 'a' 'c' supports"):
        bs.Model("m", blocks, [*found.interfaces, interface(SQUARE[:, [2, 0, 1]], "c")])


@pytest.mark.parametrize(
    ("loads", "error", "words"),
    [
        ([], MODEL, "'case' 'v' zero"),
        ([bs.PointLoad("ground", ORIGIN, Q_([1, 0, 0], "N"))], MODEL, "'case' 'v' zero"),
        ([bs.PointLoad("nobody", ORIGIN, Q_([1, 0, 0], "N"))], UNKNOWN, "'nobody' block"),
        ([bs.PointLoad("block", Q_([50, 50, 100], "m"), Q_([1, 0, 0], "N"))], MODEL, "'block' outside Moment"),
        ([bs.FaceLoad("block", 6, Q_([1, 0, 0], "Pa"))], MODEL, "'block' face 6 0..5"),
    ],
)
def test_loads_must_fit_the_model(loads, error, words):
    with refused(error, words):
        solve(model_of(*single_block(1.0, 1.0)), bs.LoadPattern("v", loads))


def test_cases_are_checked_before_the_run(small_model, small_cases, tmp_path):
    manager = bs.AnalysisManager(small_model, tmp_path / "x.h5")
    other = bs.LimitCase("other", bs.LoadPattern("dead", [bs.BodyForce("-z", share=2)]), push(1, 0, 0))
    for cases, words in [
        ([], "case"),
        ([small_cases[0], small_cases[0]], small_cases[0].name),
        ([small_cases[0], other], "'dead'"),
        (small_cases[0], "cases list LimitCase"),
    ]:
        with refused(MODEL, words):
            manager.run(cases)
    with refused(MODEL, "settings ProcedureSettings"):
        bs.AnalysisManager(small_model, settings={"patience": 3})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("solver", "words"),
    [("mosek", "'mosek' clarabel"), ("cvxpy:NOSUCH", "'NOSUCH'"), ("cvxpy:OSQP", "'OSQP' CLARABEL")],
)
def test_unknown_solvers(small_model, solver, words):
    with refused(bs.errors.SolverError, words):
        bs.AnalysisManager(small_model, settings=settings_of(solver=solver))


def test_a_model_is_read_only_and_names_its_cases(small_model, small_analysis):
    for array in (small_model.interfaces[0].polygon, small_model.blocks[0].shape.vertices):
        assert not array.flags.writeable
    assert issubclass(UNKNOWN, KeyError)
    with refused(UNKNOWN, "'nothing' push associative"):
        small_analysis["nothing"]
    assert small_analysis.get("nothing") is None


def test_paths_are_checked_before_the_run(small_model, tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "p.h5.partial").write_text("x")
    for path in (".", "file", "file/x.h5", "/proc/blockstruct/x.h5", "p.h5"):
        with refused(bs.errors.StorageError):
            bs.AnalysisManager(small_model, tmp_path / path)
    assert (tmp_path / "file").read_text() == "x"


def test_settings_take_numbers_of_numpy():
    chosen = settings_of(max_programs=np.int64(5), gap_tolerance=np.float64(1e-4))
    assert type(chosen.schedule.max_programs) is int
    assert type(chosen.numerics.gap_tolerance) is float
