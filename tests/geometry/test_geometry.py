"""Volumes, centroids, contacts and overlaps of polyhedra."""

import numpy as np
import pytest

import blockstruct as bs
import structures
from blockstruct import Q_
from blockstruct.geometry import overlap
from blockstruct.geometry.cells import polygon_cells
from blockstruct.geometry.coplanar import coplanar_face_pairs
from blockstruct.geometry.faces import common_areas
from blockstruct.geometry.neighbours import box_pairs
from blockstruct.geometry.overlap import overlapping_pairs
from blockstruct.geometry.polygon import polygon_area, tributary_areas
from blockstruct.geometry.polyhedron import box, polyhedron
from blockstruct.geometry.screws import rotation_matrices, rotation_vectors
from blockstruct.geometry.touching import inset, largest_radius
from structures import STONE, bonded, extruded, moved, rotation

DOME = {"span": "4 m", "thickness": "60 cm", "courses": 4, "units": 8, "oculus": "1.2 m"}


def prism(outline, height, name="prism", z=0.0):
    """Vertical prism over a counter-clockwise outline in the x–y plane."""
    return extruded(name, outline, z, z + height).shape


L_SHAPE = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]


def test_tetrahedron():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    shape = polyhedron(vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], "t")
    assert shape.volume == pytest.approx(1 / 6)
    assert shape.centroid == pytest.approx([0.25, 0.25, 0.25])


def test_non_convex_prism_is_exact():
    shape = prism(L_SHAPE, 2.0)
    assert shape.volume == pytest.approx(10.0)
    # Two rectangles 3 × 1 and 1 × 2: x = (3 · 1.5 + 2 · 0.5) / 5.
    assert shape.centroid == pytest.approx([1.1, 1.1, 1.0])
    assert shape.face_centroid(1) == pytest.approx([1.1, 1.1, 2.0])


def test_l_shaped_contact_and_its_area():
    lower, upper = prism(L_SHAPE, 1.0), prism(L_SHAPE, 1.0, z=1.0)
    (pair,) = coplanar_face_pairs([lower, upper], 1e-6, 0.02)
    assert pair.area == pytest.approx(5.0)
    assert (pair.minus, pair.plus) == (0, 1)
    assert len(pair.polygon) == 6


@pytest.mark.parametrize(("columns", "rows"), [(3, 4), (5, 2)])
def test_running_bond_has_the_contacts_of_its_closed_form(tuff, dry, columns, rows):
    found = bs.detect_interfaces(bonded(columns, rows, "0.1 m", tuff), joint_material=dry)
    heads = sum(columns - 1 + j % 2 for j in range(rows))
    beds = columns + 2 * columns * (rows - 1)
    assert found.report.accepted == heads + beds
    assert found.report.total_area == pytest.approx(heads * 0.02 + rows * columns * 0.04)


def test_normal_points_from_minus_to_plus(small_model):
    for interface in small_model.interfaces:
        minus, plus = small_model.block(interface.minus), small_model.block(interface.plus)
        assert (plus.centroid - minus.centroid) @ interface.normal > 0


def test_slivers_and_contacts_of_supports_are_reported(dry):
    blocks = [structures.box("a", [0, 0, 0]), structures.box("b", [0.9999999, 0, 1])]
    blocks += [structures.box(f"g{x}", [x, 0, -1], fixed=True) for x in (0, 1)]
    report = bs.detect_interfaces(blocks, joint_material=dry).report
    assert [s[:2] for s in report.slivers] == [("a", "b")]
    assert report.between_supports == (("g0", "g1"),)
    assert report.untouched == ("b", "g1")
    assert "sliver left out: a | b" in str(report)


def test_overlap_depth_of_convex_blocks():
    first = polyhedron(*box((0, 0, 0), (1, 1, 1)), "a")
    # The same cross-section, shifted along it: no corner lies inside the other block.
    second = polyhedron(*box((0.5, 0, 0), (1, 1, 1)), "b")
    ((i, j, depth),) = overlapping_pairs([first, second], 1e-6)
    assert (i, j) == (0, 1)
    assert depth == pytest.approx(0.5)
    assert overlapping_pairs([first, polyhedron(*box((1, 0, 0), (1, 1, 1)), "c")], 1e-6) == []


