"""Every epsilon of the project: its value, its unit and the reason for it.

Those of poses stand in ``drake_geom_ros.math.tolerances``, which imports nothing of ours.
"""

import math

# Spacing of float64 at 1 [-]: the unit in which rounding bounds are counted.
EPS = 2.0**-52

# Of float32: twice its relative rounding error; next to the least number of full
# digits, and a number below the largest. Boxes of few bodies are compared in it.
SINGLE_EPS, SINGLE_TINY, SINGLE_LARGEST = 2.0**-23, 2.0**-125, 2.0**127

# The largest error [m] of each accuracy level, wherever bodies are apart. ``exact`` is the gap of
# certified bounds that iterations aim for, for a pair of size 1 m. ``bound`` runs no iteration.
LEVEL_GAPS = {'fast': 1e-3, 'balanced': 1e-6, 'exact': 1e-9}
# Iterations aim for this gap [m] where a larger error is wanted, too: a larger gap saves no time
# (``exact`` costs 0.63 to 1.1 times ``fast``), and would hide contacts.
COARSEST_GAP = LEVEL_GAPS['exact']
# An accuracy [m] from which on solids are answered by coins of their trees' nodes. Its class, the
# power of 2 below, exceeds this many roundings of a distance: below that ``exact`` answers.
COARSE = 1e-5
ROUNDINGS_OF_A_CLASS = 2.0**24
# Share of the area of a node's triangles [-] that their sum as vectors has to be to give a normal.
NO_NORMAL = 1e-9
# The same of all levels; at 'bound' bounds alone will do.
GAPS_OF_LEVELS = {'bound': math.inf, **LEVEL_GAPS}

# Rounding that may add to the bounds that a level promises, in EPS times the pair's size and the
# distance of the origins. EPA ends within 4 ROUNDING and each answer of an iteration is widened by
# one more, a closed form has CLOSED_FORM_ROUNDING: this is 1.6 and 4 times as much.
PROMISED_ROUNDING = 128.0

# Rounding of poses (``pose_rounding``): the worst cases, in units u = EPS / 2. A rotation that is
# taken in is off [-], in the Frobenius norm, by no more than this from the one that was given. Of
# a quaternion: 2 / |q|^2 is off by 4 u, which moves R by 4 u |R - I|, at most 12 u; products, sums
# and this factor of them add 10 u, the difference from 1 adds 2 u. Of a matrix in which no element
# of |R R^T - I| is above 6 EPS (``math.tolerances.ORTHOGONAL``), as computed: half of
# 3 (6 + 1.5) EPS.
ROTATION_TAKEN = 12.0 * EPS

# A product of two rotations adds this [-]: 3 u times the norm of |R||S|, which is at most 3, and
# what making it orthogonal rounds, half of the 9 u in R^T R - I and 2 u in the difference.
ROTATION_STEP = 8.0 * EPS

# Rounding of p + R q in three sums, over |p| + |q| [-]: 4 u (|p| + sqrt(3) |q|), and u (|p| + |q|)
# for the difference of the result and another position.
POSITION_STEP = 4.0 * EPS

# How far the matrix of a posed geometry may be from a rotation [-]: taken in, times one taken in.
ROTATION_DEFECT = 2.0 * ROTATION_TAKEN + ROTATION_STEP

# Depth [m], relative to the pair's size, that a pair must exceed to count as penetrating:
# touching is not penetrating, and rounding leaves a touching pair within a few EPS of zero.
TOUCHING_DEPTH = 1e-14

# Where that, or the rounding of poses, hides more than this depth [m], from sizes, distances and
# coordinates of 1e11 m on, contacts are hidden that are plainly visible: ``HasCollisions`` then
# counts those that may be.
UNSEEN_DEPTH = 1e-3


# Depth [-], relative to the smaller of the balls inside two bodies, from which on a contact is
# plain: a hundred times the gap of the widest bounds that were ever found.
PLAIN_DEPTH = 2.0**-10

# A direction whose component [-] along an edge is below this is normal to the edge: a few
# EPS, what is left of an exact right angle after turning a unit vector into another frame. The
# midpoint taken there is this times the edge's length below the true support value.
RIGHT_ANGLE = 8.0 * EPS
# A direction that EPA found is off by its own error: where it is normal to an edge to
# this angle, Newton's method starts from where it is so exactly. Beside such a kink h may have no
# curvature to go by; where the minimum is not on the kink, the first step leaves it again.
ALMOST_RIGHT_ANGLE = 1e-6

