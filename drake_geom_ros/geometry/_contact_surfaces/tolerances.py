"""Tolerances of contact surfaces."""

# Of the lengths of two pressure gradients: those that differ by less are the same. Rotations round
# by some 1e-16 of them, and what is left points nowhere.
SAME_GRADIENT = 1e-12
