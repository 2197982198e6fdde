"""How kernels are called: signatures, addresses, rows of results; pairs of extreme sizes.

In: addresses of kernels, shapes and poses.
Out: rows of results; pairs of extreme sizes are brought to about 1 m.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``; numpy, numba.
"""
