"""Tolerances of contact surfaces."""

from drake_geom_ros.geometry._proximity.tolerances import EPS

ROUNDING = 8.0 * EPS  # of the sizes of both bodies: how wrong a height above a plane may be

# Of the lengths of two pressure gradients: those that differ by less are the same. Rotations round
# by some 1e-16 of them, and what is left points nowhere.
SAME_GRADIENT = 1e-12
# Of the cosine at which faces are left out: one that has it is, however it is rounded. Faces where
# two pressures are equal have it, that grow as much as each other, 45 degrees apart.
SAME_COSINE = 1e-12
# Of the rounding of heights: what is deeper in a body is in it, whatever surface has been lost in
# rounding.
WITHIN = 1e4