@pytest.mark.parametrize("angle", [0, 0.7])
@pytest.mark.parametrize("depth", [0.3, 0.03, 0.001])
@pytest.mark.parametrize(
    ("origin", "size"),
    [
        # Into a leg of the L with a whole side; with an edge only; below its upper side, across it.
        ((1, 1, 0), (2, 2, 1)),
        ((1, 1, 0), (1, 1, 1)),
        ((1.5, -1, 1), (0.4, 3, 1)),
    ],
)
def test_a_shallow_overlap_of_non_convex_blocks_has_its_depth(origin, size, depth, angle):
    shift = np.array([depth if x == 1 else 0 for x in origin]) * ((1, 1, 0) if size == (1, 1, 1) else (1, 0, 1))
    R = rotation((0.3, 0.2, 1), angle)
    vertices, faces = box(np.array(origin) - shift, size)
    corner = prism(L_SHAPE, 1.0)
    shapes = [polyhedron(v @ R.T, f, "turned") for v, f in ((corner.vertices, corner.faces), (vertices, faces))]
    ((*pair, found),) = overlapping_pairs(shapes, 1e-6)
    assert pair == [0, 1]
    assert depth * 0.95 <= found <= depth * 1.5


def test_tributary_areas_sum_up():
    square = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], dtype=float)
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    outline = np.array([(*p, 0.0) for p in L_SHAPE])
    points = np.concatenate([square, triangle, outline])
    centroids = np.array([[1, 0.5, 0], [1 / 3, 1 / 3, 0], [1.1, 1.1, 0]])
    shares = tributary_areas(points, np.array([0, 4, 7]), centroids, np.array([[0, 0, 1.0]] * 3))
    assert shares[:4] == pytest.approx([0.5] * 4)
    assert shares[4:7] == pytest.approx([1 / 6] * 3)
    assert shares[7:].sum() == pytest.approx(5.0)
    assert (shares > 0).all()


#: Outlines whose centroid does not see all of them: L, T, and U with legs of two lengths.
THIN_L = [(0, 0), (1, 0), (1, 0.1), (0.1, 0.1), (0.1, 1), (0, 1)]
THIN_T = [(0, 0), (1, 0), (1, 0.2), (0.6, 0.2), (0.6, 1), (0.4, 1), (0.4, 0.2), (0, 0.2)]
THIN_U = [(0, 0), (2, 0), (2, 1), (1.9, 1), (1.9, 0.1), (0.1, 0.1), (0.1, 0.5), (0, 0.5)]


@pytest.mark.parametrize("outline", [L_SHAPE, THIN_L, THIN_T, THIN_U])
@pytest.mark.parametrize("angle", [0.0, 2.0])
def test_tributary_areas_have_the_centroid_of_the_area(outline, angle):
    points = np.array([(*p, 0.0) for p in outline])
    area, centroid, normal = polygon_area(points)
    R = rotation((1, 2, 3), angle)
    turned = points @ R.T
    shares = tributary_areas(turned, np.array([0]), (R @ centroid)[None], (R @ normal)[None])
    assert shares.sum() == pytest.approx(area)
    assert (shares > 0).all()
    np.testing.assert_allclose(shares @ turned / area, R @ centroid, atol=1e-9)
    np.testing.assert_allclose(shares, tributary_areas(points, np.array([0]), centroid[None], normal[None]), rtol=1e-9)


def test_rounded_coordinates_of_a_long_tilted_wall_keep_all_contacts(tuff, dry):
    # Normals of small faces are off by rounding; over the length of the wall that is more than any tolerance.
    blocks = bonded(60, 3, "0.1 m", tuff)
    R = rotation((1, 0.3, 0.2), 0.3)
    exact = bs.detect_interfaces(moved(blocks, R), joint_material=dry).report.accepted
    rounded = [
        bs.Block.from_faces(b.name, Q_(np.round(b.shape.vertices @ R.T, 7), "m"), b.shape.faces, tuff, fixed=b.fixed)
        for b in blocks
    ]
    assert bs.detect_interfaces(rounded, joint_material=dry).report.accepted == exact == 60 + 2 * 120 + 59 + 60 + 59


@pytest.mark.parametrize("stretch", [(1, 1, 1), (30, 1, 0.1), (1, 30, 30), (0, 5, 5)])
def test_pairs_of_boxes_equal_all_comparisons(stretch):
    rng = np.random.default_rng(3)
    low = rng.uniform(0, 10, (200, 3)) * stretch
    high = low + rng.uniform(0, 1, (200, 3))
    # One box through all the others, and one that is none.
    low[7], high[7] = low.min(axis=0), high.max(axis=0)
    low[9], high[9] = 1.0, 0.0
    meet = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=2)
    meet[9] = meet[:, 9] = False
    i, j = box_pairs(low, high)
    assert list(zip(i.tolist(), j.tolist(), strict=True)) == [tuple(p) for p in np.argwhere(np.triu(meet, 1))]


