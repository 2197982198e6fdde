"""Narrow phase: distance or depth of each pair of the neighbour list, with its error bound.

``narrow_phase`` is the loop, ``error_bounds`` the bounds that an accuracy level promises, and
``budgeted`` the same loop in blocks within a time budget. The gap of a level and the cutoff are in
[m].
"""
