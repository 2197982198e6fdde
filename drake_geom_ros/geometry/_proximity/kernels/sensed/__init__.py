"""Pair kernels of sensed maps: unions of equal boxes or balls, in a tree over their centres.

One compiled call packs centres and a size. The walks call the kernel of a single cell for near
cells only. They return the distance, or an interval of the depth.
"""
