"""The distances of points to geometries.

Enters: points (m, 3) in World [m], a world, a threshold [m]. Leaves: rows sorted by point and
geometry. Imports ``pairs`` (a point is a ball without radius to some kernels), ``kernels``,
``world`` and ``runtime``.
"""
