"""Division of joints into cells: never more than the joint bears, and little less."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from blockstruct.geometry.cells import polygon_cells
from properties import few

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
