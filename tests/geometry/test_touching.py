"""Where bodies that have moved touch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from blockstruct.geometry.touching import MovingBodies
from structures import box, rotation

ANGLES = st.floats(-0.05, 0.05)


@given(ANGLES, ANGLES, st.floats(-0.15, 0.15), st.floats(-np.pi, np.pi))
def test_flush_faces(first, second, aside, turned):
    """Two units of a wall that turn in its plane touch in front as behind, at any azimuth, whatever rounding does."""
    units = [box(name, [0, 0, 0], [0.4, 0.3, 0.2]) for name in ("lower", "upper")]
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
    plates = [box(name, [0, 0, 0], [3, 3, 0.05]) for name in ("lower", "upper")]
    bodies = MovingBodies.of({b.name: b.shape for b in plates}, np.array([False, False]), radius=0.0)
    R = np.array([rotation((0.6, 0.8, 0), turned)] * 2)
    places = np.array([np.zeros(3), R[0] @ [0.1, 0.2, 0.05 + gap]])
    found = bodies.touching(places, R, 1.0, 1.0)
    assert found.gap == pytest.approx(gap, abs=1e-9)
    assert len(found.gap) == 4
