"""Geometry of polyhedra and plane polygons as float arrays, independent of units and of the model.

Each module is imported by its own name.

>>> from blockstruct.geometry.polyhedron import box, polyhedron
>>> vertices, faces = box((0, 0, 0), (2, 1, 1))
>>> shape = polyhedron(vertices, faces, name="unit")
>>> float(shape.volume), shape.centroid.tolist()
(2.0, [1.0, 0.5, 0.5])
"""
