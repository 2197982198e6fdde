"""Tolerances of meshes, of meshes for hydroelastic contact, and of images."""

# Vertices of an open surface within this distance [-], relative to its size, may be meant to be
# equal: files with 8 or more digits differ by less. No manufactured part has such a gap.
WELDED_APART = 1e-8
FLAT_TETRAHEDRON = 1e-9  # [-] smallest volume, relative to the longest side cubed, over 6

SAME_HALF = 1e-9  # of the smallest half size: half sizes that differ by less count as equal
# Moduli [Pa] and slabs [m] of compliant bodies: so that squares of pressure gradients are numbers.
LEAST_STIFF, MOST_STIFF = 1e-50, 1e50
SAME_HINT = 1e-6  # of a hint: what the smallest one that is allowed is found to

# Smallest visible depth [m] of a camera without a clipping range. Depths are computed, not read
# from a buffer of few bits, so a small value costs no accuracy. It is not 0, so that a camera on a
# surface does not see that surface. Tolerances of drawing: ``_rendering/tolerances.py``.
NEAREST_SURFACE = 1e-6

# Normals of two faces that may lie face to face are opposite to this [-]; the heights of their
# corners over the other's plane decide.
ALMOST_OPPOSITE = 1e-6

# A normal in a binary STL file has length 1 to this [-], as exporters write it.
UNIT_NORMAL = 1e-2
