"""Mesh files and arrays: parsing, surfaces, convex hulls, and checks for closed solids.

Vertices are in metres. An error names the file and the reason.
"""
