"""The neighbour list: which pairs are near enough to be looked at.

Grids for many bodies, all pairs for few; skins let a list stand for many cycles.

In: a world, the filters, a cutoff [m].
Out: pairs (k, 2) with i < j, less the filtered, each with the slot of its last answer.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``world``, ``filters``; numpy,
    numba, llvmlite.
"""