# Rounding of a support value [-], in EPS times the pair's size (bounding radii plus distance of
# the origins): two rotations, a difference and an inner product, each a few EPS. Certified bounds
# are widened by it, and an iteration whose bounds are closer than it can gain nothing more.
ROUNDING = 16.0

# A point of the Minkowski difference this near [-] to the origin, relative to the pair's size, as
# the weights of an enclosing tetrahedron give it: weights of a thin one keep about ten digits.
INSIDE = 1e-10

# Two candidates (faces, sides, axes) whose distances differ by less than this, relative to the
# pair's extent, count as equal: taking a point into another frame and back costs about 4 EPS.
TIE = 8.0 * EPS

# Rounding of a whole closed form, relative to the pair's extent (sizes + distance of the
# origins): at most 2 TIE from choosing among equals, the rest from the arithmetic; the
# tests against 50 digits keep it true.
CLOSED_FORM_ROUNDING = 32.0 * EPS

# A separation longer than this [-], in ties, has a direction: rounding turns it by less than a
# tenth of a radian even where a separating axis as wide but for a tie stands in for it.
CLEAR_SEPARATION = 256.0
# Sine of the angle between a shorter separation and an axis below which the axis is its direction.
ALONG_AXIS = 2.0**-4

# Sine above which two normals count as different in the test whether the normal is unique.
DISTINCT_NORMALS = 2.0**-20

# Nearest points, relative to the pair's size, and normals this far apart [-], as GJK finds them on
# triangles that share an edge, are the same: of rims it finds them to the root of EPS or two times
# as many thousandths.
SAME_WITNESS = 2.0**-16

# Stiffness [-], relative to the pair's extent, below which a turn of the normal costs nothing: the
# direction of a separation this short has lost so much to rounding that it is off by
# DISTINCT_NORMALS.
SOFT = EPS / DISTINCT_NORMALS

# Separation, relative to the pair's extent, below which the normal of two cores is taken from the
# separating axis instead of the vector b - a, whose direction then has lost 10 bits or more.
SHORT_SEPARATION = 2.0**-10

# Lengths below this, relative to the largest semi-axis, are taken for 0 in the ellipsoid's
# equation, so that nothing in it overflows or underflows.
VANISHING = 2.0**-400

# Steps that the ellipsoid's equation may take [-]: 11 halvings of the exponent bring a
# bracket of any ratio below 4, Newton then needs 4 to 7 steps.
ELLIPSOID_HALVINGS = 16
ELLIPSOID_STEPS = 32

# Corners of a triangle whose offsets along its own normal differ by more than this [-], relative
# to the pair's size, make the normal meaningless: a sliver. Rounding of a sound triangle is a few
# EPS.
SLIVER = 1e-13

# A difference of hulls in which the first tetrahedron is thinner than this [-], relative to the
# pair's size, may have no volume beyond rounding: the result of EPA is then checked again.
THIN = 1e-6

# Cosine [-] of the angle, 8 degrees, beyond which two normals are different answers and not two
# faces around the same minimum.
SAME_DIRECTION = 0.99

# A core distance this small [-], relative to the pair's size, leaves its direction fewer than ten
# correct digits (EPS / 1e-6): the face of EPA there gives a better normal.
NEAR_TOUCH = 1e-6

# Around the origin the least offset of a growing polytope never falls, but by rounding of planes.
# A fall by more than this [-], relative to the pair's size, shows that rounding folded the surface
# at triangles too thin to decide which vertices see them: the bounds reached before it stand.
FOLD = 1e-9

# A point this far [-] above a face's plane, in EPS times the pair's size, is in the plane: a
# quarter of what EPA must gain by a new vertex (ROUNDING), so the face that it was found for
# always sees it.
COPLANAR = 4.0

# A mesh is scaled by at least this [-]: Drake's rule, which keeps scales away from zero.
SMALLEST_SCALE = 1e-8

# Cells of a sensed map are no smaller than this [m], and drawn as lying on one grid where their
# centres are no farther beside it than this part [-] of an edge.
SMALLEST_CELL = 1e-9
ON_GRID = 1e-6

# GJK goes on to this part [-] of the tolerance: the last three digits cost it a step or two, and
# the normal and the witness points gain half of them.
SHARPER = 1e-3

