"""Merge blocks that move together into fewer, larger bodies."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.limit.moved import MovedProblem
from blockstruct.limit.problem import LimitProblem

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

#: Relative velocity up to which two blocks move as one body, relative to the fastest block or point. The relative
#: velocity is measured at contact points, and as relative rotation times the characteristic length.
TOGETHER = 1e-3
#: Gap, in characteristic lengths, up to which a contact point is closed; least closed points that join two blocks.
CLOSED, HOLDING = 1e-3, 3
#: Magnitude below which entries of the equilibrium matrix of bodies are rounding.
NO_ENTRY = 1e-10


def bodies_of(moved: MovedProblem, u: Array) -> Index:
    """Return the body number of each block, (B,), in a motion u (6 F,).

    The supports form body zero. Two blocks form one body if they are in contact and have no relative motion. Both
    contact points and relative rotation are checked, because contact points next to a hinge are slow, too.
    """
    # Import here because csgraph is slow to import.
    from scipy.sparse import csgraph

    problem, points = moved.problem, moved.contacts.points
    blocks, free = len(moved.placement.position), moved.free
    speed = np.linalg.norm((problem.A.T @ u).reshape(-1, 3), axis=1) / problem.force_unit
    turning = moved.twist(u)[:, 3:]
    code = np.minimum(points.minus, points.plus) * blocks + np.maximum(points.minus, points.plus)
    pairs, pair = np.unique(code, return_inverse=True)
    one, other = np.divmod(pairs, blocks)
    apart = np.linalg.norm(turning[one] - turning[other], axis=1) * problem.length
    np.maximum.at(apart, pair, speed)
    lying = np.bincount(pair, moved.contacts.gap <= CLOSED * problem.length, len(pairs)) >= HOLDING
    together = lying & (apart <= TOGETHER * max(float(speed.max(initial=0.0)), problem.fastest(u)))
    one, other = one[together], other[together]
    supports = np.setdiff1d(np.arange(blocks), free)
    one, other = np.append(one, supports[:-1]), np.append(other, supports[1:])
    graph = sp.coo_array((np.ones(len(one)), (one, other)), shape=(blocks, blocks))
    number = csgraph.connected_components(graph, directed=False)[1]
    # Renumber the bodies so that the supports come first.
    first = number[supports[0]]
    return np.asarray(np.where(number == first, 0, np.where(number < first, number + 1, number)))


@dataclass(frozen=True, slots=True)
class Bodies:
    """A moved problem in which blocks that move together form one body.

    Attributes
    ----------
    problem : LimitProblem
        Limit problem of the bodies and of the contact points between bodies.
    between : (K,) array
        Whether each contact point lies between two bodies.
    motion : (6 F, 6 G) sparse array
        Matrix from velocities of the bodies to velocities of the blocks.
    """

    problem: LimitProblem
    between: Flags
    motion: sp.csr_array

    @classmethod
    def of(cls, moved: MovedProblem, body: Index) -> Self:
        """Return the bodies for the body number of each block (B,).

        At least one body must be free.
        """
        problem, points = moved.problem, moved.contacts.points
        motion, unit = _motion(moved, body[moved.free])
        between = body[points.minus] != body[points.plus]
        A = sp.csc_array(motion.T @ problem.A[:, np.repeat(between, 3)])
        A.data[np.abs(A.data) < NO_ENTRY] = 0.0
        A.eliminate_zeros()
        of_points = ("friction", "dilatancy", "cohesion", "tension", "compression", "compliance", "force_unit")
        own = replace(
            problem,
            A=A,
            w_D=motion.T @ problem.w_D,
            w_L=motion.T @ problem.w_L,
            ties=replace(problem.ties, columns=sp.csc_array(motion.T @ problem.ties.columns)),
            wrench_unit=unit,
            **{name: getattr(problem, name)[between] for name in of_points},
        )
        return cls(own, between, motion)

    def of_blocks(self, u: Array) -> Array:
        """Return the velocities (6 G,) of the bodies that fit u best.

        The fit to the velocities u (6 F,) of the blocks is by least squares.
        """
        M = self.motion
        return np.asarray(sp.linalg.spsolve(sp.csc_array(M.T @ M), M.T @ u))


def _motion(moved: MovedProblem, body: Index) -> tuple[sp.csr_array, Array]:
    """Return the matrix from body to block velocities, and the wrench units.

    The matrix is (6 F, 6 G). The wrench units (G,) of the bodies are in N. The velocity of a body refers to its centre
    of weight in global axes. The velocity of a block is in the axes of the block.
    """
    problem, placement = moved.problem, moved.placement
    numbers, of_block = np.unique(body, return_inverse=True)
    moving = body > 0
    weight = problem.wrench_unit
    unit = np.asarray(np.bincount(of_block, weight), dtype=float)
    position = placement.position[moved.free]
    centre = np.column_stack([np.bincount(of_block, weight * x) for x in position.T]) / unit[:, None]
    arm = position - centre[of_block]
    reach = np.bincount(of_block, weight * (arm**2).sum(axis=1)) / unit
    length = np.sqrt(problem.length**2 + reach)
    back = placement.rotation[moved.free].transpose(0, 2, 1)
    share, turn = weight / unit[of_block], problem.length / length[of_block]
    values = np.zeros((len(body), 6, 6))
    values[:, :3, :3] = back
    values[:, :3, 3:] = np.cross(arm[:, None], back) / length[of_block][:, None, None]
    values[:, 3:, 3:] = back * turn[:, None, None]
    values *= share[:, None, None]
    column = np.cumsum(numbers > 0) - 1
    first = 6 * column[of_block]
    rows, columns = np.broadcast_arrays(
        6 * np.arange(len(body))[:, None, None] + np.arange(6)[:, None], first[:, None, None] + np.arange(6)
    )
    keep = moving[:, None, None] & (values != 0)
    shape = (6 * len(body), 6 * int((numbers > 0).sum()))
    return sp.csr_array((values[keep], (rows[keep], columns[keep])), shape=shape), unit[numbers > 0]
