"""Steps of frictional contact, by interior points and by splitting, against conic programs with a fixed shift."""

import clarabel
import numpy as np
import pytest
import scipy.sparse as sp

import blockstruct as bs
from blockstruct.limit import ConicProgram, LimitProblem
from blockstruct.solvers.interior_point import ContactProblem, Step
from blockstruct.solvers.interior_point.cones import ConeVector, Scaling, centred
from blockstruct.solvers.splitting import Splitting
from blockstruct.statics.statics import Statics
from structures import SELF_WEIGHT, box, model_of, push

#: Of a step in the tests: friction far inside its cone is as exact as the root of the gap.
TIGHT = 1e-10


def points(rng, m=200, n=50):
    """Points inside cones and half-lines, some of them close to the boundary."""
    tail = rng.normal(size=(m, 2))
    head = np.linalg.norm(tail, axis=1) * (1 + 10 ** rng.uniform(-6, 1, m))
    return ConeVector(np.column_stack([head, tail]), 10 ** rng.uniform(-6, 2, n))


def same(a, b, rtol=1e-6):
    np.testing.assert_allclose(a.soc, b.soc, rtol=rtol, atol=rtol * np.abs(b.soc).max())
    np.testing.assert_allclose(a.line, b.line, rtol=rtol)


def test_jordan_algebra():
    rng = np.random.default_rng(0)
    y, z = points(rng), points(rng)
    one = ConeVector.identity(200, 50)
    same(y.times(one), y)
    same(y.times(z), z.times(y))
    same(y.solve(y.times(z)), z)
    same(y.times(y.inverse()), one)


def test_scaling_takes_one_point_to_the_inverse_of_the_other():
    rng = np.random.default_rng(1)
    y, z = points(rng), points(rng)
    scaling = Scaling(y, z)
    same(scaling.times(z), scaling.divided(y), rtol=1e-5)
    same(scaling.divided(scaling.times(y)), y)
    soc, line = scaling.inverse_square()
    same(ConeVector(np.einsum("kij,kj->ki", soc, y.soc), line * y.line), z, rtol=1e-4)


def test_longest_step_ends_on_the_boundary():
    rng = np.random.default_rng(2)
    y = points(rng)
    change = ConeVector(rng.normal(size=(200, 3)), rng.normal(size=50))
    t = y.longest_step(change)
    after = y + t * change
    depth = after.soc[:, 0] - np.linalg.norm(after.soc[:, 1:], axis=1)
    least = min(depth.min(), after.line.min())
    assert least == pytest.approx(0.0, abs=1e-12)
    assert y.longest_step(y) == np.inf


def test_centred_pairs_lie_on_the_central_path_near_where_they_were():
    rng = np.random.default_rng(3)
    y, z = points(rng), 0.1 * points(rng)
    for mu in (1e-8, 1e-2):
        near = centred(y, z, mu)
        same(near.times(mu * near.inverse()), mu * ConeVector.identity(200, 50), rtol=1e-5)
        assert near.longest_step(-1.0 * near) == pytest.approx(1.0, rel=1e-3)


def random_stack(seed, joint):
    """Blocks of random sizes on top of each other, three at a time side by side."""
    rng = np.random.default_rng(seed)
    blocks = [box("ground", [-1, -1, -1], [4, 3, 1], fixed=True)]
    for course in range(3):
        x = np.cumsum([0.1 * rng.random(), *(0.5 + 0.1 * rng.random(3))])
        blocks += [box(f"{course}.{k}", [x[k], 0, 0.4 * course], [x[k + 1] - x[k], 0.5, 0.4]) for k in range(3)]
    return model_of(blocks, joint)


def reference(problem, contact, s, shift_tolerance=1e-9):
    """Forces of the step from the dead-load state, by Clarabel programs with De Saxcé's shift as it was last."""
    K, equilibrium = problem.n_points, problem.A.shape[0]
    rest = _program(problem, contact, np.zeros((K, 3)), np.zeros(K), np.zeros(K), None)
    x, u, _ = rest
    shift = np.zeros(K)
    for _ in range(400):
        x, u, alpha = _program(problem, contact, np.zeros((K, 3)), np.zeros(K), shift, None)
        new = _shift(problem, contact, x, u, np.zeros((K, 3)))
        if np.abs(new - shift).max() < shift_tolerance:
            break
        shift = 0.5 * (new + shift)
    dead, opening = x, (problem.A.T @ u).reshape(-1, 3)[:, 0]
    old = dead * [0.0, 1.0, 1.0]
    for _ in range(2000):
        x, u, alpha = _program(problem, contact, old, opening, shift, s)
        new = _shift(problem, contact, x, u, old)
        if np.abs(new - shift).max() < shift_tolerance * max(1.0, np.abs(new).max()):
            break
        shift = 0.5 * (new + shift)
    assert u.shape == (equilibrium,)
    return dead, x, alpha