# EPA goes on to this part [-] of the tolerance, for the same reason: a digit costs it a few
# vertices, and a pair that touches has its bounds on either side of zero.
SHARPER_DEPTH = 0.1

# A mesh whose least extent is below this [-], relative to the largest, is flat: of its thickness
# rounding leaves fewer than four digits, and its faces have no sides.
FLAT_HULL = 1e-12

# Squares of lengths [m^2] between these have lost no digit to underflow, and none to overflow.
SMALL_SQUARE = 2.0**-900
LARGE_SQUARE = 2.0**900

# Sizes [m] of pairs between which products of four lengths, some of them EPS times as large, stay
# within float64; other pairs are computed at about 1 m.
SMALL_SIZE = 2.0**-180
LARGE_SIZE = 2.0**180

# Length [m] that a shorter one in such a pair is taken for: its cube and the inverse of that stay
# within float64, and beside the rounding of the pair's size it is nothing.
LEAST_LENGTH = 2.0**-300

# A step of Newton's method on a normal this small [-] was the last that mattered: its square is
# EPS.
LAST_STEP = 2.0**-26

# Slope of the overlap's width [m/rad], in units of its rounding, that Newton's method may leave
# after such a step: half its square over the curvature is below rounding wherever a cap is proven.
LOOSE_SLOPE = 32.0

# Sine [-] of the angle by which the edges at a vertex of a hull fall away: below it the vertex is
# blunt, and rounding could hide more than 512 EPS of the hull's diameter from a climb.
BLUNT = 2.0**-7

# A closed surface that holds less volume [-] than this, relative to the cube of its size, is a
# sheet: the sum of signed tetrahedra leaves about that of rounding.
NO_VOLUME = 1e-14

# A mesh whose volume differs from its hull's by more than this [-] is not convex. That it is must
# be shown edge by edge: a needle of a dent holds no volume.
SAME_VOLUME = 1e-9

# Triangles of one surface cross if each goes this far [-] through the plane of the other, relative
# to their size, and they are in each other for as long: a vertex in single precision that touches
# does not.
CROSSING = 1e-6

# How far off [-] the gap of a point and a triangle may be, relative to where the triangle is, as
# it is computed of eight at once: the place on one that is NEEDLE wide is off by 1000 roundings.
LANE_ERROR = 2.0**-36

# Square of a triangle's width over its longest side [-] below which its normal is unreliable.
NEEDLE = 1e-6

# Of boxes within solids: the sine of two axes below which their product is no axis, and three unit
# vectors' determinant squared from which on they determine a point.
PARALLEL = 1e-6
INDEPENDENT = 1e-4

# Boxes in solids are separated by translations up to the one of the hulls and this much longer
# [-]: so translations that are as short as that one are found too, and show that it is not alone.
BEYOND_HULL = 2.0**-10

# Time [s] of a point and a geometry, about: by an iteration or a tree, and by a closed form.
LONG_POINT, SHORT_POINT = 1e-6, 3e-8

# Of motions. A rotation that is interpolated is off [-] by no more than this from the exact one
# (Frobenius): that of quaternions or of an axis and an angle, of a few products; and a position by
# this part [-] of the lengths that are added. A test holds both against fifty digits.
INTERPOLATED_ROTATION = 128.0 * EPS
INTERPOLATED_POSITION = 32.0 * EPS

# A bound of what moves is taken as so much larger [-]: tens of its sums and products are rounded.
ROUNDED_UP = 1.0 + 256.0 * EPS

# A normal that is carried from one time to another, and support values along it, are off [-] by no
# more than this part of the pair's extent: two rotations into the axes of a node and out of them,
# each by 16 EPS, and the sums.
CARRIED_PLANE = 128.0 * EPS

# Below this angle [rad] cosines are taken by their series, whose next term is below EPS.
SMALL_TURN = 2.0**-12

# For a turn with a quaternion whose w is below this [-], the shorter way is undecided.
HALF_TURN = 32.0 * EPS

# A motion that is not proved within a span that is a sixteenth of this or of the tolerance [-] is
# reported as unknown from there on; where a plane separates the bodies at its begin, within the
# other one.
LEAST_SPAN, LEAST_PARTED_SPAN = 2.0**-20, 2.0**-44
# A time tolerance below this [-] counts as this. A sixteenth of it is LEAST_PARTED_SPAN: shorter
# spans come to times that are not halved any more, and to depths that rounding hides.
LEAST_TIME_TOLERANCE = 2.0**-40
