"""Shapes: immutable values with pydrake's names; their measures and boxes.

In: sizes [m] or meshes.
Out: shapes, and what each of them is to queries.
May import: ``math``, ``common``, ``geometry``, ``meshes``, ``_proximity``; numpy.
"""
