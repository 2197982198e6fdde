"""What is the same in meshes."""

# Vertices of an open surface that are nearer than this [-], relative to its size, may be meant to
# be one: the last digits of files that round to 8 or more. No part that is made has such a gap.
WELDED_APART = 1e-8
