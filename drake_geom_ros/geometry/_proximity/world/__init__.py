"""Where everything is: the one place that holds poses.

In: tables of frames and geometries, poses X_PF.
Out: X_WF, X_WG, the bounds of each body, how far it moved, what rounding did.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``; numpy, numba.
"""
