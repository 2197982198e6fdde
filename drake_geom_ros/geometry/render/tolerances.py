"""The limits of images; those of the arithmetic stand in ``geometry/_rendering/tolerances.py``."""

# Least depth [m] that a camera without a clipping range sees. Depths are computed, not taken from
# a buffer of few bits, so that it costs no accuracy; it is not 0, for a camera that stands on a
# surface does not see it.
NEAREST_SURFACE = 1e-6
