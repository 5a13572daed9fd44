"""Masses of blocks and of the weights that they carry."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np

from blockstruct.arrays import Array
from blockstruct.errors import ModelError
from blockstruct.model import STANDARD_GRAVITY, Block, LoadPattern, Model
from blockstruct.statics.carried import carried_weights


@dataclass(frozen=True, slots=True)
class Masses:
    """Masses of the blocks and of the weights that they carry.

    Attributes
    ----------
    mass : (B,) array, kg
    offset : (B, 3) array, m
        Centre of mass of each block, from its centroid, with the blocks at their positions in the model.
    inertia : (B, 3, 3) array, kg·m²
        About the centre of mass, with the blocks at their positions in the model.
    """

    mass: Array
    offset: Array
    inertia: Array

    @classmethod
    def of(cls, model: Model, dead: LoadPattern, who: str) -> Self:
        """Return the masses under a dead load.

        Raises
        ------
        ModelError
            If a free block has no mass.
        """
        own = np.array([b.weight for b in model.blocks]) / STANDARD_GRAVITY
        carried = carried_weights(model, dead)
        more = carried.pushed / STANDARD_GRAVITY
        centroid = np.array([b.centroid for b in model.blocks])
        arm = carried.point - centroid[carried.block]
        mass, moment = own.copy(), np.zeros((len(own), 3))
        np.add.at(mass, carried.block, more)
        np.add.at(moment, carried.block, more[:, None] * arm)
        for block, value in zip(model.blocks, mass, strict=True):
            if not block.fixed and value <= 0:
                msg = f"{who}: block {block.name!r} has no mass, and would move without limit; give it a unit weight"
                raise ModelError(msg)
        offset = moment / np.maximum(mass, 1e-300)[:, None]
        inertia = np.array([_inertia(b) for b in model.blocks])
        np.add.at(inertia, carried.block, more[:, None, None] * _about(arm))
        return cls(mass, offset, inertia - mass[:, None, None] * _about(offset))

    @property
    def size(self) -> Array:
        """Largest radius of gyration (B,), m."""
        return np.asarray(np.sqrt(np.linalg.eigvalsh(self.inertia)[:, -1] / np.maximum(self.mass, 1e-300)))


def _about(arm: Array) -> Array:
    """Return the inertia (n, 3, 3) of unit masses at arms (n, 3) about the origin."""
    return np.asarray((arm**2).sum(axis=1)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None])


def _inertia(block: Block) -> Array:
    """Return the inertia (3, 3) of a block about its centroid, kg·m²."""
    vertices = block.shape.vertices - block.centroid
    triangles = vertices[[(face[0], a, b) for face in block.shape.faces for a, b in pairwise(face[1:])]]
    six_volumes = np.linalg.det(triangles)
    corners = np.concatenate([triangles, triangles.sum(axis=1, keepdims=True)], axis=1)
    # The second moments of a tetrahedron with a corner at the origin.
    second = np.einsum("t,tci,tcj->ij", six_volumes, corners, corners) / 120
    density = block.weight / STANDARD_GRAVITY / block.volume
    return np.asarray(density * (np.trace(second) * np.eye(3) - second))
