"""PRIVATE: bodies with pressures in, contact surfaces out; arrays only. Compiled on first use.

In: packed meshes, poses, pairs of bodies.
Out: the polygons where pressures are equal, with their integrals, by pair; which pairs overlap
    without, because one is deep within the other.
May import: ``math``, ``_proximity``; numpy, numba.
"""
