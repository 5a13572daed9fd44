"""Detection of interfaces, its report, and joints corrected after the repairs of an import."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import blockstruct as bs
import meshes
from blockstruct import Q_
from blockstruct.contacts import corrected_joints
from blockstruct.structures.builder import prism
from meshes import objects_text, read
from properties import few
from refusals import refused
from structures import STONE, box, moved, push, rotation, solve

DRY, LIME = bs.JointMaterial("dry", 0.65), bs.JointMaterial("lime", 0.75)
CUBE, FACES = np.array(meshes.CUBE, dtype=float), meshes.QUADS


def hexahedron(name, vertices, *, fixed=False):
    return bs.Block.from_faces(name, Q_(vertices, "m"), FACES, STONE, fixed=fixed)


FLOOR = box("floor", [-1, -1, -1], [9, 3, 1], fixed=True)


def detect(*blocks, joint=DRY, **limits):
    return bs.detect_interfaces(blocks, joint, **limits)


def judged(report, minus, plus):
    (contact,) = (c for c in report.contacts if {c.minus, c.plus} == {minus, plus})
    return contact


@pytest.mark.parametrize(
    ("gap", "reason", "near_miss"),
    [(0.0005, "", False), (0.0015, "gap", True), (0.0025, "gap", False), (-0.0015, "penetration", True)],
)
def test_a_gap_is_accepted_a_near_miss_or_rejected(gap, reason, near_miss):
    report = detect(FLOOR, box("a", [0, 0, 0]), box("b", [1 + gap, 0, 0]), tolerance="1 mm").report
    contact = judged(report, "a", "b")
    assert (contact.reason, contact.near_miss) == (reason, near_miss)
    assert contact.gap == pytest.approx(gap)
    assert contact.area == pytest.approx(1.0)
    assert contact.orientation == bs.vocabulary.JointOrientation.HEAD
    assert report.overlaps == ((("a", "b", pytest.approx(-gap)),) if gap < -0.001 else ())


@pytest.mark.parametrize(
    ("degrees", "reason", "near_miss"), [(0.5, "", False), (1.5, "angle", True), (5, "angle", False)]
)
def test_an_angle_is_accepted_a_near_miss_or_rejected(degrees, reason, near_miss):
    # A wedge of air between two blocks that touch along an edge.
    leaning = CUBE + np.array([1, 0, 0])
    leaning[[4, 7], 0] += np.tan(np.radians(degrees))
    report = detect(FLOOR, box("a", [0, 0, 0]), hexahedron("b", leaning), tolerance="50 mm").report
    contact = judged(report, "a", "b")
    assert (contact.reason, contact.near_miss) == (reason, near_miss)
    assert np.degrees(contact.angle) == pytest.approx(degrees)


def test_the_area_tolerance():
    blocks = FLOOR, box("a", [0, 0, 0]), box("b", [0.99, 0, 1])
    assert judged(detect(*blocks).report, "a", "b").area == pytest.approx(0.01)
    report = detect(*blocks, area_tolerance="150 cm^2").report
    assert judged(report, "a", "b").reason == "area"
    assert [c.plus for c in report.near_misses] == ["b"]
    assert report.floating == report.untouched == ("b",)


def test_hints_name_a_sufficient_tolerance():
    # Three stones turned by 3 degrees so that they touch with an edge, and a level one 4 mm above the floor.
    turn = rotation((0, 1, 0), np.radians(3))
    stones = [moved([box(f"turned {k}", (0, 0, 0))], turn, (2 * k, 0, np.sin(np.radians(3))))[0] for k in range(3)]
    report = detect(FLOOR, *stones, box("high", (6, 0, 0.004)), tolerance="1 mm").report
    # Without limit their lower faces would be contact, open by 5 cm at the far side.
    assert report.hints == (
        "3 of 4 rejected by angle: an angle tolerance of 3.03 deg would take 0, with a gap tolerance of 0.0529 m 3",
        "1 of 4 rejected by gap or penetration: a gap tolerance of 0.00404 m would take half of them, 0.00404 m all",
    )
    assert all(hint in str(report) for hint in report.hints)
    # A wall with open joints.
    apart = detect(FLOOR, box("a", [0, 0, 0.025]), box("b", [1.03, 0, 0.025])).report
    close = {("floor", "a"): 0.025, ("floor", "b"): 0.025, ("a", "b"): 0.03}
    assert {c[:2]: round(c[2], 6) for c in apart.close} == close
    report = detect(FLOOR, box("a", [0, 0, 0.004]), box("b", [0, 0, 1.004])).report
    assert (report.accepted, report.floating, report.untouched) == (1, ("a", "b"), ("floor",))
    assert "1 of 1 rejected by gap or penetration: a gap tolerance of 0.00404 m would take" in str(report)


def test_the_report_lists_and_tabulates_its_findings():
    report = detect(
        FLOOR, box("a", [0, 0, 0]), box("b", [1.0003, 0, 0]), box("c", [4, 0, 3]), tolerance="0.2 mm"
    ).report
    text = str(report)
    assert text.startswith("2 interfaces, 2 m^2 (gap tolerance 0.0002 m, angle 1 deg)")
    assert "rejected: 1\n  a | b: gap, gap 0.3 mm, angle 0°, area 1 m² (near miss)" in text
    assert "joints: bed 2 m^2" in text
    table = report.table()
    assert table["finding"].tolist() == ["accepted", "accepted", "near miss", "floating"]
    assert table.loc[table["finding"] == "near miss", "gap"].item() == pytest.approx(0.0003)
    assert table.attrs["units"]["area"] == "meter ** 2"


WALL = [[1, 1, 1], [0.5, 1, 1, 0.5], [1, 1, 1]]


def wall(length="0.4 m", height="0.2 m", depth="0.1 m"):
    return bs.courses(WALL, unit_length=length, unit_height=height, thickness=depth, material=STONE)


def test_joint_materials_by_orientation_by_names_and_by_a_function():
    found = bs.detect_interfaces(wall(), {"base|*": LIME, "bed": DRY, "head": bs.JointMaterial("open", 0.0)})
    materials = {i.name: i.joint_material.name for i in found.interfaces}
    assert materials["base|1.1"] == "lime"
    assert materials["1.1|2.1"] == "dry"
    assert materials["1.1|1.2"] == "open"
    assert found.report.area_by_orientation == pytest.approx({"bed": 9 * 0.04, "head": 7 * 0.02})
    found = bs.detect_interfaces(wall(), lambda joint: LIME if joint.centroid[2] > 0.3 else DRY)
    assert all(i.joint_material is (LIME if i.centroid[2] > 0.3 else DRY) for i in found.interfaces)


@pytest.mark.parametrize(
    ("rules", "words"),
    [
        ({}, "JointMaterial mapping"),
        ({"beds": DRY}, "'beds' 'bed' 'base|*'"),
        ({"head": DRY}, "'base|1.1' bed add '*'"),
        ({"bsae|*": LIME, "*": DRY}, "'bsae|*' 'base|1.1'"),
        (lambda joint: None, "function None"),
    ],
)
def test_refused_rules(rules, words):
    with refused(bs.errors.ModelError, words):
        bs.detect_interfaces(wall(), rules)


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ({"angle_tolerance": "60 deg"}, "60 deg 45 deg"),
        ({"area_tolerance": "1 mm"}, "area_tolerance area"),
        ({"area_tolerance": 1e-6}, "area_tolerance no unit"),
    ],
)
def test_refused_tolerances(limits, words):
    with refused(bs.errors.BlockstructError, words):
        detect(FLOOR, **limits)


def test_a_face_that_crosses_itself_is_refused():
    # Ten corners of a pentagram, so that the area is not zero; a prism over it is closed but no body.
    star = [(np.cos(a), np.sin(a)) for a in np.arange(5) * 0.8 * np.pi]
    vertices = [(x, y, z) for z in (0, 1) for x, y in star]
    sides = [[k, (k + 1) % 5, 5 + (k + 1) % 5, 5 + k] for k in range(5)]
    block = bs.Block.from_faces("star", Q_(vertices, "m"), [[4, 3, 2, 1, 0], [5, 6, 7, 8, 9], *sides], STONE)
    with pytest.raises(bs.errors.GeometryError, match=r"'star'.* face 0"):
        detect(FLOOR, block)


def summary(report):
    """What a report says but for the order and the direction of the normals, lengths in block sizes."""
    size = report.tolerances.gap / 1e-5
    return sorted((*sorted((c.minus, c.plus)), c.reason, round(c.area / size**2, 6)) for c in report.contacts)


PUZZLE = [*wall(), box("lintel", [0, 0, 0.6], [1.2, 0.1, 0.1]), box("near", [0, 0.1002, 0], [1.2, 0.3, 0.2])]


@few(15)
@given(
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle=st.floats(-3, 3),
    shift=st.tuples(*[st.floats(-50, 50)] * 3),
    seed=st.integers(0, 1000),
)
def test_detection_is_invariant_to_rigid_motion_and_block_order(axis, angle, shift, seed):
    turned = moved(PUZZLE, rotation(axis, angle), shift)
    shuffled = [turned[k] for k in np.random.default_rng(seed).permutation(len(turned))]
    here, there = (bs.detect_interfaces(b, DRY).report for b in (PUZZLE, shuffled))
    assert summary(there) == summary(here)
    assert sorted(map(sorted, (c[:2] for c in there.close))) == sorted(map(sorted, (c[:2] for c in here.close)))
    assert len(here.close) > 0
    assert {c.reason for c in here.contacts} == {"", "gap"}


@few(15)
@given(scale=st.floats(1e-3, 1e3), unit=st.sampled_from(["m", "mm", "ft", "in"]))
def test_detection_is_invariant_to_scale_and_units(scale, unit):
    def scaled(unit_length):
        shapes = [(Q_(b.shape.vertices * scale, "m").to(unit_length), b.shape.faces) for b in PUZZLE]
        return [bs.Block.from_faces(b.name, *s, STONE, fixed=b.fixed) for b, s in zip(PUZZLE, shapes, strict=True)]

    assert summary(bs.detect_interfaces(scaled(unit), DRY).report) == summary(bs.detect_interfaces(PUZZLE, DRY).report)


def test_a_solid_of_cubes_has_the_contacts_of_its_closed_form():
    n = 6
    cubes = [box(f"{x}.{y}.{z}", [x, y, z], fixed=z == 0) for x in range(n) for y in range(n) for z in range(n)]
    report = bs.detect_interfaces(cubes, DRY).report
    assert report.accepted == 3 * n * n * (n - 1) - 2 * n * (n - 1)
    assert len(report.between_supports) == 2 * n * (n - 1)
    # Each inner edge of the lattice is shared by four cubes, two pairs of them touch along it only.
    lines = 3 * n * (n - 1) ** 2 * 2 - 2 * (n - 1) ** 2
    assert len(report.close) == lines + 4 * (n - 1) ** 3


def faceted(name, origin, n, *, rough=0.0, flip=False, fixed=False):
    """Unit cube whose faces are n × n squares of two triangles each, with displaced corners."""
    corners, triangles = {}, []
    for axis in range(3):
        for side in (0, n):
            for a in range(n):
                for b in range(n):
                    square = []
                    for da, db in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        point = [side] * 3
                        point[(axis + 1) % 3], point[(axis + 2) % 3] = a + da, b + db
                        square.append(corners.setdefault(tuple(point), len(corners)))
                    square = square[flip:] + square[:flip]
                    square = square if side else square[::-1]
                    triangles += [square[:3], [square[0], *square[2:]]]
    noise = np.random.default_rng(len(name)).uniform(-rough, rough, (len(corners), 3))
    points = np.array(list(corners)) / n + noise + np.asarray(origin)
    return bs.Block.from_faces(name, Q_(points, "m"), triangles, STONE, fixed=fixed)


@pytest.mark.parametrize("R", [np.eye(3), rotation((1, 2, 3), 0.7)], ids=["straight", "turned"])
def test_a_contact_of_triangulated_faces_is_one_interface(R):
    # The diagonals of the faces cross: they share quarters of their squares.
    blocks = [FLOOR, faceted("a", [0, 0, 0], 3), faceted("b", [0, 0, 1], 3, flip=True), faceted("c", [1, 0, 0.5], 2)]
    report = bs.detect_interfaces(moved(blocks, R), DRY).report
    areas = {tuple(sorted((c.minus, c.plus))): c.area for c in report.contacts}
    assert areas == pytest.approx({("a", "floor"): 1, ("a", "b"): 1, ("a", "c"): 0.5, ("b", "c"): 0.5})
    assert report.accepted == 4


def test_a_rough_joint_of_scanned_stones_is_one_interface():
    stones = faceted("a", [0, 0, 0], 4, rough=5e-4, fixed=True), faceted("bb", [1, 0, 0], 4, rough=5e-4)
    found = detect(*stones, tolerance="3 mm", angle_tolerance="5 deg")
    (joint,) = found.interfaces
    assert joint.area == pytest.approx(1.0, abs=5e-3)
    assert abs(joint.normal[0]) == pytest.approx(1.0, abs=1e-4)
    bs.Model("stones", stones, found.interfaces)


LEAD = {"p|*": bs.JointMaterial("lead", 0.1), "*": DRY}


@pytest.mark.parametrize("R", [np.eye(3), rotation((1, 2, 3), 0.7)], ids=["straight", "turned"])
@pytest.mark.parametrize("tolerance", ["4 mm", "6 mm", "2 cm"])
def test_no_contact_goes_through_a_sheet_thinner_than_the_tolerance(tolerance, R):
    sheet, above = box("p", [0, 0, 1], [1, 1, 0.005]), box("b", [0, 0, 1.005])
    found = detect(*moved([FLOOR, box("a", [0, 0, 0]), sheet, above], R), joint=LEAD, tolerance=tolerance)
    assert {frozenset((i.minus, i.plus)): i.joint_material.name for i in found.interfaces} == {
        frozenset(("floor", "a")): "dry",
        frozenset(("a", "p")): "lead",
        frozenset(("p", "b")): "lead",
    }
    through = judged(found.report, "a", "b")
    assert through.reason == ("gap" if tolerance == "4 mm" else "block p between")
    assert through.near_miss == (tolerance == "4 mm")
    if tolerance != "4 mm":
        assert through.area == pytest.approx(1.0)
        assert "rejected: 1\n  a | b: block p between, gap 5 mm" in str(found.report)
        assert found.report.hints == ()


@pytest.mark.parametrize(
    ("origin", "size", "parts", "left"),
    [([0, 0], [0.5, 1], 1, 0.5), ([0.25, 0.25], [0.5, 0.5], 2, 0.75), ([0.001, 0.001], [0.998, 0.998], 0, 0.0)],
    ids=["half", "a pad in the middle", "a rim narrower than the gap"],
)
def test_the_contact_next_to_a_sheet_is_kept(origin, size, parts, left):
    """Half of it, what is around a pad in the middle, cut in two for want of a hole, but no rim like a line."""
    sheet = box("p", [*origin, 1], [*size, 0.005])
    blocks = FLOOR, box("a", [0, 0, 0]), sheet, box("b", [0, 0, 1.005])
    found = detect(*blocks, joint=LEAD, tolerance="6 mm")
    beside = [i for i in found.interfaces if {i.minus, i.plus} == {"a", "b"}]
    assert len(beside) == parts
    assert sum(i.area for i in beside) == pytest.approx(left)
    assert all(i.centroid[2] == pytest.approx(1.0025) for i in beside)
    (hidden,) = (c for c in found.report.contacts if c.is_hidden)
    assert hidden.area == pytest.approx(1 - left)
    assert len(bs.Model("pad", blocks, found.interfaces, detection=found.report).interfaces) == 3 + parts


def test_an_explicit_interface_is_kept_once():
    square = Q_([[0, 0, 0], [0.5, 0, 0], [0.5, 1, 0], [0, 1, 0]], "m")
    given = bs.Interface("half a bed", "floor", "a", square, LIME)
    found = bs.detect_interfaces([FLOOR, box("a", [0, 0, 0]), box("b", [1, 0, 0])], DRY, explicit=[given])
    assert [i.name for i in found.interfaces] == ["half a bed", "floor|b", "a|b"]
    # Nobody measured it.
    assert np.isnan(found.report.contacts[0].gap)
    with pytest.raises(bs.errors.UnknownNameError, match="'floor'"):
        bs.detect_interfaces([box("a", [0, 0, 0])], DRY, explicit=[given])


@pytest.mark.parametrize("names", [("a", "b", "b#2", "c"), ("a", "b|c", "a|b", "c")])
def test_interfaces_have_unique_names_for_any_names_of_blocks(names):
    outline = [(0, 0), (1, 0), (1, 1), (2, 1), (2, 0), (3, 0), (3, 2), (0, 2)]
    floor, two, one, upper = names
    blocks = [box(floor, [-1, -1, -1], [9, 3, 1], fixed=True), prism(two, outline, (0.0, 1.0), STONE)]
    blocks += [box(one, [4, 0, 0]), box(upper, [4, 0, 1])]
    found = detect(*blocks)
    model = bs.Model("of odd names", blocks, found)
    assert len({i.name for i in model.interfaces}) == 4
    assert found.interfaces[0].name == f"{floor}|{two}"


def test_a_contact_that_is_not_plane_is_fitted_by_a_plane():
    # Two blocks that meet in a saddle of four corners: the fitted plane is level, the forces stay at the corners.
    saddle = np.array([[0, 0, 0.05], [1, 0, -0.05], [1, 1, 0.05], [0, 1, -0.05]])
    contact = bs.Interface("saddle", "a", "b", Q_(saddle, "m"), DRY)
    assert contact.normal == pytest.approx([0, 0, 1])
    assert contact.deviation == pytest.approx(0.05)
    assert contact.area == pytest.approx(1.0)
    assert contact.polygon == pytest.approx(saddle)


@pytest.mark.parametrize("rough", [0.0, 0.05])
def test_a_block_on_a_contact_that_is_not_plane_rocks_about_its_own_corners(rough):
    tops = np.array([rough, -rough, rough, -rough])
    triangles = [[4, 5, 6], [4, 6, 7], *FACES[2:], FACES[0]]
    lower = CUBE - [0, 0, 1.0]
    lower[4:, 2] += tops
    upper = CUBE * [1, 1, 2]
    upper[:4, 2] += tops
    below = bs.Block.from_faces("a", Q_(lower, "m"), triangles, STONE, fixed=True)
    above = bs.Block.from_faces("b", Q_(upper, "m"), [[0, 2, 1], [0, 3, 2], *FACES[1:]], STONE)
    corners = lower[4:]
    contact = bs.Interface("rough", "a", "b", Q_(corners, "m"), bs.JointMaterial("rough", 2.0))
    found = bs.detect_interfaces([below, above], DRY, explicit=[contact])
    result = solve(bs.Model("rough", [below, above], found.interfaces), push(1, 0, 0))
    assert result.status == "converged"
    # It turns about the line through the corners at x = 1, whose heights are −rough and +rough.
    axis, arm = corners[2] - corners[1], above.centroid - corners[1]
    assert result.load_factor == pytest.approx(
        (np.cross(arm, [0, 0, 1]) @ axis) / (np.cross(arm, [1, 0, 0]) @ axis), rel=1e-6
    )


JOINT = bs.JointMaterial("joint", 0.6)


def bent_wall(head, bed, *, off=0.0):
    """Two courses of four stones on a slab, in mm. One bed joint is closed; there a corner of a stone is off."""
    boxes = [("slab", (-100, 0, -300), (4200, 500, 300))]
    for course in range(2):
        for k in range(4):
            origin = (1000 * k, 0, course * 400 + bed * (course == 1 and k != 1))
            boxes.append((f"{course}.{k}", origin, (1000 - head, 500, 400)))
    bodies = {name: CUBE * size + origin for name, origin, size in boxes}
    bodies["0.1"][6, 2] += off
    return objects_text(bodies)


def imported(tmp_path, text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bs.errors.GeometryWarning)
        return read(tmp_path, "wall.obj", text, unit="mm", fixed=["slab"])


def pairs(contacts):
    return {(c.minus, c.plus) for c in contacts if not c.reason}


def test_one_moved_vertex_closes_only_its_joint(tmp_path):
    found = imported(tmp_path, bent_wall(head=8, bed=0, off=3.5))
    assert 0.7e-3 < max(r.amount for r in found.report.repairs if r.kind == "flattened") < 0.9e-3
    assert set(found.moves) == {"0.1"}
    joints = corrected_joints(found.blocks, JOINT, found.moves)
    # The tilted bed joint at the corner is closed, the head joints of 8 mm are not.
    assert pairs(joints.closed) == {("0.1", "1.1")}
    assert "0.1 | 1.1" in str(joints)
    report = bs.detect_interfaces(found.blocks, JOINT, joints.tolerance, explicit=joints.explicit).report
    beds = {("slab", f"0.{k}") for k in range(4)} | {(f"0.{k}", f"1.{k}") for k in range(4)}
    assert pairs(report.contacts) == beds
    assert bs.detect_interfaces(found.blocks, JOINT).report.accepted == 7


def test_joints_are_explicit_if_no_tolerance_separates_them(tmp_path):
    # Other bed joints have a smaller gap than the move of the corner.
    found = imported(tmp_path, bent_wall(head=8, bed=1, off=3.5))
    joints = corrected_joints(found.blocks, JOINT, found.moves)
    assert joints.tolerance is None
    assert [i.name for i in joints.explicit] == ["0.1|1.1"]
    report = bs.detect_interfaces(found.blocks, JOINT, joints.tolerance, explicit=joints.explicit).report
    assert pairs(report.contacts) == {("slab", f"0.{k}") for k in range(4)} | {("0.1", "1.1")}
    # No moves close no joint.
    still = imported(tmp_path, bent_wall(head=8, bed=1))
    joints = corrected_joints(still.blocks, JOINT, still.moves)
    assert (still.moves, joints.closed, joints.tolerance, joints.explicit) == ({}, (), None, ())


@pytest.mark.parametrize("seed", range(5))
def test_closed_joints_are_within_the_moves_of_their_blocks(tmp_path, seed):
    rng = np.random.default_rng(seed)
    text = bent_wall(head=rng.uniform(0.1, 4), bed=rng.uniform(0.05, 1), off=rng.uniform(1, 4.5))
    found = imported(tmp_path, text)
    joints = corrected_joints(found.blocks, JOINT, found.moves)
    rounding = bs.detect_interfaces(found.blocks, JOINT).report.tolerances.gap
    report = bs.detect_interfaces(found.blocks, JOINT, joints.tolerance, explicit=joints.explicit).report
    for c in [*joints.closed, *(c for c in report.contacts if c.interface and not np.isnan(c.gap))]:
        moved = sum(float(np.abs(found.moves.get(name, 0.0)).max()) for name in (c.minus, c.plus))
        assert abs(c.gap) <= rounding + 4 * np.sqrt(3) * moved


def test_moves_that_open_no_joint_close_none(tmp_path):
    """Two blocks of general shape with one face in common, written to three decimals: it is moved alike."""
    lower = np.round(CUBE @ rotation((1, 2, 0.5), 0.4).T * [1, 1.2, 0.9], 3)
    upper = np.concatenate([lower[4:], np.round(lower[4:] + 0.8 * (lower[4:] - lower[:4]), 3)])
    with pytest.warns(bs.errors.GeometryWarning, match="moved into the planes"):
        found = read(tmp_path, "two.obj", objects_text({"a": lower, "b": upper}))
    assert set(found.moves) == {"a", "b"}
    assert corrected_joints(found.blocks, JOINT, found.moves).closed == ()
