"""Acceleration of iterations."""

import numpy as np
import pytest

from blockstruct.solvers.anderson import Anderson


def iterated(step, start, accelerated, times):
    """Where an iteration is after some steps."""
    point = start
    for _ in range(times):
        after = step(point)
        point = accelerated.point(point, after) if accelerated else after
    return point


@pytest.mark.parametrize("seed", range(5))
def test_a_linear_iteration_ends_after_as_many_steps_as_it_has_directions(seed):
    """Of six directions, seven changes tell all, but for rounding: the least change in their span is none."""
    rng = np.random.default_rng(seed)
    directions, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    turn = directions @ np.diag([0.99, -0.95, 0.9, 0.8, -0.5, 0.3]) @ directions.T
    exact, start = rng.normal(size=6), np.zeros(6)

    def step(point):
        return exact + turn @ (point - exact)

    found = iterated(step, start, Anderson(rng.uniform(0.5, 2.0, size=6), memory=6), 10)
    slow = iterated(step, start, None, 10)
    assert np.linalg.norm(found - exact) < 1e-6 * np.linalg.norm(exact)
    assert np.linalg.norm(slow - exact) > 1e-2 * np.linalg.norm(exact)


def test_what_swings_for_ever_comes_to_rest():
    """A rotation by a right angle goes round its centre."""
    exact = np.array([1.0, 2.0])
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])

    def step(point):
        return exact + turn @ (point - exact)

    assert np.linalg.norm(iterated(step, np.zeros(2), None, 40) - exact) == pytest.approx(np.linalg.norm(exact))
    assert np.linalg.norm(iterated(step, np.zeros(2), Anderson(np.ones(2), 4), 6) - exact) < 1e-6


def test_at_rest_it_stays():
    accelerated, point = Anderson(np.ones(3), 4), np.array([1.0, 2.0, 3.0])
    for _ in range(6):
        np.testing.assert_array_equal(accelerated.point(point, point), point)


def test_what_suddenly_changes_more_is_not_taken_for_the_same_iteration():
    accelerated = Anderson(np.ones(1), 4)
    accelerated.point(np.zeros(1), np.array([1.0]))
    accelerated.point(np.array([1.0]), np.array([1.5]))
    far = np.array([100.0])
    np.testing.assert_array_equal(accelerated.point(np.array([1.5]), far), far)


def test_numbers_without_weight_go_along():
    """They have no say in where to go, and go there with the others."""
    accelerated, point = Anderson(np.array([1.0, 0.0]), 3), np.zeros(2)
    for _ in range(4):
        # The first halves its way to one; the second is always twice the first.
        half = (1 + point[0]) / 2
        point = accelerated.point(point, np.array([half, 2 * half]))
    np.testing.assert_allclose(point, [1.0, 2.0], rtol=1e-6)
