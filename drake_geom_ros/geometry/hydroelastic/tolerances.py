"""Tolerances of the meshes of hydroelastic contact."""

SAME_HALF = 1e-9  # of the least half size: what half sizes may differ by, and cells must not
