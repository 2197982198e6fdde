"""The distances of points to geometries.

A point is a ball without radius to some kernels of pairs.

In: points (m, 3) in World [m], a world, a threshold [m].
Out: rows sorted by point and geometry.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``world``, ``filters``, ``near``,
    ``report``, ``pairs``; numpy, numba.
"""
