"""Tolerances of meshes."""

# Vertices of an open surface within this distance [-], relative to its size, may be meant to be
# equal: files with 8 or more digits differ by less. No manufactured part has such a gap.
WELDED_APART = 1e-8
FLAT_TETRAHEDRON = 1e-9  # [-] smallest volume, relative to the longest side cubed, over 6
