"""The epsilons of the truth and of the measurement; none of them is the engine's."""

# Spacing of float64 at 1 [-].
EPS = 2.0**-52

# The truth.

# Vertices this near [-] to the farthest along a direction, relative to the body's size, are all
# asked in full digits which one is the farthest: a hundred times the rounding of their heights.
TIE = 1e-13
# Relative to the pair's size: how much better a direction the search may overlook until polishing
# finds it. The angle to a smooth maximum is about its square root, which NEARBY must contain;
# faces of hulls of a thousand edges differ by more.
GAP = 1e-9
NEARBY = 1e-3  # [rad]
# Relative to the pair's size: where more faces than one round refines are this near to the best,
# they are equal by symmetry, and polishing any of them gives the answer.
TIED = 1e-5
# [rad] about the direction that shrinking caps found, which is the maximum's where bodies are
# apart: caps are coarser than faces of the hull.
CLIMBED = 0.012
# [rad] about a direction that is the best by construction, but for rounding.
KNOWN = 1e-6
# Step [rad] of Newton's method after which the next would be its square, below rounding.
LAST_STEP = 1e-10
# Least curvature [-], relative to the pair's size, that a step of Newton's method divides by.
LEAST_CURVATURE = 1e-9
# Sine [-] of the angle of two edges below which their circles cross nowhere that matters.
PARALLEL = 1e-9
# Relative to the pair's size: candidates this near to the best are compared in full digits.
EQUAL = 1e-11
# What a round of polishing must gain [-], relative to the pair's size, to be followed by another:
# less than the rounding of the result.
GAIN = 1e-17
# Vectors shorter than this [-] have no direction.
NO_DIRECTION = 1e-12

# Solid meshes.

# Triangles this near [-] to the nearest, relative to the body's size, are all asked in full digits
# which one is: a million times the rounding of their distances.
NEAREST = 1e-9
# [m] that two bodies may still overlap after a move that leads them apart: the rounding of poses.
FREE = 1e-12
# [m] from a surface within which the way out of it has no direction left.
SIDE = 1e-6
# [m] by which the distance of a pair may differ from how it was placed: rounding, for in a dent,
# where another wall is nearer, it differs by far more.
AS_PLACED = 1e-9

# The measurement.

# Relative to the pair's size: the truth is rounded once, and taken for rotations that are
# orthogonal but for rounding.
TRUTH_ROUNDING = 2.0 * EPS
# Relative to the pair's size: below this an error is rounding, and a bound need not follow it.
ROUNDING = 16.0 * EPS
# [m] deep, at most: penetration is about what is deeper, for touching is not penetrating.
TOUCHING = 1e-9
# [m] apart, at least, of pairs that no library finds hard.
EASY = 1e-3
# The tolerances [m] that peers are given besides their own settings, where they take one.
PEER_TOLERANCES = {'Coal': (1e-3, 1e-9), 'MuJoCo': (1e-3, 1e-9)}
# What is promised of an answer, and how peers are judged.

# Of the pair's extent and of the distance from the origin: what positions may be off by.
POSITIONS = 64.0 * EPS
# [-] that a unit vector's length may be off 1.
UNIT = 1e-12
# Of the extent: what an iteration may leave in a normal of hulls next to touching, for nothing but
# the distance stops it.
COARSE_NORMALS = 1e-4
# Of the extent: a certified bound above this is a failure, whatever the level.
VERY_WIDE = 1e-5
# Of the extent: as deep as this counts as touching, and is not reported as penetration.
AS_TOUCHING = 2e-14
# [-] that the normal of a peer may be off unit length, and that of a solid off those expected.
JUDGED_UNIT, JUDGED_TURN = 1e-6, 1e-2
# Of the pair's extent: what the search over directions may be off by.
SEARCH = 2e-12

# The hunt.

# [-] that R R^T may be off the identity: what is accepted, with a margin for motions, and what
# rounding leaves of a rotation at most.
ACCEPTED_SKEW, ROUNDED_SKEW = 3e-13, 1e-14
# [-] that each number of a rotation is changed by, at most, for one that is accepted still.
ENTRY_SKEW = 1e-13
# Of the extent: gaps that pairs are slid to, and parts of it in which a rational offset counts.
HUNTED_GAPS = (0.0, 1e-16, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1e-2)
RATIONAL_STEPS = (0.001, 0.002, 0.01)
# [m] that sizes stay between while they change.
HUNTED_LENGTHS = 1e-9, 1e5
# One minus the cosine [-] of two normals that cannot both be unique.
TURNED = 0.02
# [rad] of the last cap about a direction, within which the gap is flat to rounding.
NARROWEST = 1e-9
# Square of the sine [-] of a centre line that is along an axis, but for rounding.
ON_AXIS = 1e-24
# Cosine [-] of directions of which one is enough to start from.
ALIKE = 0.999

# Gaps [m] of the configurations that are close.
NEAR, SHALLOW, DEEP = 2e-3, -2e-3, -2e-2
