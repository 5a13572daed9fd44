"""Halve a problem that is its own mirror image.

A wall pushed in its plane, or a dome pushed horizontally, has a plane of symmetry. Average a collapse state of
associative flow with its mirror image, and the result is a collapse state of the same load factor. So half of the
unknowns are enough.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import ROUNDING, Array, Index
from blockstruct.limit.certificate import certify
from blockstruct.limit.friction import Sliding
from blockstruct.limit.iteration import Iteration, Outcome, given_up
from blockstruct.limit.motion import without_rounding
from blockstruct.limit.problem import LimitProblem
from blockstruct.limit.ties import Ties
from blockstruct.statics.contacts import ContactPoints

#: Incommensurable weights of the components of a key. Two different places practically never have equal keys.
_WEIGHTS = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0])


@dataclass(frozen=True, slots=True)
class Mirror:
    """A problem of half a structure, and the way back to the whole.

    The forces of the whole are ``x = S x̂``, its velocities ``u = T û``. A contact point, or a block, that is not
    its own mirror image stands for two, and its unit of force is twice as large. So equilibrium ``Tᵀ A S``,
    loads ``Tᵀ w`` and strengths have the same form, work is unchanged, and ``v̂ = Sᵀ Aᵀ T û``. A block that is its own
    image keeps three of six motions. The rows of the others are empty. The whole has K contact points,
    F free blocks and R crushing rectangles; the half has K̂ contact points and F̂ blocks.

    Attributes
    ----------
    whole, half : LimitProblem
        Problem of the structure, and of its half.
    normal : (3,) array
        Normal of the plane of symmetry.
    S : (3 K, 3 K̂) sparse array
        Gives the forces of the whole from the forces of the half.
    T : (6 F, 6 F̂) sparse array
        Gives the velocities of the whole from the velocities of the half.
    point, rectangle : (K,), (R,) arrays
        Index in the half of each contact point and crushing rectangle. A rectangle that is its own image has the same
        two or three contact points at its four corners.
    """

    whole: LimitProblem
    half: LimitProblem
    normal: Array
    S: sp.csr_array
    T: sp.csr_array
    point: Index
    rectangle: Index

    @classmethod
    def of(cls, problem: LimitProblem) -> Self | None:
        """Return the mirror of a problem; None if the problem is not its own mirror image.

        Problems with ties, a settlement, uniform torsion, joints that never slide, or supports that hold some motions
        only, are not reduced.
        """
        more = len(problem.ties) or len(problem.torsion) or problem.never_slides.any() or problem.settlement is not None
        statics = problem.statics
        if statics is None or more or statics.held.any():
            return None
        centroid = np.array([b.centroid for b in statics.model.blocks])
        for normal in _normals(problem):
            found = cls.about(problem, normal, centroid, statics.points)
            if found is not None:
                return found
        return None

    @classmethod
    def about(
        cls, problem: LimitProblem, normal: Array, position: Array, points: ContactPoints, same: float = ROUNDING
    ) -> Self | None:
        """Return the mirror about a plane through the mean centroid of the free blocks.

        Parameters
        ----------
        problem
            The whole problem, whose wrenches are in axes that turn with each block.
        normal : (3,) array
            Unit normal of the plane.
        position : (B, 3) array, m
            Centroids of the blocks.
        points
            Contact points of the problem.
        same
            Lengths are equal if they differ by less, in multiples of the characteristic length of the statics.

        Returns
        -------
        Mirror or None
            None if the problem is not symmetric about the plane.
        """
        statics = problem.statics
        assert statics is not None
        F = problem.n_blocks
        centroid, at = position[statics.free] / statics.length, points.position / statics.length
        M, middle = np.eye(3) - 2 * np.outer(normal, normal), centroid.mean(axis=0)
        block = _mates(centroid - middle, (centroid - middle) @ M, same)
        # Rotations are axial vectors.
        turned = _permuted(block, np.tile(np.kron(np.diag([1.0, -1.0]), M), (F, 1, 1)))
        loads = np.column_stack([problem.w_D, problem.w_L])
        differ = np.abs(turned @ loads - loads).max() > same * np.abs(loads).max()
        if differ or not _alike(problem.wrench_unit, block):
            return None

        # All supports together are one block, which is its own image.
        number = np.full(len(statics.model.blocks), F)
        number[statics.free] = np.arange(F)
        minus, plus = number[points.minus], number[points.plus]
        frame, of_image = points.frame[points.interface], np.append(block, F)
        before = _keys(at - middle, minus, plus, frame[:, 0])
        after = _keys((at - middle) @ M, of_image[minus], of_image[plus], frame[:, 0] @ M)
        point = _mates(before, after, same)
        axes = np.einsum("kij,jl,kml->kim", frame[point], M, frame)
        # The normal points the other way if plus and minus change places.
        axes *= np.sign(axes[:, 0, 0])[:, None, None]
        axes[np.abs(axes) < ROUNDING] = 0.0
        reflected = _permuted(point, axes)
        numbers = (problem.friction, problem.dilatancy, problem.cohesion, problem.tension, problem.compression)
        equal = all(_alike(values, point) for values in (*numbers, problem.force_unit))
        equal &= bool((point[point] == np.arange(len(point))).all())
        if not equal or np.abs(turned @ problem.A - problem.A @ reflected).max() > same:
            return None
        mirror = cls._halved(problem, (block, turned, normal), (point, reflected))
        capacity = mirror.half.capacity[mirror.rectangle]
        return mirror if np.allclose(capacity, problem.capacity, rtol=ROUNDING, atol=0.0) else None

    @classmethod
    def _halved(
        cls, whole: LimitProblem, blocks: tuple[Index, sp.csr_array, Array], points: tuple[Index, sp.csr_array]
    ) -> Self:
        """Return the mirror from the images of blocks and points.

        ``blocks`` are the images of the blocks, the mirror image of wrenches, and the normal of the plane. ``points``
        are the images of the contact points, and the mirror image of forces.
        """
        (block, turned, normal), (point, reflected) = blocks, points
        some_block, is_single = block >= np.arange(len(block)), block == np.arange(len(block))
        some_point = point >= np.arange(len(point))
        # The axes of a block that is its own image are normal to the plane and in it.
        in_plane = np.linalg.svd(normal[None])[2].T
        axes = np.where(is_single[:, None, None], np.kron(np.eye(2), in_plane), np.eye(6))
        T = (turned + sp.eye_array(len(whole.w_D))) @ _permuted(np.arange(len(block)), axes / 2)
        of_points = (1.0 + (point != np.arange(len(point))))[some_point]
        S = (reflected + sp.eye_array(3 * len(point)))[:, np.repeat(some_point, 3)]
        S = S @ sp.diags_array(np.repeat(of_points / 2, 3))
        S, T = without_rounding(S, ROUNDING), without_rounding(T[:, np.repeat(some_block, 6)], ROUNDING)
        of_point = (np.cumsum(some_point) - 1)[np.minimum(np.arange(len(point)), point)]
        corners = of_point[whole.rectangles]
        _, some_rectangle, of_rectangle = np.unique(np.sort(corners), axis=0, return_index=True, return_inverse=True)
        half = replace(
            whole,
            A=sp.csc_array(without_rounding(sp.csr_array(T.T @ whole.A @ S), ROUNDING)),
            w_D=T.T @ whole.w_D,
            w_L=T.T @ whole.w_L,
            **whole.joints_at(some_point),
            rectangles=corners[some_rectangle],
            capacity=whole.capacity[some_rectangle],
            wrench_unit=whole.wrench_unit[some_block] * (2.0 - is_single[some_block]),
            force_unit=whole.force_unit[some_point] * of_points,
            ties=Ties.none(T.shape[1]),
            statics=None,
        )
        return cls(whole, half, normal, S, T, of_point, of_rectangle.ravel())

    def iteration(self, of_half: Iteration) -> Iteration:
        """Return an iteration of the whole, with its own certificate."""
        whole = self.whole
        x, u = (self.S @ of_half.x.ravel()).reshape(-1, 3), self.T @ of_half.u
        certificate, at = of_half.certificate, of_half.linearised_at
        if not of_half.stage.is_of_dead_load:
            # An unbounded load factor has no certificate.
            alpha = of_half.load_factor if np.isfinite(of_half.load_factor) else np.nan
            certificate = certify(whole, x, u, alpha, certificate.settings)
        return replace(
            of_half,
            x=x,
            u=u,
            v=(whole.A.T @ u).reshape(-1, 3),
            linearised_at=None if at is None else at[self.rectangle],
            sliding=Sliding(of_half.sliding.bound[self.point], of_half.sliding.slope[self.point]),
            certificate=certificate,
        )

    def outcome(self, of_half: Outcome) -> Outcome:
        """Return the outcome of the whole, whose units of force differ."""
        is_apart = np.isfinite(of_half.load_ratio)
        ratio = given_up(self.whole, of_half.reason).load_ratio if is_apart else np.nan
        return replace(of_half, load_ratio=ratio)


def _normals(problem: LimitProblem) -> list[Array]:
    """Return the normals of planes that may be planes of symmetry.

    A plane of symmetry contains the resultants of both loads. If they are parallel, it is a principal plane.
    """
    dead, variable = (
        (w.reshape(-1, 6)[:, :3] * problem.wrench_unit[:, None]).sum(axis=0) for w in (problem.w_D, problem.w_L)
    )
    across, size = np.cross(dead, variable), np.linalg.norm(dead) * np.linalg.norm(variable)
    if np.linalg.norm(across) > ROUNDING * size:
        candidates = [across / np.linalg.norm(across)]
    else:
        assert problem.statics is not None
        candidates = list(np.linalg.svd(np.cov(problem.statics.points.position.T))[2])
    # Without rounding, a plane along the axes adds no entries to the equilibrium matrix.
    return [np.where(np.abs(n) < ROUNDING, 0.0, n) for n in candidates]


def _mates(before: Array, after: Array, same: float) -> Index:
    """Return the index of the mirror image of each place.

    ``before`` (N, c) are the keys of the places, ``after`` the keys of their mirror images. Without a mirror image the
    index is any. Places with the same key keep their order.
    """

    def order(keys: Array) -> Index:
        key = keys @ _WEIGHTS[: keys.shape[1]]
        by_key = np.argsort(key)
        group = np.cumsum(np.diff(key[by_key], prepend=-np.inf) > same)
        return np.asarray(by_key[np.lexsort((by_key, group))])

    mates = np.empty(len(before), dtype=np.int64)
    mates[order(after)] = order(before)
    return mates


def _keys(position: Array, minus: Index, plus: Index, normal: Array) -> Array:
    """Return the keys of contact points: position, both blocks, and the normal from the first to the second block."""
    first, second = np.minimum(minus, plus), np.maximum(minus, plus)
    return np.column_stack([position, first, second, np.where(minus < plus, 1.0, -1.0)[:, None] * normal])


def _permuted(place: Index, blocks: Array) -> sp.csr_array:
    """Return the matrix with small blocks (N, r, r) in the columns of each item and the rows of its place."""
    r = blocks.shape[1]
    rows, columns = (r * i[:, None, None] + np.arange(r) for i in (place, np.arange(len(place))))
    rows, columns, values = np.broadcast_arrays(rows.transpose(0, 2, 1), columns, blocks)
    return sp.csr_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=(r * len(place),) * 2)


def _alike(values: Array, image: Index) -> bool:
    """Return whether values equal those at the mirror images."""
    return bool(np.allclose(values[image], values, rtol=ROUNDING, atol=0.0))
