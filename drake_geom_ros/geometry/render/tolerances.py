"""Limits of images; those of the arithmetic are in ``geometry/_rendering/tolerances.py``."""

# Smallest visible depth [m] of a camera without a clipping range. Depths are computed, not read
# from a buffer of few bits, so a small value costs no accuracy. It is not 0, so that a camera on a
# surface does not see that surface.
NEAREST_SURFACE = 1e-6
