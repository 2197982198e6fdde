"""Convex pairs without a closed form, and hulls: GJK, EPA, Newton's method on normals.

In: two cores, as support functions or as a sum.
Out: certified bounds of their distance or depth, and where both are attained.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``, ``calling``,
    ``closed_forms``; numpy.
"""
