"""Tolerances of the meshes of hydroelastic contact."""

SAME_HALF = 1e-9  # of the smallest half size: half sizes that differ by less count as equal
# Moduli [Pa] and slabs [m] of compliant bodies: so that squares of pressure gradients are numbers.
LEAST_STIFF, MOST_STIFF = 1e-50, 1e50
SAME_HINT = 1e-6  # of a hint: what the smallest one that is allowed is found to
