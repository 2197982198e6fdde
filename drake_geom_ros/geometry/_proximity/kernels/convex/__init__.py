"""Pairs of convex bodies whose cores need an iteration.

In: two convex shapes posed to each other.
Out: distance or depth with its interval, normal and witness points.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``, ``calling``,
    ``closed_forms``, ``cores``, ``revolution``; numpy.
"""
