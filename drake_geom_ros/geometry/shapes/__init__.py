"""Shapes: immutable values with pydrake's names; their measures and boxes.

Enters: sizes [m] or meshes. Leaves: shapes, and what each of them is to queries. Imports
``meshes``.
"""
