"""Signed distances of points to geometries.

To some pair kernels a point is a ball of radius zero. Takes points (m, 3) in World [m] and a
threshold [m]; rows are sorted by point and geometry.
"""
