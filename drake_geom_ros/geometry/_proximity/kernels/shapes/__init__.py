"""One shape alone: its bounds, support points, features and packed numbers.

In: a kind and the packed numbers of a shape.
Out: radii, support points, inner balls, the feature at a point; nothing knows a second body.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``; numpy, numba, llvmlite.
"""
