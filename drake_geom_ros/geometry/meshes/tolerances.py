"""What is the same in meshes."""

# Vertices of an open surface that are nearer than this [-], relative to its size, may be meant to
# be one: the last digits of files that round to 8 or more. No part that is made has such a gap.
WELDED_APART = 1e-8
FLAT_TETRAHEDRON = 1e-9  # of its longest side cubed, over 6: what is less is no volume [-]
