"""The epsilons by which an answer of FCL is judged; none of them is the engine's."""

# Of the smaller body, what an answer of others may be off by, ten times what the tolerances of
# peers leave at 1 m; and of the extent and of the distance from the origin.
JUDGED_PART, JUDGED_ROUNDING = 1e-3, 1e-12
# Vectors shorter than this [-] have no direction.
NO_DIRECTION = 1e-12
# Of an edge [-], what a cell may be beside the grid of an octree to be one of its.
BESIDE_GRID = 1e-6
# [-] off a half space's normal, beyond which it has no support.
ALIGNED = 1e-7
