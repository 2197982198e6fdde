"""Meshes: reading them, their surfaces and convex hulls, and which of them are solids.

In: files, bytes or arrays.
Out: vertices and faces [m], refusals that name file and reason.
May import: ``math``, ``common``, ``geometry``, ``_proximity``; numpy.
"""
