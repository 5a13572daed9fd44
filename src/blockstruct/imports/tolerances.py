"""Tolerances and limits of imports."""

import sys

# Corners and outlines

#: Distance of two corners, relative to the median edge of a solid, below which they are joined. Largest deviation of
#: neighbouring faces that are merged from a plane, relative to the size of the body.
WELD = 1e-4

# Planes of faces

#: Deviation from a plane, relative to the size of the body, that counts as rounding.
EXACT = 1e-7
#: Largest deviation of a polygon from a plane, relative to the size of the body.
POLYGON = 5e-3
#: Smallest number of faces of a body. Fewer faces without area are a sliver of a mesh.
LEAST_FACES = 4
#: Sine of the angle between planes below which their common point is undefined.
SHALLOW = 0.02

# Drawings

#: Largest depth of nested blocks in a drawing.
DEPTH = 16

# Structures

#: Range of the extent, smallest height, and range of the typical edge of masonry, m: a check of the unit.
EXTENT, LEAST_HEIGHT, EDGE = (0.3, 300.0), 0.2, (0.02, 5.0)
#: Distance from the origin, m, from which on double precision rounds coordinates by more than the weld of a long edge.
FARTHEST = WELD * EDGE[1] / sys.float_info.epsilon
#: Largest number of faces of a file, and of one body: larger numbers come from scans, which must be simplified.
MOST_FACES, MOST_FACES_OF_BODY = 500_000, 20_000
#: Bytes of a file: 1 kB for each face, four times what text STL needs.
MOST_BYTES = 1000 * MOST_FACES
