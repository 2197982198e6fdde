"""Tolerances for judging answers of FCL, none of which is the engine's."""

# Tolerance of a peer's answer relative to the smaller body, ten times the error that tolerances
# of peers cause at 1 m; and relative to the extent plus the distance from the origin.
JUDGED_PART, JUDGED_ROUNDING = 1e-3, 1e-12
# Vectors shorter than this [-] have no direction.
NO_DIRECTION = 1e-12
# Tolerated offset [-] of a cell from the grid of an octree, relative to its edge.
BESIDE_GRID = 1e-6
# [-] deviation from a half space's normal beyond which the support value is infinite.
ALIGNED = 1e-7
