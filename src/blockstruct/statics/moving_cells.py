"""Follow the cells of joints that crush while blocks move."""

from dataclasses import dataclass, fields
from typing import NamedTuple, Self

import numpy as np

from blockstruct.arrays import NEGLIGIBLE, ROUNDING, Array, Flags, Index
from blockstruct.geometry.cells import polygon_cells_with_widths
from blockstruct.geometry.neighbours import expanded
from blockstruct.geometry.tolerances import FACING
from blockstruct.geometry.touching import MovingBodies, Touching
from blockstruct.statics.statics import Statics


class Crushed(NamedTuple):
    """Memory of cells.

    Attributes
    ----------
    depth : (C,) array, m
        Depth that the centre of each cell has lost; zero unless the cell was crushed as a whole.
    slope : (C, 3) array
        Slope of the crushed cell, in the axes of its block: direction in which the other face was closest, as long as
        the sine of its angle.
    share : (C,) array
        Normal force of each cell in the last state, relative to its strength: the share of its area that is crushed.
        NaN in responses to records, where it follows from the overlap.
    """

    depth: Array
    slope: Array
    share: Array


class PlacedCells(NamedTuple):
    """Cells at a placement of the blocks.

    Attributes
    ----------
    point : (C, 3) array, m
        Point at which the force of each cell acts.
    gap, compliance : (C,) arrays, m and m/N
        The normal force follows from them as in any contact, up to the strength.
    sinks : (C,) array, m
        Overlap under the strength.
    within : (C,) array
        Whether the cell lies within the other face.
    distance : (C,) array, m
        Distance of the other face from the centre of the cell; negative for an overlap.
    tilt : (C,) array
        Share of ``sinks`` that is due to the tilt of the other face, 0 to 1; the rest is elastic.
    slope : (C, 3) array
        Slope of the other face, as in :class:`Crushed`.
    lost : (C,) array, m
        Largest depth that each cell has lost.
    work : float, J
        Work that crushed whole cells so far.
    """

    point: Array
    gap: Array
    compliance: Array
    sinks: Array
    within: Flags
    distance: Array
    tilt: Array
    slope: Array
    lost: Array
    work: float


