"""Maps that sensors made, unions of equal boxes or balls: a tree over their centres.

In: centres and a size, packed in one compiled call; the pose of another body or map; the address
    of the kernel that answers for one cell.
Out: the distance, or an interval of the depth, by walks that call that kernel for near cells.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``, ``calling``, ``trees``;
    numpy, numba.
"""
