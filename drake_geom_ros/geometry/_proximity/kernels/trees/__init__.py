"""Trees of boxes, and walks over two of them.

In: packed trees and a pose.
Out: pairs of leaves, the nearest first; what leaves are is the caller's business.
May import: ``math``, ``_proximity``, ``runtime``, ``kernels``, ``shapes``; numpy.
"""
