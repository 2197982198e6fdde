"""What shapes are to hydroelastic contact: meshes of tetrahedra, or surfaces, and pressures.

In: shapes, and how fine to cut them.
Out: bodies: meshes in the geometry's frame, the pressure at their vertices; half spaces.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``shapes``; numpy.
"""
