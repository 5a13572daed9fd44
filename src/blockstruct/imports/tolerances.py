"""What the import takes for rounding, for one face and for too much: every limit of the room."""

# Corners and outlines

#: Distance, relative to the median edge of a solid, below which two corners are one.
WELD = 1e-4
#: Distance, relative to the size of an outline, below which its ends meet, and an edge runs back over another.
OUTLINE = 1e-6

# Planes of faces

#: Deviation from a plane, relative to the size of the body, that is rounding.
EXACT = 1e-7
#: Deviation from a plane, relative to the size of the body, that a face given as one polygon may have.
POLYGON = 5e-3
#: Deviation from a plane, relative to the size of the body, within which neighbouring faces are one.
MERGE = 1e-4
#: Depth, relative to the size of the body, to which an edge passes through a face that it only touches.
TOUCHING = 1e-6
#: Cosine of the angle between two faces, either way round, that can be one.
ONE_PLANE = 0.99
#: Faces that a body has at least: fewer without area are a sliver of a mesh, and not what is left of a body.
LEAST_FACES = 4
#: Area, relative to the square of the longest edge, below which a face has none.
NO_AREA = 1e-5
#: Sine of the angle between planes below which they do not tell where their common point lies.
SHALLOW = 0.02
#: Rounds of moving vertices into planes fitted anew; one is enough where three faces meet at every vertex.
ROUNDS = 50

# Drawings

#: Component of the normal of a drawn outline along the axis of the drawing plane from which on it lies in the plane.
IN_DRAWING_PLANE = 1 - 1e-9
#: Difference, relative, of two units of length that are the same.
SAME_UNIT = 1e-9
#: Levels of blocks inside blocks of a drawing that are followed.
DEPTH = 16

# Structures

#: Height above the lowest point, relative to the mean block size, up to which a block belongs to the lowest ones.
LOWEST = 1e-2
#: The same of blocks that are mentioned because they nearly do.
NEARLY_LOWEST = 0.1
#: Largest extent, least height and typical edge, m, between which masonry is found; a wrong unit leads out of them.
EXTENT, LEAST_HEIGHT, EDGE = (0.3, 300.0), 0.2, (0.02, 5.0)
#: Faces of a file, and of one body, beyond which there is a scan to be simplified and no model of rigid blocks.
MOST_FACES, MOST_FACES_OF_BODY = 500_000, 20_000
#: Pairs of an edge and a face judged at once: bounds the memory, not the result.
CHUNK = 200_000
