"""Ties of a limit problem: one-dimensional conditions on forces that pull two blocks together."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from blockstruct.statics import TieTable

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Ties:
    """Stretches of ties with one force ``T`` each, tension positive, non-dimensional.

    ``T = T0 + T'`` with the prestress T0, which belongs to the loads, and ``0 ≤ T' ≤ T_y − T0``. In a bonded bar T'
    changes from stretch to stretch by no more than the bond between them.

    Attributes
    ----------
    columns : (6 F, M) sparse array
        Wrenches of unit forces.
    capacity : (M,) array
        ``T_y − T0``.
    prestress_D, prestress_L : (M,) arrays
        Prestress that acts with the dead load, and with a unit of the variable load.
    bond_rows : (R, M) sparse array
        Changes of the force along bonded bars.
    bond : (R,) array
        Largest change of each.
    force_unit : (M,) array
        Unit of the force of each, N.
    """

    columns: sp.csc_array
    capacity: Array
    prestress_D: Array
    prestress_L: Array
    bond_rows: sp.csr_array
    bond: Array
    force_unit: Array

    @classmethod
    def of(cls, table: TieTable, columns: sp.csc_array, wrench_unit: Array, unit_of_block: Array) -> Self:
        """Ties in units of force of the lighter of their two blocks.

        Parameters
        ----------
        table, columns
            The ties, and their wrenches on the free blocks.
        wrench_unit : (F,) array, N
            Of the free blocks.
        unit_of_block : (B,) array, N
            Of all blocks; infinite of supports.
        """
        if not len(table):
            return cls.none(columns.shape[0])
        unit = unit_of_block[table.ends].min(axis=1)
        # Between two supports any unit does.
        unit = np.where(np.isfinite(unit), unit, wrench_unit.mean())
        rows, bond = table.bond_rows()
        of_row = unit[abs(rows).argmax(axis=1)] if len(bond) else np.zeros(0)
        return cls(
            columns=sp.csc_array(sp.diags_array(np.repeat(1 / wrench_unit, 6)) @ columns @ sp.diags_array(unit)),
            capacity=(table.capacity - table.prestress) / unit,
            prestress_D=table.prestress / unit,
            prestress_L=np.zeros(len(table)),
            bond_rows=sp.csr_array(sp.diags_array(1 / of_row) @ rows @ sp.diags_array(unit)),
            bond=bond / of_row,
            force_unit=unit,
        )

    @classmethod
    def none(cls, n_rows: int) -> Self:
        """No ties, for so many rows of equilibrium."""
        empty = np.zeros(0)
        return cls(sp.csc_array((n_rows, 0)), empty, empty, empty, sp.csr_array((0, 0)), empty, empty)

    def part(self, rows: NDArray[np.bool_], chosen: NDArray[np.bool_]) -> Self:
        """Those of the M stretches that are chosen, whole ties, with so many rows of equilibrium."""
        bonds = abs(self.bond_rows) @ chosen > 0
        return type(self)(
            columns=sp.csc_array(self.columns[rows][:, chosen]),
            capacity=self.capacity[chosen],
            prestress_D=self.prestress_D[chosen],
            prestress_L=self.prestress_L[chosen],
            bond_rows=sp.csr_array(self.bond_rows[bonds][:, chosen]),
            bond=self.bond[bonds],
            force_unit=self.force_unit[chosen],
        )

    @property
    def with_variable_load(self) -> Self:
        """The same with a prestress that grows with the load factor."""
        return replace(self, prestress_D=np.zeros_like(self.prestress_D), prestress_L=self.prestress_D)

    def at(self, alpha: float) -> Self:
        """The same with the prestress at a load factor, whatever the load factor."""
        return replace(self, prestress_D=self.prestress(alpha), prestress_L=np.zeros_like(self.prestress_L))

    def __len__(self) -> int:
        return len(self.capacity)

    def prestress(self, alpha: float) -> Array:
        """Prestress at a load factor, (M,)."""
        return self.prestress_D + (alpha * self.prestress_L if self.prestress_L.any() else 0.0)

    def elongation(self, u: Array) -> Array:
        """Rates of elongation at velocities u, (M,)."""
        return np.asarray(-(self.columns.T @ u))

    def excess(self, beyond: Array, force: Array) -> Array:
        """What forces ``T'`` miss of their conditions, relative to the forces T where these are larger than one."""
        size = np.maximum(force, 1.0)
        change = self.bond_rows @ beyond
        at_bond = np.maximum(abs(self.bond_rows) @ np.abs(force), 1.0)
        return np.concatenate([-beyond / size, (beyond - self.capacity) / size, (np.abs(change) - self.bond) / at_bond])

    def missed_work(self, beyond: Array, elongation: Array) -> Array:
        """Work that ties could do at most on an elongation less what forces ``T'`` do, (M,) or (1,).

        For a tie it is ``(T_y − T0) max(ė, 0) − T' ė``; the largest work of a bonded bar is that of a linear program.
        """
        most = self.capacity * np.maximum(elongation, 0.0)
        done = beyond * elongation
        if not len(self.bond):
            return np.asarray(most - done)
        speed = float(np.abs(elongation).max())
        if not speed > 0:
            return np.asarray(most - done)
        # Loaded here: it is slow to import.
        from scipy.optimize import linprog

        found = linprog(
            -elongation / speed,
            A_ub=sp.vstack([self.bond_rows, -self.bond_rows]).toarray(),
            b_ub=np.concatenate([self.bond, self.bond]),
            bounds=[(0.0, limit) for limit in self.capacity.tolist()],
        )
        largest = np.nan if found.fun is None else -found.fun * speed
        return np.array([largest - done.sum()])
