"""Hydroelastic representations of shapes: tetrahedra with pressures, rigid surfaces, half spaces.

A shape and a resolution hint [m] make a mesh in the geometry's frame, with the pressure [Pa] at
each vertex of a compliant one.
"""
