"""Pairs with a closed form, and points: spheres, boxes, capsules, half spaces.

In: two shapes that need no iteration, or points and a shape.
Out: rows with the error bound of rounding alone.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``, ``calling``; numpy.
"""
