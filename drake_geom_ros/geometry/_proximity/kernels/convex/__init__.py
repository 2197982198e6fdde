"""Pairs of convex bodies whose cores need an iteration.

Enters: two shapes posed to each other. Leaves: distance or depth with its interval, normal and
witness points. Imports ``kernels.cores`` (GJK, EPA, sums) and ``kernels.shapes``.
"""
