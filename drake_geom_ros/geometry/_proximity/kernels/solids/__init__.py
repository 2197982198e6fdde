"""Pair kernels of solids: bodies bounded by a mesh, with dents and holes.

Trees of boxes over the triangles bound the walks, which return a distance or bounds of the depth.
"""
