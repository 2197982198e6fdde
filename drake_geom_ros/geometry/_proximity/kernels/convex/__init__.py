"""Pair kernels of convex shapes whose cores need an iteration.

Each returns the distance or depth with its certified interval, the normal and the witness points.
"""
