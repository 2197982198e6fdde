"""Depths of bodies of revolution, where a ring of directions is almost as good as the best.

In: cores that are round about an axis, or almost.
Out: the least width of their overlap, where rings of directions are as good.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``, ``calling``,
    ``closed_forms``, ``cores``; numpy.
"""
