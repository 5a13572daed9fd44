"""Polyhedra, polygons, overlap, bodies that touch, and cells of a polygon."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

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
from blockstruct.geometry.touching import MovingBodies, inset, largest_radius
from properties import few
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
    assert "sliver left out: 1\n  a | b" in str(report)


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


#: Outlines whose centroid does not see all of them: L, T, and U with legs of two lengths.
THIN_L = [(0, 0), (1, 0), (1, 0.1), (0.1, 0.1), (0.1, 1), (0, 1)]
THIN_T = [(0, 0), (1, 0), (1, 0.2), (0.6, 0.2), (0.6, 1), (0.4, 1), (0.4, 0.2), (0, 0.2)]
THIN_U = [(0, 0), (2, 0), (2, 1), (1.9, 1), (1.9, 0.1), (0.1, 0.1), (0.1, 0.5), (0, 0.5)]


@pytest.mark.parametrize("angle", [0.0, 2.0])
def test_tributary_areas_have_the_centroid_of_the_area(angle):
    square, triangle = [(0, 0), (2, 0), (2, 1), (0, 1)], [(0, 0), (1, 0), (0, 1)]
    outlines = [np.array([(*p, 0.0) for p in of]) for of in (square, triangle, L_SHAPE, THIN_L, THIN_T, THIN_U)]
    R, starts = rotation((1, 2, 3), angle), np.cumsum([0, *map(len, outlines[:-1])])
    areas, centroids, normals = zip(*map(polygon_area, outlines), strict=True)
    shares = tributary_areas(np.concatenate(outlines) @ R.T, starts, centroids @ R.T, normals @ R.T)
    assert (shares > 0).all()
    of_outlines = np.split(shares, starts[1:])
    for own, outline, area, centroid in zip(of_outlines, outlines, areas, centroids, strict=True):
        assert own.sum() == pytest.approx(area)
        np.testing.assert_allclose(own @ outline / area, centroid, atol=1e-9)
    assert of_outlines[0] == pytest.approx([0.5] * 4)
    assert of_outlines[1] == pytest.approx([1 / 6] * 3)


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


ANGLES = st.floats(-0.05, 0.05)


@given(ANGLES, ANGLES, st.floats(-0.15, 0.15), st.floats(-np.pi, np.pi))
def test_flush_faces(first, second, aside, turned):
    """Two units of a wall that turn in its plane touch in front as behind, at any azimuth, whatever rounding does."""
    units = [structures.box(name, [0, 0, 0], [0.4, 0.3, 0.2]) for name in ("lower", "upper")]
    bodies = MovingBodies.of({b.name: b.shape for b in units}, np.array([True, False]), radius=0.0)
    azimuth = rotation((0, 0, 1), turned)
    tilts = [azimuth @ rotation((0, 1, 0), angle) for angle in (first, second)]
    above = tilts[0] @ [aside, 0, 0.2]
    places = np.array([azimuth @ [7.1, -3.3, 0.5], azimuth @ [7.1, -3.3, 0.5] + above])
    found = bodies.touching(places, np.array(tilts), 0.2, 0.3)
    own = (found.position - places[0]) @ azimuth
    normal = found.normal @ azimuth
    front = own[:, 1] < 0
    assert front.any()
    sides = []
    for side in (front, ~front):
        rows = np.column_stack([own[side][:, [0, 2]], normal[side], found.gap[side]])
        sides.append(rows[np.lexsort(np.round(rows, 6).T)])
    assert sides[0].shape == sides[1].shape
    np.testing.assert_allclose(sides[0], sides[1], rtol=0, atol=1e-9)


@given(st.floats(0, 0.1), st.floats(-np.pi, np.pi))
def test_far_sides_of_thin_bodies_do_not_touch(gap, turned):
    """Two plates face to face touch there alone, however far contacts are searched."""
    plates = [structures.box(name, [0, 0, 0], [3, 3, 0.05]) for name in ("lower", "upper")]
    bodies = MovingBodies.of({b.name: b.shape for b in plates}, np.array([False, False]), radius=0.0)
    R = np.array([rotation((0.6, 0.8, 0), turned)] * 2)
    places = np.array([np.zeros(3), R[0] @ [0.1, 0.2, 0.05 + gap]])
    found = bodies.touching(places, R, 1.0, 1.0)
    assert found.gap == pytest.approx(gap, abs=1e-9)
    assert len(found.gap) == 4


UP = np.array([0.0, 0, 1])
PRESSURES = np.array([0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5])


def on_circle(angles):
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def regular(n):
    return on_circle(np.arange(n) * 2 * np.pi / n)


OUTLINES = {
    "nearly a square": [(0, 0), (1, 0.02), (1.02, 0.98), (0, 1)],
    "thin": [(0, 0), (1, 0), (1, 0.3), (0.02, 0.3)],
    "thinner": [(0, 0), (1, 0), (1, 0.1), (0.01, 0.1)],
    "voussoir": [(0, 0), (1, 0), (0.9, 0.5), (0.1, 0.5)],
    "trapezoid": [(0, 0), (1, 0), (0.7, 0.6), (0.3, 0.6)],
    "parallelogram": [(0, 0), (1, 0), (1.6, 0.6), (0.6, 0.6)],
    "triangle": [(0, 0), (1, 0), (0, 0.7)],
    "obtuse triangle": [(0, 0), (1, 0), (0.2, 0.2)],
    "pentagon": [(0, 0), (1, 0), (1, 0.6), (0.5, 1), (0, 0.6)],
    "hexagon": regular(6),
    "octagon": regular(8),
    "circle": regular(24),
    "L": [(0, 0), (1, 0), (1, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)],
    "T": [(0, 0.7), (0, 1), (1, 1), (1, 0.7), (0.65, 0.7), (0.65, 0), (0.35, 0), (0.35, 0.7)][::-1],
    "U": [(0, 0), (1, 0), (1, 1), (0.7, 1), (0.7, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)],
    "dart": [(0, 0), (1, -0.5), (0.3, 0), (1, 0.5)],
}


def cells_of(corners, count, **kwargs):
    """Cells of an outline about its centroid, in its plane."""
    corners = np.array(corners, dtype=float)
    corners = corners - shapely.get_coordinates(shapely.centroid(shapely.Polygon(corners)))
    points = np.pad(corners, ((0, 0), (0, 1)))
    centres, areas = polygon_cells(points, np.zeros(3), UP, count, "i", **kwargs)
    return shapely.Polygon(corners), centres[:, :2], areas


def beyond(outline, u, line):
    """Area of the part of an outline beyond a line across u, and its first moment about that line."""
    size = 4 * float(np.ptp(shapely.get_coordinates(outline), axis=0).max())
    side = np.array([-u[1], u[0]])
    half = shapely.Polygon([line * u - size * side, line * u + size * side, size * (u + side), size * (u - side)])
    part = shapely.intersection(outline, half)
    return part.area, part.area * (shapely.get_coordinates(shapely.centroid(part))[0] @ u - line) if part.area else 0.0


def worst_loss(outline, centres, areas):
    """Largest share of the moment of the stress block that cells lose, over directions and pressures."""
    corners = shapely.get_coordinates(outline)
    edges = np.diff(corners, axis=0)
    across = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    worst = 0.0
    for u in (*regular(24), *across, *-across):
        low, high = (corners @ u).min(), (corners @ u).max()
        lines = high - (high - low) * (1 - np.cos(np.linspace(0, np.pi, 81))) / 2
        N, M = np.array([beyond(outline, u, line) for line in lines]).T
        exact = np.interp(PRESSURES * outline.area, N, M + lines * N)
        order = np.argsort(-(centres @ u))
        borne, moment = (np.append(0, np.cumsum(part[order])) for part in (areas, areas * (centres @ u)))
        worst = max(worst, (1 - np.interp(PRESSURES * outline.area, borne, moment) / exact).max())
    return worst


#: Of four, three and many edges, and with an inner corner: these are looked at by default.
TELLING = ("nearly a square", "voussoir", "triangle", "octagon", "L")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in TELLING)) for name in OUTLINES]
)
def test_cells_lose_little_of_the_moment_and_less_than_half_of_what_equal_ones_do(name):
    outline, centres, areas = cells_of(OUTLINES[name], 64)
    assert len(areas) <= 64
    assert areas.sum() == pytest.approx(outline.area, rel=1e-8)
    lost = worst_loss(outline, centres, areas)
    assert lost < 0.075
    assert lost < 0.5 * worst_loss(*cells_of(OUTLINES[name], 64, regular=True))


@pytest.mark.parametrize("rows", [4, 8, 16])
def test_a_square_loses_what_the_rule_says(rows):
    """``(π / 2 n)²``, wherever the neutral axis is: the rows are projections of equal arcs."""
    lost = worst_loss(*cells_of([(0, 0), (1, 0), (1, 1), (0, 1)], rows**2))
    assert lost == pytest.approx((np.pi / 2 / rows) ** 2, rel=0.06)


@st.composite
def outlines(draw):
    """Polygons around a point, most of them not convex, stretched by up to ten."""
    n = draw(st.integers(3, 9))
    share = st.floats(0.1, 1)
    angles = np.cumsum([draw(share) for _ in range(n)])
    # An edge that passes the point on the other side may cross others.
    assume(2 * np.diff(angles, prepend=0).max() < angles[-1])
    radii = np.array([draw(share) for _ in range(n)])
    return radii[:, None] * on_circle(2 * np.pi * angles / angles[-1]) * [1, draw(st.floats(0.1, 1))]


@few(60)
@given(corners=outlines(), count=st.integers(1, 80), turn=st.floats(0, 2 * np.pi), where=st.floats(-1, 1))
def test_cells_never_bear_more_than_the_polygon(corners, count, turn, where):
    """The work of the strength in any rotation of a joint that presses: of cells, at most that of the whole area."""
    outline, centres, areas = cells_of(corners, count)
    u = on_circle(np.array([turn]))[0]
    reach = np.abs(shapely.get_coordinates(outline) @ u).max()
    for line in where * reach, 0.9 * reach, 0.99 * reach:
        of_cells = areas @ np.maximum(centres @ u - line, 0)
        assert of_cells <= beyond(outline, u, line)[1] + 1e-8 * outline.area * reach
    assert areas.sum() == pytest.approx(outline.area, rel=1e-7)
    np.testing.assert_allclose(areas @ centres, 0, atol=1e-7 * outline.area * reach)
    assert len(areas) <= count + len(corners)


@pytest.mark.parametrize("name", [*OUTLINES, "L of halves"])
@pytest.mark.parametrize("count", [16, 50, 64])
def test_the_division_does_not_depend_on_rounding(name, count):
    """Nor on where the joint stands: another machine must find the cells that are in a file."""
    halves = [(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)]
    corners = np.array(OUTLINES.get(name, halves), dtype=float)
    _, centres, areas = cells_of(corners, count)
    for seed in range(3):
        random = np.random.default_rng(seed)
        _, others, of_others = cells_of(corners + random.normal(0, 2e-16, corners.shape), count)
        np.testing.assert_allclose(others, centres, atol=1e-9)
        np.testing.assert_allclose(of_others, areas, atol=1e-9)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, s], [-s, c]])
    _, turned, _ = cells_of(corners @ turn + [3, -8], count)
    np.testing.assert_allclose(turned, centres @ turn, atol=1e-9)


@pytest.mark.parametrize("count", [300, 1000, 5000])
def test_many_cells_are_a_grid_that_is_not_searched_for(count):
    outline, centres, areas = cells_of(OUTLINES["octagon"], count)
    assert 0.9 * count <= len(areas) <= count
    assert worst_loss(outline, centres, areas) < (0.025 if count == 300 else 0.008)
