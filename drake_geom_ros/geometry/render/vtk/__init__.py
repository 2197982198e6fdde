"""Renderer that draws with VTK, an optional dependency.

VTK is imported only when this renderer is made.
"""
