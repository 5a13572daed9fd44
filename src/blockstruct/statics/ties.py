"""Turn the ties of a model into arrays, one row per stretch."""

from dataclasses import dataclass, fields
from itertools import compress
from typing import Any, Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Flags, Index
from blockstruct.model import Model, tie_segments


@dataclass(frozen=True, slots=True)
class TieTable:
    """All stretches j of the ties of a model, grouped by tie.

    A stretch carries one force.

    Attributes
    ----------
    name : tuple of str
    tie : (M,) array
        Index of the tie of each stretch.
    ends : (M, 2) array
        Indices of the two blocks that each stretch pulls together.
    position : (M, 2, 3) array, m
        End of each stretch in each block, on its line of action.
    direction : (M, 3) array
        Unit vectors from the first to the second end.
    capacity, prestress : (M,) arrays, N
        Largest and least force.
    governing : tuple of str
        Name of the limit that sets the largest force.
    bond : (M, 2) array, N
        Largest change of the force in the block at each end; infinite at an anchor.
    elongation_limit : (M,) array, m
        Elongation at which the tie breaks; infinite without a limit.
    """

    name: tuple[str, ...]
    tie: Index
    ends: Index
    position: Array
    direction: Array
    capacity: Array
    prestress: Array
    governing: tuple[str, ...]
    bond: Array
    elongation_limit: Array

    @classmethod
    def of(cls, model: Model) -> Self:
        """Return the table of a model; its arrays are empty without ties."""
        segments = tie_segments(model.ties, model.blocks)
        index = {b.name: i for i, b in enumerate(model.blocks)}
        number = {tie.name: i for i, tie in enumerate(model.ties)}

        def floats(values: list[object], *shape: int) -> Array:
            return np.array(values, dtype=float).reshape(len(segments), *shape)

        return cls(
            name=tuple(s.name for s in segments),
            tie=np.array([number[s.tie] for s in segments], dtype=np.int64),
            ends=np.array([[index[b] for b in s.blocks] for s in segments], dtype=np.int64).reshape(-1, 2),
            position=floats([(s.start, s.end) for s in segments], 2, 3),
            direction=floats([s.direction for s in segments], 3),
            capacity=floats([s.capacity for s in segments]),
            prestress=floats([s.prestress for s in segments]),
            governing=tuple(s.governing for s in segments),
            bond=floats([s.bond for s in segments], 2),
            elongation_limit=floats([s.elongation_limit for s in segments]),
        )

    def __len__(self) -> int:
        return len(self.name)

    def __getitem__(self, chosen: Flags) -> Self:
        """Return the table of the chosen stretches (M,)."""
        own: dict[str, Any] = {
            f.name: tuple(compress(value, chosen)) if isinstance(value, tuple) else value[chosen]
            for f in fields(self)
            for value in [getattr(self, f.name)]
        }
        return type(self)(**own)

    @property
    def span(self) -> Array:
        """Length (M,) between the ends, m."""
        return np.asarray(np.linalg.norm(self.position[:, 1] - self.position[:, 0], axis=1))

    def columns(self, centroids: Array, free: Index, length: float, rotation: Array | None = None) -> sp.csc_array:
        """Return the wrenches of unit forces in the stretches.

        The wrench is ``[d; (p − c) × d]`` on the block at the start, and its negative on the block at the end.

        Parameters
        ----------
        centroids : (B, 3) array, m
            Reference points of the moments.
        free : (F,) array
            Indices of the free blocks; supports have no rows.
        length
            Characteristic length, m; moments are divided by this length.
        rotation : (B, 3, 3) array
            Rotations of the blocks. The rows of a block are then in its rotated axes.

        Returns
        -------
        (6 F, M) sparse array
        """
        row_of = np.full(len(centroids), -1)
        row_of[free] = 6 * np.arange(len(free))
        forces = np.array([1.0, -1.0])[:, None] * self.direction[:, None]
        arms = self.position - centroids[self.ends]
        if rotation is not None:
            forces, arms = (np.einsum("meij,mei->mej", rotation[self.ends], part) for part in (forces, arms))
        moments = np.cross(arms, forces) / length
        wrench = np.concatenate([forces, moments], axis=2)
        rows = row_of[self.ends][:, :, None] + np.arange(6)
        columns = np.broadcast_to(np.arange(len(self))[:, None, None], rows.shape)
        on = np.broadcast_to(row_of[self.ends][:, :, None] >= 0, rows.shape)
        return sp.csc_array((wrench[on], (rows[on], columns[on])), shape=(6 * len(free), len(self)))

    def bond_rows(self) -> tuple[sp.csr_array, Array]:
        """Return the force changes along bonded bars and their limits.

        Each row (R, M) takes the force in one stretch from the force in the next. The bond (R,) limits the change, N.
        """
        k = np.flatnonzero(np.isfinite(self.bond[:, 1]))
        r = np.arange(len(k))
        values = np.repeat([1.0, -1.0], len(k))
        rows = sp.csr_array((values, (np.tile(r, 2), np.concatenate([k + 1, k]))), shape=(len(k), len(self)))
        return rows, self.bond[k, 1]
