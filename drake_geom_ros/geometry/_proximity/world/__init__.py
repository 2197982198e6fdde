"""Where everything is: the one place that holds poses.

Enters: the tables of frames and geometries, poses X_PF. Leaves: X_WF, X_WG, the bounds of each
body, by how much it has moved, and how far rounding may have put it. Imports ``kernels.shapes``
for bounds, and ``runtime``.
"""