def _shift(problem, contact, x, u, old):
    slip = (problem.A.T @ u).reshape(-1, 3) + contact.compliance.reshape(-1, 3) * (x - old)
    return (problem.friction - problem.dilatancy) * np.linalg.norm(slip[:, 1:], axis=1)


def _program(problem, contact, old, opening, shift, s):
    K, equilibrium, C = problem.n_points, problem.A.shape[0], contact.compliance.reshape(-1, 3)
    linear = -C * old
    linear[:, 0] += opening + shift
    q = np.concatenate([[0.0 if s is None else -s], linear.ravel()])
    load = np.zeros(equilibrium) if s is None else problem.w_L
    cones = -sp.diags_array(np.column_stack([problem.friction, np.ones((K, 2))]).ravel())
    fixed = sp.csc_array(([1.0 if s is None else 0.0], ([0], [0])), shape=(1, 3 * K + 1))
    G = sp.vstack(
        [sp.hstack([load[:, None], problem.A]), fixed, sp.hstack([sp.csc_array((3 * K, 1)), cones])], format="csc"
    )
    h = np.concatenate([-problem.w_D, [0.0], np.zeros(3 * K)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
    kinds = [clarabel.ZeroConeT(equilibrium + 1), *[clarabel.SecondOrderConeT(3)] * K]
    P = sp.csc_matrix(sp.diags_array(np.concatenate([[0.0], C.ravel()])))
    solution = clarabel.DefaultSolver(P, q, sp.csc_matrix(G), h, kinds, settings).solve()
    y = np.array(solution.x)
    return y[1:].reshape(-1, 3), np.array(solution.z)[:equilibrium], y[0]


@pytest.mark.parametrize("seed", range(4))
def test_a_step_has_the_forces_of_conic_programs(seed):
    model = random_stack(seed, bs.JointMaterial("joint", 0.6))
    case = bs.LimitCase("push", SELF_WEIGHT, push(1, 0.3, 0), "nonassociative")
    problem = LimitProblem.of(Statics.of(model), case)
    normal = problem.compliance[:, 0]
    contact = ContactProblem(
        ConicProgram(problem, bs.ProcedureSettings()), np.column_stack([normal, normal / 0.4, normal / 0.4])
    )
    K, size = problem.n_points, 3 * problem.n_points
    found = contact.solve(Step(np.zeros(size), np.zeros(size), None), contact.start(), centre=True, tolerance=TIGHT)
    assert found.within(TIGHT)
    dead = found.state
    s = 0.4 * contact.elastic_displacement()
    expected_dead, expected, alpha = reference(problem, contact, s)
    # In multiples of the weight of the lighter block; a mean block weighs about as much.
    assert np.abs(dead.x.reshape(-1, 3) - expected_dead).max() < 1e-5

    forces, opening = dead.x.copy(), np.zeros(size)
    opening[0::3] = dead.z.line[:K] - normal * dead.x[0::3]
    forces[0::3] = 0.0
    step = Step(forces, opening, s)
    found = contact.solve(step, dead, centre=True, tolerance=TIGHT)
    assert found.within(TIGHT)
    assert found.state.alpha == pytest.approx(alpha, rel=1e-5)
    assert np.abs(found.state.x.reshape(-1, 3) - expected).max() < 1e-5

    splitting, exactly = Splitting(contact), {"tolerance": 1e-9, "patience": 2_000}
    rest = splitting.solve(Step(np.zeros(size), np.zeros(size), None), splitting.start(), penalty=20.0, **exactly)
    assert np.abs(rest.state.x.reshape(-1, 3) - expected_dead).max() < 1e-5
    found = splitting.solve(step, rest.state, penalty=4.0, **exactly)
    assert found.state.alpha == pytest.approx(alpha, rel=1e-5)
    assert np.abs(found.state.x.reshape(-1, 3) - expected).max() < 1e-5