def test_common_areas_of_polygons():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    polygons = [square, square + np.array([0.25, 0.5, 0.001]), square + np.array([0, 0, 0.5]), square[[0, 2, 1, 3]]]
    up = np.array([[0, 0, 1.0]] * 4)
    # Half covered a little above, too far above, and an outline that crosses itself.
    shared = common_areas(polygons, up, np.array([0, 0, 0]), np.array([1, 2, 3]), 0.01)
    assert shared == pytest.approx([0.375, 0, 0])


def test_cells_of_a_polygon_that_is_not_plane_lie_in_its_plane():
    corners = np.array([[0, 0, 0.05], [1, 0, -0.05], [1, 1, 0.05], [0, 1, -0.05]])
    area, centroid, normal = polygon_area(corners)
    centres, areas = polygon_cells(corners, centroid, normal, 64, "i")
    assert areas.sum() == pytest.approx(area, rel=1e-12)
    np.testing.assert_allclose((centres - centroid) @ normal, 0, atol=1e-15)
    np.testing.assert_allclose(areas @ centres / area, centroid, atol=1e-15)


def test_rotation_vectors():
    """Back and forth, of no angle, tiny ones, and those up to half a turn."""
    axis = np.array([2.0, -1.0, 2.0]) / 3
    angles = np.array([0.0, 1e-12, 1e-6, 1e-3, 0.5, 2.0, 3.0, np.pi - 1e-4, np.pi - 1e-7])
    vectors = angles[:, None] * axis
    assert rotation_vectors(rotation_matrices(vectors)) == pytest.approx(vectors, rel=1e-9, abs=1e-12)


def test_faces_of_rounded_bodies():
    """Of a box: each side shorter by r at either end. Across an edge of angle ε, by ``r tan(ε / 2)``."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    up = np.array([0.0, 0, 1])
    sides = np.array([[0.0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    expected = np.array([[0.1, 0.1, -0.1], [0.9, 0.1, -0.1], [0.9, 0.9, -0.1], [0.1, 0.9, -0.1]])
    assert inset(square, up, sides, 0.1) == pytest.approx(expected, abs=1e-12)
    # The first side goes on flat, the second bends by 45 degrees, the third turns inwards.
    others = np.array([[0.0, 0, 1], [np.sqrt(0.5), 0, np.sqrt(0.5)], [0, -1, 0], [-1, 0, 0]])
    right = 1 - 0.1 * np.tan(np.pi / 8)
    expected = np.array([[0.1, 0, -0.1], [right, 0, -0.1], [right, 1, -0.1], [0.1, 1, -0.1]])
    assert inset(square, up, others, 0.1) == pytest.approx(expected, abs=1e-12)
    assert inset(square, up, sides, 0.5) is None
    assert largest_radius(square, up, sides) == pytest.approx(0.5, rel=1e-12)
    assert largest_radius(square, up, np.tile(up, (4, 1))) == np.inf


@pytest.mark.parametrize("seed", range(4))
def test_parts_reject_no_pair_in_which_samples_find_an_overlap(monkeypatch, seed):
    # Corners on a grid, so that many pairs touch along faces, edges and corners, and turned bodies among them.
    r = np.random.default_rng(seed)
    u_shape = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    (unit,) = [b for b in bs.structures.dome(**DOME, material=STONE) if b.name == "2.1"]
    shapes = [prism(L_SHAPE, 1.0), prism(u_shape, 1.0), polyhedron(*box((0, 0, 0), (1, 2, 1)), "box"), unit.shape]
    bodies = []
    for k in range(14):
        shape = shapes[k % len(shapes)]
        R = rotation(r.normal(size=3), r.uniform(0, 3)) if r.random() < 0.4 else np.eye(3)
        at = r.integers(0, 4, size=3) - shape.vertices.min(axis=0).round()
        bodies.append(polyhedron((shape.vertices + at) @ R.T, shape.faces, "body"))
    found = overlapping_pairs(bodies, 1e-6)
    monkeypatch.setattr(overlap, "may_overlap", lambda _, i, *__: np.ones(len(i), dtype=bool))
    assert found == overlapping_pairs(bodies, 1e-6)
    assert 0 < len(found) < 91
