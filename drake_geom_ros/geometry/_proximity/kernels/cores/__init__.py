"""Iterations on convex cores: GJK, EPA and Newton's method on normals.

Cores are support functions or Minkowski sums. The result is certified bounds of the distance or
depth, and the points that attain it.
"""
