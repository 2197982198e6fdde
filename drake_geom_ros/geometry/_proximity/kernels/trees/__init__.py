"""Trees of boxes, and walks over two of them.

Enters: packed trees and a pose. Leaves: pairs of leaves, the nearest first. What the leaves are
(triangles, cells, tetrahedra) is the caller's business. Imports ``kernels.vectors``.
"""
