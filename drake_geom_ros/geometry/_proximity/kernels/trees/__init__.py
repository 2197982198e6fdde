"""Trees of bounding boxes, and walks over two of them.

A walk yields pairs of leaves, the nearest first. The caller defines the content of leaves.
"""
