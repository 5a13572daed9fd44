"""Assemble the arrays that the analysis needs from a model."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp

from blockstruct.arrays import Flags, Index
from blockstruct.model import Model
from blockstruct.statics.contacts import ContactPoints, Division
from blockstruct.statics.equilibrium import equilibrium_matrix
from blockstruct.statics.ties import TieTable
from blockstruct.vocabulary import MOTIONS


@dataclass(frozen=True, slots=True)
class Statics:
    """Contact points, ties and equilibrium matrix shared by all cases.

    Attributes
    ----------
    model : Model
    points : ContactPoints
    A : (6 F, 3 K) sparse array
        Equilibrium matrix of the F free blocks; moments are divided by ``length``.
    ties : TieTable
    tie_columns : (6 F, M) sparse array
        Wrenches of unit forces in the M stretches of ties; moments are divided by ``length``.
    free : (F,) array
        Indices of the blocks that are not fixed.
    held : (F, 6) array
        Whether a support holds each motion of these blocks. The rows of held motions are empty: their equilibrium
        needs no joint.
    length : float
        Characteristic length, m.
    division : Division
        Division of interfaces that crush.
    """

    model: Model
    points: ContactPoints
    A: sp.csc_array
    ties: TieTable
    tie_columns: sp.csc_array
    free: Index
    held: Flags
    length: float
    division: Division

    @classmethod
    def of(cls, model: Model, division: Division | None = None) -> Self:
        """Assemble the statics of a model.

        ``division`` sets how interfaces that crush are divided into cells.
        """
        division = division or Division()
        points = ContactPoints.of(model, division)
        free = np.flatnonzero([not b.fixed for b in model.blocks])
        centroids = np.array([b.centroid for b in model.blocks])
        length = model.characteristic_length
        ties = TieTable.of(model)
        held = np.array([[motion in model.blocks[i].held for motion in MOTIONS] for i in free])
        moves = sp.diags_array((~held).ravel().astype(float))

        def without_held(matrix: sp.csc_array) -> sp.csc_array:
            left = sp.csc_array(moves @ matrix)
            left.eliminate_zeros()
            return left

        return cls(
            model=model,
            points=points,
            A=without_held(equilibrium_matrix(points, centroids, free, length)),
            ties=ties,
            tie_columns=without_held(ties.columns(centroids, free, length)),
            free=free,
            held=held,
            length=length,
            division=division,
        )
