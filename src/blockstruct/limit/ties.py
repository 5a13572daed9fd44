"""Define the ties of a limit problem and the limits of their forces."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Array, Flags
from blockstruct.statics.ties import TieTable


@dataclass(frozen=True, slots=True)
class Ties:
    """Stretches of ties with one force ``T`` each, non-dimensional.

    Tension is positive. ``T = T0 + T'`` with ``0 ≤ T' ≤ T_y − T0``. The prestress T0 belongs to the loads. In a bonded
    bar the bond limits the change of T' from one stretch to the next.

    Attributes
    ----------
    columns : (6 F, M) sparse array
        Wrenches of unit forces.
    capacity : (M,) array
        ``T_y − T0``.
    prestress_D, prestress_L : (M,) arrays
        Prestress that acts with the dead load, and prestress per unit of the variable load.
    bond_rows : (R, M) sparse array
        Matrix from tie forces to force changes along bonded bars.
    bond : (R,) array
        Largest magnitude of each force change.
    force_unit : (M,) array
        Unit of force of each stretch, N.
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
        """Return the ties in the unit of force of the lighter of two blocks.

        Parameters
        ----------
        table, columns
            The ties, and their wrenches on the free blocks.
        wrench_unit : (F,) array, N
            Units of the wrenches of the free blocks.
        unit_of_block : (B,) array, N
            Units of all blocks; infinite for supports.
        """
        if not len(table):
            return cls.none(columns.shape[0])
        unit = unit_of_block[table.ends].min(axis=1)
        # Any unit is correct between two supports.
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
        """Return an empty set of ties for ``n_rows`` equilibrium rows."""
        empty = np.zeros(0)
        return cls(sp.csc_array((n_rows, 0)), empty, empty, empty, sp.csr_array((0, 0)), empty, empty)

    def part(self, rows: Flags, chosen: Flags) -> Self:
        """Return the chosen stretches (M,) and equilibrium rows (6 F,).

        The chosen stretches must form whole ties.
        """
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
        """The same ties with a prestress that grows with the load factor."""
        return replace(self, prestress_D=np.zeros_like(self.prestress_D), prestress_L=self.prestress_D)

    def at(self, alpha: float) -> Self:
        """Return the same ties with the prestress fixed at a load factor."""
        return replace(self, prestress_D=self.prestress(alpha), prestress_L=np.zeros_like(self.prestress_L))

    def __len__(self) -> int:
        return len(self.capacity)

    def prestress(self, alpha: float) -> Array:
        """Return the prestress (M,) at a load factor."""
        return self.prestress_D + (alpha * self.prestress_L if self.prestress_L.any() else 0.0)

    def elongation(self, u: Array) -> Array:
        """Return the rates of elongation (M,) at velocities u."""
        return np.asarray(-(self.columns.T @ u))

    def excess(self, beyond: Array, force: Array) -> Array:
        """Return the excess of forces ``T'`` over their limits.

        The excess is negative inside. It is relative to the forces T if these are larger than one.
        """
        size = np.maximum(force, 1.0)
        change = self.bond_rows @ beyond
        at_bond = np.maximum(abs(self.bond_rows) @ np.abs(force), 1.0)
        return np.concatenate([-beyond / size, (beyond - self.capacity) / size, (np.abs(change) - self.bond) / at_bond])

    def missed_work(self, beyond: Array, elongation: Array) -> Array:
        """Return the largest possible work of ties less the actual work.

        The actual work is the work of forces ``T'`` at rates of elongation ė. Without bonded bars the shape is (M,),
        and each tie has ``(T_y − T0) max(ė, 0) − T' ė``. With bonded bars the shape is (1,), and a linear program gives
        the largest work.
        """
        most = self.capacity * np.maximum(elongation, 0.0)
        done = beyond * elongation
        if not len(self.bond):
            return np.asarray(most - done)
        speed = float(np.abs(elongation).max())
        if not speed > 0:
            return np.asarray(most - done)
        # Import here because scipy.optimize is slow to import.
        from scipy.optimize import linprog

        found = linprog(
            -elongation / speed,
            A_ub=sp.vstack([self.bond_rows, -self.bond_rows]).toarray(),
            b_ub=np.concatenate([self.bond, self.bond]),
            bounds=[(0.0, limit) for limit in self.capacity.tolist()],
        )
        largest = np.nan if found.fun is None else -found.fun * speed
        return np.array([largest - done.sum()])