@dataclass(frozen=True, slots=True)
class MovingCells:
    """Cells of joints that crush.

    The cells of a joint are fixed on the smaller of its two faces. The plane of the other face presses on them. If this
    plane is tilted by an angle θ, it crushes a cell of width w from one side to the other while it comes closer by θ w.
    The force grows in proportion, and acts at the centre of the part that is crushed. So the cells bear a rectangular
    stress block exactly. A cell that is crushed as a whole loses the depth of its overlap.

    Attributes
    ----------
    owner, other : (C,) arrays
        Block with the face of each cell, and block across the joint.
    point : (C, 3) array, m
        Centre of each cell, from the centroid of its block.
    width : (C, 3, 3) array, m
        Widths, as in :func:`polygon_cells_with_widths`.
    inner, across : (C,) arrays
        A convex part of the face with the cell, and one of the other face.
    strength : (C,) array, N
        Compressive strength times the area of the cell.
    elastic : (C,) array or float, m
        Elastic overlap under the compressive strength.
    cell, part : (E,) arrays
        Every cell with every convex part of the other face.
    joint : (C,) array
        Number of the joint of each cell.
    pair, joint_of_pair : (P,) arrays
        Pairs of parts of the two blocks of a joint, as one number, of which at least one belongs to a face of the
        joint, and the number of the joint.
    edge_of_pair, both : (P,) arrays
        A part of the face of the joint that is on the block of the other part, and whether it belongs to this face.
    bodies : MovingBodies
    """

    owner: Index
    other: Index
    point: Array
    width: Array
    inner: Index
    across: Index
    strength: Array
    elastic: Array | float
    cell: Index
    part: Index
    joint: Index
    pair: Index
    joint_of_pair: Index
    edge_of_pair: Index
    both: Flags
    bodies: MovingBodies

    @classmethod
    def of(cls, statics: Statics, bodies: MovingBodies, elastic: float) -> Self:
        """Return the cells of all joints with a finite compressive strength."""
        model, index = statics.model, statics.model.block_index
        centroid = np.array([b.centroid for b in model.blocks])
        cells: list[tuple[Array, Array, Array]] = [(np.empty((0, 3)), np.empty(0), np.empty((0, 3, 3)))]
        blocks, faces = list[Index](), list[list[Index]]()
        for i in model.interfaces:
            if np.isinf(i.joint_material.compressive_strength):
                continue
            ends = np.array([index[name] for name in (i.minus, i.plus)])
            both = [
                bodies.face_at(end, i.centroid - centroid[end], sign * i.normal)
                for end, sign in zip(ends, (1, -1), strict=True)
            ]
            order = -1 if bodies.area(both[1]) <= (1 + ROUNDING) * bodies.area(both[0]) else 1
            blocks.append(ends[::order])
            faces.append(both[::order])
            at, area, width = polygon_cells_with_widths(i.polygon, i.centroid, i.normal, statics.division.cells, i.name)
            cells.append((at, i.joint_material.compressive_strength * area, width))
        point, strength, width = (np.concatenate(column) for column in zip(*cells, strict=True))
        joint = np.repeat(np.arange(len(faces)), np.array([len(at) for at, _, _ in cells[1:]], dtype=np.int64))
        owner, other = np.array(blocks, dtype=np.int64).reshape(-1, 2)[joint].T
        inner, across = np.array([[a[0], b[0]] for a, b in faces], dtype=np.int64).reshape(-1, 2)[joint].T
        point -= centroid[owner]
        off = np.einsum("ki,ki->k", point - bodies.corner[inner, 0], bodies.normal[inner])
        none = np.empty(0, dtype=np.int64)
        pairs: list[tuple[Index, Index, Index, Index]] = [(none, none, none, none)]
        for k, (ends, (one, two)) in enumerate(zip(blocks, faces, strict=True)):
            for this, that, block in ((one, two, ends[1]), (two, one, ends[0])):
                a, b = (grid.ravel() for grid in np.meshgrid(this, np.flatnonzero(bodies.of_part == block)))
                pairs.append((bodies.pair(a, b), np.full(len(a), k), np.full(len(a), that[0]), 1 * np.isin(b, that)))
        pair, joint_of_pair, edge_of_pair, both_of_pair = (
            np.concatenate(column) for column in zip(*pairs, strict=True)
        )
        count = np.array([len(b) for _, b in faces], dtype=np.int64)
        return cls(
            owner=owner,
            other=other,
            point=point - off[:, None] * bodies.normal[inner],
            width=width,
            inner=inner,
            across=across,
            strength=strength,
            elastic=elastic,
            cell=np.repeat(np.arange(len(joint)), count[joint]),
            part=np.concatenate([none, *(faces[k][1] for k in joint)]),
            joint=joint,
            pair=pair,
            joint_of_pair=joint_of_pair,
            edge_of_pair=edge_of_pair,
            both=both_of_pair.astype(bool),
            bodies=bodies,
        )

    def __len__(self) -> int:
        return len(self.owner)

    @property
    def untouched(self) -> Crushed:
        """The memory of cells that have borne nothing."""
        return Crushed(np.zeros(len(self)), np.zeros((len(self), 3)), np.zeros(len(self)))

    def at(self, position: Array, rotation: Array, crushed: Crushed) -> PlacedCells:
        """Return the cells at a placement.

        Parameters
        ----------
        position : (B, 3) array, m
            Centroids of the blocks.
        rotation : (B, 3, 3) array
            Rotations of the blocks.
        crushed
            Memory of the cells.
        """
        (depth, before, share), bodies, turn = crushed, self.bodies, rotation[self.owner]
        centre = position[self.owner] + np.einsum("kij,kj->ki", turn, self.point)
        seen = np.einsum("kji,kj->ki", rotation[self.other], centre - position[self.other])
        corner = bodies.corner[self.part]
        edge = np.roll(corner, -1, axis=1) - corner
        inwards = np.cross(bodies.normal[self.across[self.cell], None], edge)
        length = np.linalg.norm(edge, axis=2)
        least = -ROUNDING * length * length.max(axis=1, keepdims=True)
        within = np.zeros(len(self), dtype=bool)
        height = np.einsum("evi,evi->ev", seen[self.cell, None] - corner, inwards)
        within[self.cell[(height >= least).all(axis=1)]] = True

        distance = np.einsum("ki,ki->k", seen - bodies.corner[self.across, 0], bodies.normal[self.across])
        # Direction in which the faces come closer, in the axes of the owner; its length is the sine of their angle.
        own, closer = bodies.normal[self.inner], -np.einsum("kji,kj->ki", turn, self._pressing(rotation))
        cosine = np.einsum("ki,ki->k", closer, own)
        within &= cosine >= np.cos(FACING)
        slope = closer - cosine[:, None] * own
        tilted = slope - before
        sine = np.linalg.norm(tilted, axis=1)
        half = np.einsum("kij,kj->ki", self.width, tilted / np.maximum(sine, 1e-300)[:, None]) / 2
        tilt = 2 * np.einsum("ki,ki->k", half, tilted)
        gap, sinks = distance + depth - tilt / 2, self.elastic + tilt
        overlap = np.clip(-gap / sinks, 0.0, 1.0)
        known = np.isfinite(share)
        whole = np.where(known, sinks, np.maximum(tilt + overlap * self.elastic, 1e-300))
        share = np.where(known, share, overlap)
        shift = ((1 - share) * tilt / whole)[:, None] * half
        return PlacedCells(
            point=centre + np.einsum("kij,kj->ki", turn, shift),
            gap=gap,
            compliance=sinks / self.strength,
            sinks=sinks,
            within=within,
            distance=distance,
            tilt=tilt / sinks,
            slope=slope,
            lost=depth + np.minimum(overlap, share) * tilt,
            work=float(self.strength @ depth),
        )

    def after(self, before: Crushed, force: Array, position: Array, rotation: Array) -> Crushed:
        """Return the memory of cells at a placement after forces (C,), N, that led there.

        Cells that bear their strength lose the overlap beyond the elastic one.
        """
        share, at = force / self.strength, self.at(position, rotation, before)
        return self._worn(before, at, share >= 1 - ROUNDING)._replace(share=share)

    def pressed(self, before: Crushed, acts: Index, position: Array, rotation: Array) -> Crushed:
        """Return the memory at a placement, where the cells ``acts`` lose their overlap at their strength."""
        at = self.at(position, rotation, before)
        whole = np.zeros(len(self), dtype=bool)
        whole[acts] = (at.within & (-at.gap >= at.sinks))[acts]
        return self._worn(before, at, whole)

    def _worn(self, before: Crushed, at: PlacedCells, whole: Flags) -> Crushed:
        """Return the memory after some cells (C,) were crushed as a whole."""
        whole = whole & (-at.distance - self.elastic > before.depth)
        depth = np.where(whole, -at.distance - self.elastic, before.depth)
        return Crushed(depth, np.where(whole[:, None], at.slope, before.slope), before.share)

    def _pressing(self, rotation: Array) -> Array:
        """Return the outward normals (C, 3) of the other faces."""
        return np.asarray(np.einsum("kij,kj->ki", rotation[self.other], self.bodies.normal[self.across]))

    def joined(
        self, found: Touching, position: Array, rotation: Array, crushed: Crushed, reach: float
    ) -> tuple[Touching, Index, PlacedCells]:
        """Return contact points that include cells, the cell of each or −1, and all cells.

        Cells replace the contact points of the two faces of their joint while one of them lies within the other face.
        They also replace points where an edge of one of these faces meets the other block.

        Parameters
        ----------
        found
            Contact points without cells.
        position, rotation, crushed
            As in :meth:`at`.
        reach
            Largest gap, m.
        """
        at = self.at(position, rotation, crushed)
        acts = np.flatnonzero(at.within & (np.abs(at.gap) <= reach))
        kept = ~self._covered(found, position, rotation, np.isin(self.joint_of_pair, self.joint[acts]))
        cells = Touching(
            minus=self.other[acts],
            plus=self.owner[acts],
            position=at.point[acts],
            normal=self._pressing(rotation)[acts],
            gap=at.gap[acts],
            level=np.ones(len(acts)),
            part=np.column_stack([self.across, self.inner])[acts],
        )
        joined = (np.concatenate([getattr(found, f.name)[kept], getattr(cells, f.name)]) for f in fields(Touching))
        cell = np.concatenate([np.full(np.count_nonzero(kept), -1), acts])
        return Touching(*joined), cell, at

    def _covered(self, found: Touching, position: Array, rotation: Array, acts: Flags) -> Flags:
        """Return whether cells stand for contact points (K,), where some pairs (P,) belong to joints that act."""
        some = np.flatnonzero(acts)
        some = some[np.argsort(self.pair[some])]
        codes = self.bodies.pair(*found.part.T)
        first, last = (np.searchsorted(self.pair[some], codes, side) for side in ("left", "right"))
        point, at, _ = expanded(first, last - first)
        face = self.edge_of_pair[some[at]]
        body, corner = self.bodies.of_part[face], self.bodies.corner[face]
        seen = np.einsum("kji,kj->ki", rotation[body], found.position[point] - position[body])
        off = np.einsum("ki,ki->k", seen - corner[:, 0], self.bodies.normal[face])
        size = np.ptp(corner, axis=1).max(axis=1, initial=0.0)
        covered = np.zeros(len(found.gap), dtype=bool)
        covered[point[self.both[some[at]] | (np.abs(off) <= NEGLIGIBLE * size)]] = True
        return covered
