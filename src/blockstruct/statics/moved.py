"""Find the contacts and loads of a structure whose blocks have moved."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import ROUNDING, Array, Flags, Index
from blockstruct.geometry.polygon import plane_axes
from blockstruct.geometry.screws import rotation_matrices, rotation_vectors, screw_motions
from blockstruct.geometry.touching import MovingBodies, Touching
from blockstruct.model import LoadPattern, Model
from blockstruct.statics.contacts import ContactPoints
from blockstruct.statics.equilibrium import equilibrium_matrix
from blockstruct.statics.moving_cells import Crushed, MovingCells, PlacedCells
from blockstruct.statics.statics import Statics
from blockstruct.statics.ties import TieTable
from blockstruct.statics.wrenches import applied_loads, summed

#: Magnitude up to which entries of the equilibrium matrix of moved blocks are dropped; motions are no more accurate.
NO_ENTRY = 1e-8


@dataclass(frozen=True, slots=True)
class Placement:
    """Positions and rotations of the blocks.

    Attributes
    ----------
    position : (B, 3) array, m
        Positions of the centroids.
    rotation : (B, 3, 3) array
        Rotations from the orientation in the model.
    given : (B, 3) array or None
        Rotation vectors that the rotations were made from, rad; the rotations give them back only to rounding.
    """

    position: Array
    rotation: Array
    given: Array | None = None

    @classmethod
    def of(cls, model: Model) -> Self:
        """Return the placement of the blocks in the model."""
        return cls(np.array([b.centroid for b in model.blocks]), np.tile(np.eye(3), (len(model.blocks), 1, 1)))

    @classmethod
    def at(cls, position: Array, vectors: Array) -> Self:
        """Return the placement at positions (B, 3) and rotation vectors (B, 3).

        Positions are in m and rotation vectors in rad.
        """
        return cls(position, rotation_matrices(vectors), vectors)

    @property
    def vectors(self) -> Array:
        """Rotation vectors (B, 3), rad."""
        return rotation_vectors(self.rotation) if self.given is None else self.given

    def moved(self, twist: Array) -> Self:
        """Return the placement after each block follows the screw of its twist.

        A twist (B, 6) is the displacement of the centroid, m, and the rotation vector, rad.
        """
        R, t = screw_motions(twist[:, :3], twist[:, 3:])
        return type(self)(self.position + t, R @ self.rotation)


def rotated(wrench: Array, rotation: Array) -> Array:
    """Return wrenches or twists (B, 6) rotated by matrices (B, 3, 3)."""
    return np.asarray((wrench.reshape(-1, 2, 3) @ rotation.transpose(0, 2, 1)).reshape(-1, 6))


@dataclass(frozen=True, slots=True)
class MovingLoads:
    """Loads of a pattern on blocks that move.

    Forces keep their size and direction. Their points of application move with the blocks.

    Attributes
    ----------
    wrench : (B, 6) array
        Force, N, and moment about the centroid, N·m, with the blocks at their positions in the model.
    lever : (B, 3, 3) array
        ``Σ r Fᵀ`` over the forces on each block, r from its centroid.
    """

    wrench: Array
    lever: Array

    @classmethod
    def of(cls, model: Model, pattern: LoadPattern, dead: LoadPattern) -> Self:
        """Return the loads of a pattern, given the dead load of its case.

        Errors are the same as in :func:`applied_loads`.
        """
        found = applied_loads(model, pattern, dead)
        centroid = np.array([b.centroid for b in model.blocks])
        arm = found.point - centroid[found.block]
        lever = np.zeros((len(model.blocks), 3, 3))
        np.add.at(lever, found.block, arm[:, :, None] * found.force[:, None, :])
        return cls(summed(model, found), lever)

    def at(self, placement: Placement) -> Array:
        """Return the wrenches (B, 6) on blocks at a placement, global axes."""
        turned = (placement.rotation - np.eye(3)) @ self.lever
        return np.column_stack([self.wrench[:, :3], self.wrench[:, 3:] + _axial(turned)])

    def own(self, placement: Placement) -> Array:
        """Return the wrenches (B, 6) at a placement in the axes of each block."""
        return rotated(self.at(placement), placement.rotation.transpose(0, 2, 1))

    def work(self, before: Placement, after: Placement) -> float:
        """Return the work of the loads between two placements, J.

        The work of forces is exact. The work of moments is accurate to second order in the rotation.
        """
        moment = self.wrench[:, 3:] - _axial(self.lever)
        turn = after.rotation @ before.rotation.transpose(0, 2, 1)
        vectors = _axial(turn.transpose(0, 2, 1)) / 2
        change = after.rotation - before.rotation
        return float(
            (self.wrench[:, :3] * (after.position - before.position)).sum()
            + np.einsum("bij,bji->", change, self.lever)
            + (moment * vectors).sum()
        )


def _axial(matrices: Array) -> Array:
    """Return the axial vectors (n, 3) of ``M − Mᵀ`` for matrices M (n, 3, 3)."""
    return np.stack([matrices[:, i, j] - matrices[:, j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)


@dataclass(frozen=True, slots=True)
class MovedContacts:
    """Contacts at a placement.

    Attributes
    ----------
    points : ContactPoints
        Contact points; each is a separate interface.
    gap : (K,) array, m
        Gaps; negative for a penetration.
    A : (6 F, 3 K) sparse array
        Equilibrium matrix in the axes of each block; moments are divided by the characteristic length of the statics.
    cell : (K,) array
        Cell of each contact point in a joint that crushes; −1 elsewhere.
    cells : PlacedCells
        All cells of joints that crush.
    """

    points: ContactPoints
    gap: Array
    A: sp.csc_array
    cell: Index
    cells: PlacedCells

    def same_place(self, some: Flags, length: float) -> Flags:
        """Return whether each contact point (K,) is at the place of some of them, with the same blocks and normal.

        ``length`` is the mean size of a block, m.
        """
        points = self.points
        where = np.hstack([points.position / length, points.frame[:, 0]])
        places = np.column_stack([points.minus, points.plus, np.round(where / ROUNDING)])
        _, place = np.unique(places, axis=0, return_inverse=True)
        return np.asarray(np.bincount(place, some)[place] > 0)


class MovingStructure:
    """Blocks of a structure that move and touch.

    Parameters
    ----------
    statics
        Statics of the structure in the model. Two blocks with a joint in the model keep its friction wherever they
        touch. Two blocks without one get the least friction of the joints of either block.
    rounding
        Radius of the corners of blocks, m; zero if joints crush.

    Raises
    ------
    GeometryError
        If rounding the corners removes a whole face.
    """

    def __init__(self, statics: Statics, rounding: float = 0.0) -> None:
        model, points = statics.model, statics.points
        self.statics, self.rounding = statics, rounding
        self._centroid = np.array([b.centroid for b in model.blocks])
        self.fixed = np.array([b.fixed for b in model.blocks])
        self._bodies = MovingBodies.of({b.name: b.shape for b in model.blocks}, self.fixed, rounding)
        n = self._n_blocks = len(model.blocks)
        code = np.minimum(points.minus, points.plus) * n + np.maximum(points.minus, points.plus)
        order = np.lexsort((points.friction, code))
        self._pairs, first = np.unique(code[order], return_index=True)
        self._friction = np.column_stack([points.friction, points.dilatancy])[order][first]
        least = np.full(n, np.inf)
        for block in (points.minus, points.plus):
            np.minimum.at(least, block, points.friction)
        self._least = np.where(np.isfinite(least), least, points.friction.min())

    def cells(self, elastic: float) -> MovingCells:
        """Return the cells of joints that crush, with their elastic overlap under the strength, m."""
        return MovingCells.of(self.statics, self._bodies, elastic)

    def contacts(self, placement: Placement, reach: float, cells: MovingCells, crushed: Crushed) -> MovedContacts:
        """Return the contacts at a placement with gaps up to ``reach``, m.

        ``cells`` belong to joints that crush, and ``crushed`` is their memory.
        """
        statics, at = self.statics, (placement.position, placement.rotation)
        found = self._bodies.touching(*at, reach, statics.length)
        found, cell, placed = cells.joined(found, *at, crushed, reach)
        points = self._points(found, placement.rotation)
        points = replace(points, compression=np.append(cells.strength, np.inf)[cell])
        A = equilibrium_matrix(points, placement.position, statics.free, statics.length, placement.rotation, NO_ENTRY)
        return MovedContacts(points, found.gap, A, cell, placed)

    def points(
        self, placement: Placement, reach: float, cells: MovingCells, crushed: Crushed
    ) -> tuple[ContactPoints, Array, Array, Index]:
        """Return the contact points at a placement with gaps up to ``reach``, m, their gaps (K,), m, and levels (K,).

        The level is 1 at a vertex of the plus block, 0 at a vertex of the minus block, and ½ where edges cross.
        Cells that act are the last points, and their numbers (A,) are the last result.
        """
        at, cell = (placement.position, placement.rotation), np.empty(0, dtype=np.int64)
        found = self._bodies.touching(*at, reach, self.statics.length)
        if len(cells):
            found, cell, _ = cells.joined(found, *at, crushed, reach)
        return self._points(found, placement.rotation), found.gap, found.level, cell[cell >= 0]

    def ties(self, placement: Placement) -> TieTable:
        """Return the ties between the moved anchors at a placement."""
        table = self.statics.ties
        ends = table.ends
        arm = np.einsum("meij,mej->mei", placement.rotation[ends], table.position - self._centroid[ends])
        position = placement.position[ends] + arm
        way = position[:, 1] - position[:, 0]
        # Anchors at the same point define no direction: the direction is zero.
        direction = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-300)
        return replace(table, position=position, direction=direction)

    def friction(self, minus: Index, plus: Index) -> tuple[Array, Array]:
        """Return friction coefficient and dilatancy (K,) of pairs of blocks."""
        code = np.minimum(minus, plus) * self._n_blocks + np.maximum(minus, plus)
        place = np.minimum(np.searchsorted(self._pairs, code), len(self._pairs) - 1)
        known = self._pairs[place] == code
        least = np.minimum(self._least[minus], self._least[plus])
        return np.where(known, self._friction[place, 0], least), np.where(known, self._friction[place, 1], 0.0)

    def _points(self, found: Touching, rotation: Array) -> ContactPoints:
        K = len(found.gap)
        none, infinite = np.zeros(K), np.full(K, np.inf)
        friction, dilatancy = self.friction(found.minus, found.plus)
        own = rotation[found.minus]
        axes = np.stack(plane_axes(np.einsum("kij,ki->kj", own, found.normal)), axis=1)
        return ContactPoints(
            position=found.position,
            interface=np.arange(K),
            minus=found.minus,
            plus=found.plus,
            frame=np.concatenate([found.normal[:, None], axes @ own.transpose(0, 2, 1)], axis=1),
            centroid=found.position,
            area=none,
            strength=infinite,
            torsion_lever=infinite,
            friction=friction,
            dilatancy=dilatancy,
            cohesion=none,
            tension=none,
            tributary_area=none,
            normal_stiffness=infinite,
            shear_stiffness=infinite,
            compression=infinite,
            rectangles=np.empty((0, 4), dtype=np.int64),
        )
