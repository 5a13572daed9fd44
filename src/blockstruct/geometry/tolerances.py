"""Geometric tolerances. Angles in radians."""

import math

from blockstruct.arrays import NEGLIGIBLE

# Whatever the shape

#: Area, relative to the square of the extent, that counts as zero.
NO_AREA = NEGLIGIBLE**2

# Faces of a body, relative to its largest extent

#: Largest deviation of a face from its mean plane.
LARGEST_DEVIATION = 2e-3

# Polygons

#: Grid of polygons to intersect, relative to their extent: well above rounding, well below every tolerance.
GRID = 1e-11
#: Sine of the angle between two edges, modulo a right angle, below which they give the same grid.
SAME_GRID = 0.08

# Faces against faces

#: Least cosine of the angle between two faces that count as parallel, in either orientation.
PARALLEL = 0.99
#: Least cosine of the angle between two normals that count as the same direction.
ALIKE = math.cos(math.radians(45))
#: Largest angle between a polygon and the face on which it lies.
LIES_ON = math.radians(60)

# Bodies against bodies

#: Number of lines per side of the sampling grids for two bodies that are not convex.
SAMPLES = 12

# Moved bodies against each other

#: Largest angle between opposite faces in contact: for boxes, whose vertices always have a face within 55 degrees, and
#: for bodies with sharper corners and edges.
FACING, LOOKS = math.radians(60), math.radians(85)
#: Depth of a penetration, relative to the width of the common area and to the extent of either body, beyond which two
#: faces are on opposite sides.
DEEP = 0.5
#: Sine of the angle between two edges below which their crossing defines no normal.
NO_CROSSING = 0.05
