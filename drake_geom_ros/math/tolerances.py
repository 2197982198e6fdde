"""The epsilons and limits of poses; ``geometry._proximity.tolerances`` holds all the others.

They are here because ``math`` imports nothing of ours.
"""

# | |q| - 1 | may reach this [-] in a pose that is taken in: generous to float32 senders, far
# below what a wrong field order produces (INTERFACE.md, Behaviour). The quaternion is normalised.
QUATERNION_NORM = 1e-3

# A pose, a shape or a point that a scene takes in may have no coordinate and no size beyond this
# [m]: the sums over a chain of poses, a million of them, then stay within float64.
FARTHEST = 2.0**1004

# max |R R^T - I| [-] of a rotation to working precision: what the results promise of their unit
# vectors, and how far from the identity a rotation may be that is nearly it.
ROTATION = 1e-12

# max |R R^T - I| [-] of a matrix that is taken as a rotation: a product of a million of them, made
# without a care, stays below it; of a thousand matrices in single precision that turn about one
# axis two are, of others none. The rotation nearest to it is what is taken.
ALMOST_ROTATION = 1e-10

# max |R R^T - I| [-] up to which a matrix is kept as it is: a rotation that was computed with
# care, or made orthogonal before, is off by 3 EPS. How far such a matrix may be from the nearest
# rotation is part of what geometry/_proximity/tolerances.py allows for one that is taken in.
ORTHOGONAL = 6.0 * 2.0**-52

# Shortest vector [-] whose direction is trusted (Drake's choice for MakeFromOneVector and
# HalfSpace.MakePose).
DIRECTION_NORM = 1e-10

# | |q| - 1 | and | |axis| - 1 | may reach this [-] in a Quaternion and an AngleAxis (Drake's
# choice: it takes 1e-6 and refuses 1e-3); what is made of them is normalised.
UNIT_NORM = 1e-5

# Beyond these a mesh is more likely in another unit than a part of a robot: one of 10 mm and more
# whose millimetres are read as metres is above, one of up to 1 m that is scaled by 0.001 although
# it is in metres is below.
LARGEST_PART, SMALLEST_PART = 10.0, 1e-3  # [m]


# [m] and [-] of R: what is welded to the world may differ by so much from its first pose, as
# transforms do that were written with few digits.
WELDED_STAYS = 1e-6

# The span of time [-] that holds a first contact, unless another one is asked for.
TIME_TOLERANCE = 1e-6

# The smallest magnitude that a floating-point field of a message may hold, apart from 0. rclpy
# does not convert an integer that is written into such a field: it sends the bits of the integer
# n, which are read as n * 5e-324. This limit notices each integer up to 2e23.
SMALLEST_SENT = 1e-300
