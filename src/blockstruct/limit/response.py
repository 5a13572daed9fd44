"""Describe the states of the response to a record."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from blockstruct.arrays import Array, Flags, Index
from blockstruct.model import Model
from blockstruct.statics.moved import Placement

#: A block has fallen once its centroid is lower by this share of the edge of a cube of its volume, or once its vertical
#: axis is tilted by this angle, degrees.
LOWER, TILTED = 0.5, 45.0


@dataclass(frozen=True, slots=True)
class RecordState:
    """Blocks in motion at one time of a record, in SI units, relative to the ground.

    Attributes
    ----------
    time : float
        s.
    displacement, rotation : (B, 3) arrays
        Displacements of the centroids, m, and rotation vectors, rad, from the positions in the model.
    velocity, angular_velocity : (B, 3) arrays
        Of the centre of mass of each block in the step to this state, m/s and rad/s.
    peak_displacement : (B,) array
        Largest displacement of each centroid so far, m, also between states.
    ground_acceleration : (3,) array
        m/s².
    base_reaction : (3,) array
        Force of the supports on the structure, N: the mean since the state before.
    acceleration : float
        Largest acceleration of any point of a block in the step to this state, relative to the ground, m/s²: an upper
        bound.
    kinetic_energy : float
        J.
    dead_work, record_work, dissipated_energy : float
        Work of the dead load, work of the ground acceleration on the masses, and energy that contacts and ties have
        taken up, since the beginning, J.
    time_step, last_step : float
        Length of the steps of the response, and of the step to this state, which may end at an impact, s.
    steps, iterations : int
        Numbers of steps, and of linear systems, since the beginning.
    finds_contacts : bool
        Whether contacts are found anew from this state. A response continues from such a state alone.
    tie_force : (M,) array
        Of each tie in the step to this state, N.
    tie_elongation, peak_tie_elongation : (M,) arrays
        Of each tie beyond its length in the model, m, and the largest so far, also between states.
    crushed_depth : (C,) array
        Depth that each cell of a joint that crushes has lost, m.
    crushed_slope : (C, 3) array
        Slope of its crushed surface, in the axes of its block.
    largest_crushed_depth : float
        Of all joints, m, also of cells that are crushed in part; zero without joints that crush.
    minus_of_contact, plus_of_contact : (P,) arrays
        Indices of the two blocks at each contact point with a force.
    point_of_contact, force_of_contact : (P, 3) arrays
        Position, m, and force on the plus block, N.
    """

    time: float
    displacement: Array
    rotation: Array
    velocity: Array
    angular_velocity: Array
    peak_displacement: Array
    ground_acceleration: Array
    base_reaction: Array
    acceleration: float
    kinetic_energy: float
    dead_work: float
    record_work: float
    dissipated_energy: float
    time_step: float
    last_step: float
    steps: int
    iterations: int
    finds_contacts: bool
    tie_force: Array
    tie_elongation: Array
    peak_tie_elongation: Array
    crushed_depth: Array
    crushed_slope: Array
    largest_crushed_depth: float
    minus_of_contact: Index
    plus_of_contact: Index
    point_of_contact: Array
    force_of_contact: Array


@dataclass(frozen=True, slots=True)
class Fall:
    """Whether blocks have fallen.

    Attributes
    ----------
    height : (B,) array, m
        Height below which the centroid of each block has fallen; minus infinity for supports.
    """

    height: Array

    @classmethod
    def of(cls, model: Model) -> Self:
        """Return the heights of a model."""
        centre = np.array([b.centroid[2] for b in model.blocks])
        edge = np.cbrt([b.volume for b in model.blocks])
        return cls(np.where([b.fixed for b in model.blocks], -np.inf, centre - LOWER * edge))

    def at(self, placement: Placement) -> Flags:
        """Return whether each block (B,) has fallen at a placement; supports never have."""
        tilted = (placement.rotation[:, 2, 2] < np.cos(np.radians(TILTED))) & (self.height > -np.inf)
        return np.asarray((placement.position[:, 2] < self.height) | tilted)
