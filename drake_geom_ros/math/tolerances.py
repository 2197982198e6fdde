"""Tolerances and limits of poses; ``geometry._proximity.tolerances`` has all the others.

They are here because ``math`` imports no other package of this project.
"""

# Limit of | |q| - 1 | [-] of poses from users: generous to float32 senders, and far below the
# effect of a wrong field order (INTERFACE.md, Behaviour). The quaternion is normalised.
QUATERNION_NORM = 1e-3

# Largest coordinate and size [m] of poses, shapes and points from users. The sums over a chain of
# a million poses then stay within float64.
FARTHEST = 2.0**1004

# Limit of max |R R^T - I| [-] of a rotation to working precision. Results guarantee it for their
# unit vectors, and a rotation that differs less from the identity is nearly the identity.
ROTATION = 1e-12

# Limit of max |R R^T - I| [-] of a matrix that is accepted as a rotation, and replaced by the
# nearest one. A naive product of a million such matrices stays below it. Rotations in single
# precision exceed it, except two in a thousand of those about a single axis.
ALMOST_ROTATION = 1e-10

# Limit of max |R R^T - I| [-] of a matrix that is stored unchanged: a carefully computed rotation,
# or one made orthogonal before, deviates by 3 EPS. The distance of such a matrix from the nearest
# rotation is part of the allowance of geometry/_proximity/tolerances.py for poses from users.
ORTHOGONAL = 6.0 * 2.0**-52

# Shortest vector [-] whose direction is trusted (Drake's choice for MakeFromOneVector and
# HalfSpace.MakePose).
DIRECTION_NORM = 1e-10

# Limit of | |q| - 1 | and | |axis| - 1 | [-] of a Quaternion and an AngleAxis (Drake's choice: it
# accepts 1e-6 and rejects 1e-3); rotations made from them are normalised.
UNIT_NORM = 1e-5

# A component [-] of a unit vector below this is 0 within rounding of the rotation it comes from.
ZERO_COMPONENT = 1e-9

# Beyond these a mesh probably has another unit than a part of a robot. A part of 10 mm or more is
# above if millimetres are read as metres; one of up to 1 m is below if it is scaled by 0.001
# although it is in metres.
LARGEST_PART, SMALLEST_PART = 10.0, 1e-3  # [m]


# Allowed difference [m], and [-] of R, of a welded frame from its first pose, as occurs for
# transforms that were written with few digits.
WELDED_STAYS = 1e-6

# Default of the longest time span [-] that contains a first contact.
TIME_TOLERANCE = 1e-6

# Largest distance [m] from a bound of the clearance in an interval to what was computed there.
CLEARANCE_TOLERANCE = 1e-3

# How far [m], or by which sine [-], a pose may be out of the plane of a planar joint.
OUT_OF_PLANE = 1e-6

# How far [m], or by which sine [-], two files may put a joint or a shape that is the same: numbers
# of a file that a program writes are rounded.
SAME_MODEL = 1e-6

# Rounding of the coefficients of a joint's quintic and of the sum of its terms [-], as a part of
# all magnitudes that go into them: five coefficients with factors of up to 15, shifted once.
SPLINE_ROUNDING = 256.0 * 2.0**-52

# The smallest magnitude that a floating-point field of a message may hold, apart from 0. rclpy
# does not convert an integer that is written into such a field: it sends the bits of the integer
# n, which are read as n * 5e-324. This limit notices each integer up to 2e23.
SMALLEST_SENT = 1e-300

# The square of a number that is not smaller has all its digits.
LEAST_SQUARED = 1e-140
