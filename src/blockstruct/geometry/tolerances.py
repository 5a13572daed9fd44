"""What geometry takes for rounding, for flat and for nothing: every limit of the room, angles in radians."""

import math

# Faces of a body, relative to its largest extent

#: Deviation of a face from its mean plane that is rounding, and beyond which it is not a face.
PLANARITY, LARGEST_DEVIATION = 1e-6, 2e-3
#: Area, relative to the square of the extent, and volume, relative to its cube, that count as zero.
NO_AREA, NO_VOLUME = 1e-12, 1e-9

# Polygons

#: Grid of polygons to intersect, relative to their extent: well above rounding, well below every tolerance.
GRID = 1e-11
#: Share of the area of an outline that may lie where it crosses itself by rounding.
CROSSING = 1e-3
#: Deviation of a corner, relative to the diagonal, that still makes a rectangle.
RECTANGLE = 1e-6
#: Share of the area of a polygon below which a piece of it is not a cell.
NO_CELL = 1e-9
#: Sine of the angle between two edges, or one and the normal of the other, below which grids along both are the same.
SAME_GRID = 0.08
#: Component of a unit normal, across the vertical, below which its plane is level.
LEVEL = 1e-9

# Faces against faces

#: Cosine of the angle between normals up to which two faces look the same way at a body between them.
ALIKE = math.cos(math.radians(45))
#: Angle beyond which a polygon does not lie on a face, however close.
LIES_ON = math.radians(60)
#: Component of a unit normal below which it does not tell a face that looks one way from one that looks the other.
SIDEWAYS = 1e-3
#: Grid on which edges of pieces meet, as a part of what is rounding.
SNAP = 1e-3

# Bodies against bodies

#: Sine of the angle between two edges below which they are parallel.
PARALLEL = 1e-6
#: Pairs of edges that are tried for an axis between two bodies.
MOST_CROSSINGS = 20_000
#: Lines, per side, of the grids along which two bodies that are not convex are compared.
SAMPLES = 12
#: Distance from a triangle, relative to its sides, at which a line still crosses it.
BESIDE = 1e-9
#: Numbers worked on at once: bounds the memory, not the result.
CHUNK = 2_000_000

# Moved bodies against each other

#: Angle between faces beyond which they do not face each other. A vertex of a box always has a face within 55 degrees;
#: those of bodies with sharper corners and edges look as far aside as these are sharp, and so far at most.
FACING, LOOKS = math.radians(60), math.radians(85)
#: Share of such an angle that is rounding: two edges of boxes ask for what every face has.
ROUNDED = 1e-9
#: Width, relative to the mean block size, of what two faces share that is none; and edges shorter than it.
NO_WIDTH, NO_EDGE = 1e-6, 1e-9
#: Depth of a penetration, relative to the width of what is shared, beyond which two faces belong to opposite sides.
DEEP = 0.5
#: Sine of the angle between two edges below which their crossing tells no normal.
NO_CROSSING = 0.05
#: Cosine of the angle between the outward normals of two parts of a surface above which their common edge is flat.
FLAT = 1 - 1e-9
