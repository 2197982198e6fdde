"""Meshes: reading them, their surfaces and convex hulls, and which of them are solids.

Enters: files, bytes or arrays. Leaves: vertices and faces [m], refusals that name file and reason.
Imports ``errors`` and ``checks`` only, and trimesh in ``_library``.
"""
