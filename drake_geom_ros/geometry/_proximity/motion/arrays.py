"""Arrays of a motion check by name, and names of their columns."""

from __future__ import annotations

from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.handles import (
    Flags,
    HandleField,
    IndexPairs,
    Integers,
    RealPairs,
    Reals,
    Rows,
    Vectors,
    taker,
)

States: TypeAlias = Annotated[NDArray[np.float64], np.float64, (None, None)]
IndexRows: TypeAlias = Annotated[NDArray[np.int64], np.int64, (3,)]

# Verdicts about a motion.
CLEAR = 1  # every pair is certified to stay farther apart than the least distance
CONTACT = 2
UNKNOWN = 3
# Reasons for no verdict.
NO_POSE = 4  # a frame would have no valid pose
NO_ROOM = 5  # the lists of the search are full: to be repeated with larger ones
STOPPED = 6

# How frames move; joints move straight in joint space.
SLERP, SCREW, JOINTS = 0, 1, 2

# Columns of ``nodes``: bounds of how a node moves in its parent while time goes from 0 to 1.
TURN = 0  # [rad] its angular speed
SLIDE = 1  # [m] the speed of its origin
BEND = 2  # [m] the acceleration of its origin
OFFSET = 3  # [m] the distance of its origin from that of the parent
TURN_ROUNDING = 4  # [-] error of its interpolated rotation (Frobenius)
SLIDE_ROUNDING = 5  # [m] error of its interpolated position
SPIN = 6  # [rad] the angular acceleration, about an axis that is fixed in it
NODE_WIDTH = 7

# Columns of ``moves``, of a frame that moves by poses: see ``interpolants``.
AXIS, ANGLE, STEP = 0, 3, 4
MOVE_WIDTH = 7

# Rows of ``values``, of a column of a path on the current edge: the values at its start, at its
# end and at the current time, and the ``CURVE_WIDTH`` numbers of ``JointPath.curves``: five
# coefficients, and bounds of the speed, of the acceleration, of the size of the value and of its
# rounding. On a straight edge the coefficients are not read.
FIRST_VALUE, LAST_VALUE, NOW, POWERS = 0, 1, 2, 3
SPEED, ACCELERATION, SIZE, ROUNDING = 8, 9, 10, 11
CURVE_WIDTH, VALUE_ROWS = 9, 12

# Places of ``parameters``.
LEVEL_GAP, TIME_TOLERANCE, MIN_DISTANCE, MOST_PADDING = 0, 1, 2, 3
# The part of the current edge up to the posed state; when the edge begins and how long it takes
# [s]; and the largest of ``approaches`` and of ``approached``.
ELAPSED, EDGE_BEGIN, EDGE_SPAN, MOST_APPROACH, MOST_APPROACHED = 4, 5, 6, 7, 8
PARAMETER_COUNT = 9
# Places of ``flags``.
KIND, MOST, IGNORES, CURVED = 0, 1, 2, 3
QUICK = 4  # no more is computed than a proof needs; a state without one counts as contact
FLAG_COUNT = 5

# Columns of ``records``, of a pair at one time: the normal of a plane, out of A towards B in the
# axes of the pair's common node; the gap that the plane leaves; bounds of the distance; and the
# answered distance.
PLANE, GAP, LOWER, UPPER, ANSWER = 0, 3, 4, 5, 6
RECORD_WIDTH = 7

# Columns of ``entries``: a pair, and its records at the begin and at the end of its span.
OF_PAIR, AT_BEGIN, AT_END = 0, 1, 2
# Columns of ``tops``, of a span: its first entry, the end of its entries, its first free record.
FIRST, BEHIND, FREE_RECORD = 0, 1, 2
# Columns of ``spans``.
BEGIN, END = 0, 1

