"""Geometry of polyhedra and plane polygons as float arrays, independent of units and of the model.

>>> import numpy as np
>>> vertices, faces = box((0, 0, 0), (2, 1, 1))
>>> shape = polyhedron(vertices, faces, name="unit")
>>> float(shape.volume), shape.centroid.tolist()
(2.0, [1.0, 0.5, 0.5])
"""

from blockstruct.geometry.cells import is_rectangle, polygon_cells
from blockstruct.geometry.coplanar import (
    FacePair,
    coplanar_face_pairs,
    crossed_faces,
    joined_pairs,
    parts_not_hidden,
    without_far_sides,
)
from blockstruct.geometry.faces import areas_on_bodies
from blockstruct.geometry.neighbours import box_pairs, connected, separations, unsupported
from blockstruct.geometry.overlap import bodies_at, overlapping_pairs
from blockstruct.geometry.plan import PlanFaces, clipped, fan, products
from blockstruct.geometry.polygon import (
    common_areas,
    mean_distances,
    next_corners,
    perimeter,
    plane_axes,
    polygon_area,
    tributary_areas,
)
from blockstruct.geometry.polyhedron import BOX_FACES, Polyhedron, box, lofted, polyhedron
from blockstruct.geometry.screws import rotation_matrices, rotation_vectors, screw_motions
from blockstruct.geometry.touching import MovingBodies, Touching
from blockstruct.geometry.triangles import stretches_inside, triangulated

__all__ = [
    # polyhedra
    "BOX_FACES",
    "Polyhedron",
    "bodies_at",
    "box",
    "lofted",
    "overlapping_pairs",
    "polyhedron",
    "stretches_inside",
    # polygons
    "common_areas",
    "is_rectangle",
    "next_corners",
    "mean_distances",
    "perimeter",
    "plane_axes",
    "polygon_area",
    "polygon_cells",
    "triangulated",
    "tributary_areas",
    # faces in plan
    "PlanFaces",
    "clipped",
    "fan",
    "products",
    # contacts
    "FacePair",
    "areas_on_bodies",
    "coplanar_face_pairs",
    "crossed_faces",
    "joined_pairs",
    "parts_not_hidden",
    "without_far_sides",
    # bodies that move
    "MovingBodies",
    "Touching",
    "rotation_matrices",
    "rotation_vectors",
    "screw_motions",
    # neighbours
    "box_pairs",
    "connected",
    "separations",
    "unsupported",
]
