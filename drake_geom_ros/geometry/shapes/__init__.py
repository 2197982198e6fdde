"""Shapes: immutable values with pydrake's names, their measures and bounding boxes.

Sizes are in metres.
"""