# Columns of ``bounds``, of a pair: for the whole motion.
WAY = 0  # [m] no point of A moves farther than this relative to B
SAG = 1  # [m] no point of A is farther than this from the chord of its path
SLACK = 2  # [m] rounding of the interpolation
LEAST = 3  # [m] the pair is clear while its distance is larger
CLOSING = 4  # [m] as far the bodies may approach each other by themselves on the current edge
CLOSED = 5  # [m] and as far before it; LEAST holds it
BOUND_WIDTH = 6

# Places of ``outcome``: the span in which the search ended, the least of all proved lower bounds
# [m], the least distance that was seen [m], and its time.
T0, T1, LOWER_BOUND, SEEN, SEEN_TIME = 0, 1, 2, 3, 4
OUTCOME_WIDTH = 5
# Places of ``counts``: the current edge of a path; the edge and the pair of the least distance
# that was seen; the pair that touches at T1, or of which nothing is proved from T0 on; the numbers
# of pairs answered by kernels, of pairs left out, and of states posed.
EDGE, SEEN_EDGE, SEEN_PAIR, PAIR, EVALUATIONS, IGNORED, STATES = 0, 1, 2, 3, 4, 5, 6
COUNT_WIDTH = 7


class MotionArrays(NamedTuple):
    """All arrays that a motion check works on, for a handle."""

    # The tree of nodes (v,): the world first, then links, then frames.
    parents: Integers
    nodes: Rows  # (v, NODE_WIDTH)
    on: Integers  # (n,) the node that carries each geometry
    reaches: Reals  # (n,) its farthest point from the origin of its node [m]; 0: half space
    # By poses: of frames (f,).
    starts: Rows  # (f, POSE_WIDTH)
    ends: Rows
    moves: Rows  # (f, MOVE_WIDTH)
    # By joints (m,): see ``JointChain``.
    leaders: Integers
    multipliers: Reals
    offsets: Reals
    kinds: Integers
    axes: Vectors
    X_PJs: Rows
    chain_parents: Integers
    children: Integers
    X_WLs: Rows  # relative to the carrier of the robot
    links: Integers
    values: Rows  # (VALUE_ROWS, c)
    # The scene.
    rows: Integers  # (f,) of the frames that are posed
    poses: States  # (1, f, 7) scratch
    Xs: Rows  # (f, POSE_WIDTH) scratch
    world: HandleField
    pairs: IndexPairs  # (k, 2)
    paddings: Reals  # (k,) [m] of both bodies
    skipped: Flags  # (k,) pairs that are left out
    approaches: Reals  # (k,) [m/s] at most, beside the motion that is checked
    approached: Reals  # (k,) [m] at most, at time 0
    examined: Flags  # (k,) pairs that boxes alone did not prove clear
    # Groups, and the common node of each pair of groups.
    firsts: Integers
    members: Integers
    group_pairs: IndexPairs
    starts_of_pairs: Integers
    numbers: Integers
    centres: Vectors
    halves: Vectors
    separations: Reals
    group_reaches: Reals  # (g,) the largest of their members
    sides: IndexPairs  # (m, 2) the nodes of a pair of groups
    common: Integers  # (m,)
    common_of_pair: Integers  # (k,)
    # The parameters of the check.
    kernels: HandleField
    parameters: Reals  # (PARAMETER_COUNT,)
    flags: Integers  # (FLAG_COUNT,)
    stop: Integers  # (1,)
    # The results.
    outcome: Reals  # (OUTCOME_WIDTH,)
    counts: Integers  # (COUNT_WIDTH,)
    bounds: Rows  # (k, BOUND_WIDTH)
    # The search: spans and pairs not proved yet, see ``bisection``.
    entries: IndexRows  # (e, 3)
    records: Rows
    spans: RealPairs  # (s, 2)
    tops: IndexRows  # (s, 3)
    # Scratch for the answer of one pair.
    one: IndexPairs
    slot: Integers
    hits: Integers
    memory: Rows
    effects: Integers
    waiting: Integers  # (0,)
    distances: Reals  # (0,)


motions_of = taker(MotionArrays)
