"""Closed forms: pairs of spheres, boxes, capsules and half spaces, and points.

No iteration: the error bound of a row is that of rounding alone.
"""
