"""Geometric tolerances. Angles in radians."""

import math

# Faces of a body, relative to its largest extent

#: Deviation of a face from its mean plane: rounding, and the largest that is allowed.
PLANARITY, LARGEST_DEVIATION = 1e-6, 2e-3
#: Area, relative to the square of the extent, and volume, relative to its cube, that count as zero.
NO_AREA, NO_VOLUME = 1e-12, 1e-9

# Polygons

#: Grid of polygons to intersect, relative to their extent: well above rounding, well below every tolerance.
GRID = 1e-11
#: Largest share of an outline in areas where it crosses itself by rounding.
CROSSING = 1e-3
#: Largest deviation of a corner of a rectangle, relative to the diagonal.
RECTANGLE = 1e-6
#: Area of a piece, relative to the polygon, below which it is not a cell.
NO_CELL = 1e-9
#: Sine of the angle between two edges, modulo a right angle, below which they give the same grid.
SAME_GRID = 0.08
#: Component of a unit normal, across the vertical, below which its plane is level.
LEVEL = 1e-9

# Faces against faces

#: Least cosine of the angle between two normals that count as the same direction.
ALIKE = math.cos(math.radians(45))
#: Largest angle between a polygon and the face on which it lies.
LIES_ON = math.radians(60)
#: Component of a unit normal that counts as zero when the two sides of an interface are ordered.
SIDEWAYS = 1e-3
#: Grid on which edges of pieces meet, relative to rounding.
SNAP = 1e-3

# Bodies against bodies

#: Sine of the angle between two edges below which they are parallel.
PARALLEL = 1e-6
#: Largest number of pairs of edges that are tested as separating axes.
MOST_CROSSINGS = 20_000
#: Number of lines per side of the sampling grids for two bodies that are not convex.
SAMPLES = 12
#: Largest distance from a triangle, relative to its sides, at which a line crosses the triangle.
BESIDE = 1e-9
#: Number of values per chunk. It limits the memory and has no effect on the result.
CHUNK = 2_000_000

# Moved bodies against each other

#: Largest angle between opposite faces in contact: for boxes, whose vertices always have a face within 55 degrees, and
#: for bodies with sharper corners and edges.
FACING, LOOKS = math.radians(60), math.radians(85)
#: Share of such an angle that counts as rounding.
ROUNDED = 1e-9
#: Width of a common area, and length of an edge, relative to the mean block size, that count as zero.
NO_WIDTH, NO_EDGE = 1e-6, 1e-9
#: Depth of a penetration, relative to the width of the common area, beyond which two faces are on opposite sides.
DEEP = 0.5
#: Sine of the angle between two edges below which their crossing defines no normal.
NO_CROSSING = 0.05
#: Cosine of the angle between the outward normals of two parts of a surface above which their common edge is flat.
FLAT = 1 - 1e-9
