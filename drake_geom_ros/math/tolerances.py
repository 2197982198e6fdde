"""The epsilons and limits of poses; ``geometry._proximity.tolerances`` holds all the others.

They are here because ``math`` imports nothing of ours.
"""

# | |q| - 1 | may reach this [-] in a pose that is taken in: generous to float32 senders, far
# below what a wrong field order produces (INTERFACE.md, Behaviour). The quaternion is normalised.
QUATERNION_NORM = 1e-3

# A pose that a scene takes in may have no coordinate beyond this [m]: the sums over a chain of
# poses, a million of them, then stay within float64.
FARTHEST = 2.0**1004

# max |R R^T - I| [-] of a matrix that is taken as a rotation: what the results promise of their
# unit vectors. A product of thousands of rotations stays below it, float32 numbers do not.
ROTATION = 1e-12

# Shortest vector [-] whose direction is trusted (Drake's choice for MakeFromOneVector and
# HalfSpace.MakePose).
DIRECTION_NORM = 1e-10
