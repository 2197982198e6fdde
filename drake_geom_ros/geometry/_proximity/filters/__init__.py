"""Collision filters: the pairs that may be reported, and the reasons for those that may not.

The log holds the declarations in order; the matrix, one bit a pair, follows from the log, the
groups and the anchored geometries.
"""
