"""All that a check of a motion works on, by name, and the numbers that it is told by."""

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

# What is true of a motion.
CLEAR = 1  # every pair is certified to stay farther apart than the least distance
CONTACT = 2
UNKNOWN = 3
# Why there is no answer.
NO_POSE = 4  # a frame would be where no pose may be
NO_ROOM = 5  # the lists of the search are full: to be asked again with larger ones
STOPPED = 6

# How frames move; joints move straight in joint space.
SLERP, SCREW, JOINTS = 0, 1, 2

# Columns of ``nodes``: bounds of how a node moves in its parent while time goes from 0 to 1.
TURN = 0  # [rad] its angular speed
SLIDE = 1  # [m] the speed of its origin
BEND = 2  # [m] the acceleration of its origin
OFFSET = 3  # [m] the distance of its origin from that of the parent
TURN_ROUNDING = 4  # [-] how far interpolating may put it from where it exactly is (Frobenius)
SLIDE_ROUNDING = 5  # [m]
NODE_WIDTH = 6

# Columns of ``moves``, of a frame that moves by poses: see ``interpolants``.
AXIS, ANGLE, STEP = 0, 3, 4
MOVE_WIDTH = 7

# Columns of ``asked``.
LEVEL_GAP, TIME_TOLERANCE, MIN_DISTANCE, MOST_PADDING = 0, 1, 2, 3
ASKED_WIDTH = 4
# Places of ``flags``.
KIND, MOST, IGNORES = 0, 1, 2

# Columns of ``records``: what is known of a pair at one time, the normal out of A towards B in the
# axes of the node that both hang on, the gap that a plane with this normal leaves then, and the
# bounds and the answer of the distance.
PLANE, GAP, LOWER, UPPER, ANSWER = 0, 3, 4, 5, 6
RECORD_WIDTH = 7

# Columns of ``entries``: a pair, and its records at the begin and at the end of its span.
OF_PAIR, AT_BEGIN, AT_END = 0, 1, 2
# Columns of ``tops``, of a span: its first entry, the one behind its last, its first free record.
FIRST, BEHIND, FREE_RECORD = 0, 1, 2
# Columns of ``spans``.
BEGIN, END = 0, 1

# Columns of ``bounds``, of a pair: for the whole motion, and what rounding may add.
WAY = 0  # [m] no point of A comes farther than this against B
SAG = 1  # [m] nor farther from the chord of its path
SLACK = 2  # [m]
LEAST = 3  # [m] it is clear while its distance is larger
BOUND_WIDTH = 4

# Columns of ``told``: the span that holds what ended the search, the least bound of all that was
# proved, and the least distance that was seen, when [m].
T0, T1, LOWER_BOUND, SEEN, SEEN_TIME = 0, 1, 2, 3, 4
TOLD_WIDTH = 5
# Columns of ``counts``: the edge of a path that is looked at, where the least distance was seen,
# and of which pair; the pair that touches at T1, or of which nothing is proved from T0 on; pairs
# answered by kernels, pairs left out, and states that were posed.
EDGE, SEEN_EDGE, SEEN_PAIR, PAIR, EVALUATIONS, IGNORED, STATES = 0, 1, 2, 3, 4, 5, 6
COUNT_WIDTH = 7


class MotionArrays(NamedTuple):
    """All that a check of a motion works on, for a handle."""

    # What moves: nodes (v,), the world first, then links, then frames.
    parents: Integers
    nodes: Rows  # (v, NODE_WIDTH)
    on: Integers  # (n,) the node that each geometry hangs on
    reaches: Reals  # (n,) no point of it is farther from the origin of its node [m]; 0: half space
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
    X_WLs: Rows  # in what carries the robot
    links: Integers
    values: Rows  # (3, c) at the start, at the end, and now
    # The scene.
    rows: Integers  # (f,) of the frames that are posed
    poses: States  # (1, f, 7): room
    Xs: Rows  # (f, POSE_WIDTH): room
    world: HandleField
    pairs: IndexPairs  # (k, 2)
    paddings: Reals  # (k,) [m] of both bodies
    skipped: Flags  # (k,) pairs that are left out
    # Groups, and of each pair of them the node that both hang on.
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
    # The question.
    kernels: HandleField
    asked: Reals  # (ASKED_WIDTH,)
    flags: Integers  # KIND, MOST, IGNORES
    stop: Integers  # (1,)
    # What is found.
    told: Reals  # (TOLD_WIDTH,)
    counts: Integers  # (COUNT_WIDTH,)
    bounds: Rows  # (k, BOUND_WIDTH)
    # The search: what is left to be proved, see ``bisection``.
    entries: IndexRows  # (e, 3)
    records: Rows
    spans: RealPairs  # (s, 2)
    tops: IndexRows  # (s, 3)
    # One pair that is answered.
    one: IndexPairs
    slot: Integers
    hits: Integers
    memory: Rows
    effects: Integers
    waiting: Integers  # (0,)
    distances: Reals  # (0,)


motions_of = taker(MotionArrays)
