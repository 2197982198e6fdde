"""The arrays that bodies are packed into, and those that surfaces come out in."""

from __future__ import annotations

from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._contact_surfaces.compiled import inlined
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.handles import (
    HandleField,
    Integers,
    Matrices,
    RealPairs,
    Reals,
    Rows,
    Vectors,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
# The fields of records that are handed over by handles: see ``runtime.handles``.
_Table: TypeAlias = Annotated[Indices, np.int64, (7,)]
_Fours: TypeAlias = Annotated[Indices, np.int64, (4,)]
_Fields: TypeAlias = Annotated[Floats, np.float64, (5,)]
_Lines: TypeAlias = Annotated[Floats, np.float64, (4,)]
_Corners: TypeAlias = Annotated[Floats, np.float64, (7,)]
_Planes: TypeAlias = Annotated[Floats, np.float64, (4, 4)]

VOLUME, SURFACE, HALF_SPACE = 0, 1, 2  # what a body is
# Columns of ``Bodies.table``.
KIND, FIRST_POINT, FIRST_ELEMENT, ELEMENTS, FIRST_NODE, LEAVES = range(6)
DIGEST = 6  # of what the body is made of: like bodies have the same
# Columns of ``Surfaces.sums``; numbers in World.
AREA = 0  # [m^2]
FIRST_MOMENT = 1  # 3: area times centroid [m^3]
FORCE = 4  # 3: on M, by the pressure along the normals [N]
PRESSURE = 7  # integral over the area [N]
PRESSURE_MOMENT = 8  # 3: integral of pressure times position [N m]
TORQUE = 11  # 3: on M about Wo [N m]
SUMS = 14
# Columns of ``Surfaces.faces``.
NORMAL = 0  # 3: unit, out of N into M
FACE_AREA = 3  # [m^2]
CENTROID = 4  # 3 [m]
GRAD_M = 7  # 3: of M's pressure [Pa/m]; 0 where M has none
GRAD_N = 10  # 3
FACE = 13
MOST_CORNERS = 12  # of a polygon: 4 of a cut tetrahedron, and one for each plane that clips it


class Bodies(NamedTuple):
    """Bodies (b,) one after another; the elements of each are in the order of its tree's leaves.

    Of a half space only row ``table`` and ``numbers`` count. Indices in ``elements`` are of the
    body's own points.
    """

    table: _Table  # (b, 7)
    numbers: RealPairs  # (b, 2): farthest from the origin [m]; pressure slope of a half space
    inner: Vectors  # (b, 3): a point well inside [m]; of a surface, a corner
    points: Vectors  # (p, 3) [m]
    elements: _Fours  # (e, 4), the last column of no meaning for triangles
    fields: _Fields  # (e, 5): pressure gradient, pressure at the origin, length of the gradient
    # Of a tetrahedron (e, 4, 4): outward unit normal and offset [m] of the face against each
    # corner; of a triangle, its own in the first.
    planes: _Planes
    beyond: _Fours  # (e, 4): which element is beyond that face, of all elements; -1: none
    # (12 k,): the boxes of heaps, body after body; see the columns below. Flat, for then the place
    # of a node is known sooner by the time of a multiplication, and walks wait for nothing else.
    nodes: Reals
    boxes: Rows  # (6, e): of each element the middle and half the size of its box [m]


# Columns of ``Bodies.nodes``: a box, and between which two planes the pressures in it are.
MIDDLE = 0  # 3 [m]
HALF = 3  # 3: half the size [m]
SLOPE = 6  # 3: a gradient [Pa/m]: pressures are this times the position, and more by
LEVEL = 9  # this [Pa],
SPREAD = 10  # give or take this [Pa]
STEEPEST = 11  # the longest gradient of an element [Pa/m]
NODE = 12


@inlined
def in_node(nodes: Floats, row: int, column: int) -> Vector:
    """Return three numbers of a node, which begins at place ``row``, from a column on."""
    k = unsigned(row + column)
    return nodes[k], nodes[k + unsigned(1)], nodes[k + unsigned(2)]


@inlined
def first_in_leaf(bodies: Bodies, body: int, leaf: int) -> int:
    """Return the first element of a leaf; that of the next one is behind its last."""
    table = bodies.table
    first: int = table[body, FIRST_ELEMENT] + leaf * table[body, ELEMENTS] // table[body, LEAVES]
    return first


class Geometries(NamedTuple):
    """The bodies of geometries (n,), and their poses."""

    ids: Integers  # (n,), ascending
    body_of: Integers  # (n,): the row of a geometry's body; -1: it has none
    R_WGs: Matrices  # (n, 3, 3)
    p_WGs: Vectors  # (n, 3) [m]


class Hands(NamedTuple):
    """The handles of what surfaces are made of."""

    bodies: HandleField
    geometries: HandleField


# What there is of each pair that was asked about.
NOTHING, PRESSES = 0, 1
UNABLE = 2  # to have a surface: one has no body, both are rigid, or both are half spaces
# Without polygons, though they overlap:
SWALLOWED = 3  # one is deep within the other
TURNED = 4  # all faces are left out for their normals
LATE = 6  # unknown, for there was no time; 5 is what ``contact_bodies`` adds
# Places in ``Surfaces.counts``.
POLYGONS, CORNERS, FOUND, LEFT = range(4)  # LEFT: pairs that are UNABLE or more
# How far the work is: pairs done, the stage of the next one, the top of its walk's stack, what was
# put out before it; how many steps may follow in this call, and whether there is no room for more.
DONE, STAGE, TOP, FACES_BEFORE, CORNERS_BEFORE, STEPS, FULL = range(4, 11)
COUNTS = 11
BEGINS, MEETS, MEETS_ANYWAY = range(3)  # stages of a pair; the last as ``Between.anyway`` says
NOT_BEGUN = -1  # instead of the top of a stack
# Columns of ``Surfaces.found``.
ID_M, ID_N, COMPLIANT_M, COMPLIANT_N = range(4)
LAST = 4  # where the surface's polygons end
RECORD = 5


class Surfaces(NamedTuple):
    """Surfaces: polygons one after another; ``ends[i]`` is where polygon i ends."""

    points: Floats  # (p, 3) [m], in World
    pressures: Floats  # (p,) [Pa]
    ends: Indices  # (f,)
    faces: Floats  # (f, 13)
    sums: Floats  # (k, 14), of each surface that was found
    found: Indices  # (k, 5)
    states: Indices  # (k,), of each pair that was asked about
    counts: Indices  # (11,)


class Counts(NamedTuple):
    """Numbers of what an answer holds: see the places in ``Surfaces.counts``."""

    polygons: int
    corners: int
    surfaces: int
    left: int  # pairs that are UNABLE or more
    done: int  # pairs
    is_full: bool  # whether the next polygon finds no room


class Scratch(NamedTuple):
    """Room to compute in."""

    work: _Corners  # polygons
    stack: Integers  # (2 n,): the walk
    R: Vectors  # (3, 3): the pose of a body in another
    other: _Lines  # an element of one body in the frame of another: see ``posed``
    found: Integers  # which elements are near: see ``triangles``
    sums: Reals  # (14,): what a step of a walk begins with, for it may find no room
    counts: Integers  # (11,): those of ``Surfaces``


class Field(NamedTuple):
    """A pressure in the first body's frame that is linear, as it is all over an element."""

    gradient: Vector  # [Pa/m]
    level: float  # [Pa] at the origin
    length: float  # [Pa/m] of the gradient


class Between(NamedTuple):
    """Two bodies, and where they are: the second in the first, and the first in World."""

    row: int  # of ``Surfaces.sums``
    a: int  # the rows of the bodies; the first has tetrahedra, or the second is a half space
    b: int
    R: Floats  # (3, 3)
    p: Vector
    R_W: Floats  # (3, 3)
    p_W: Vector
    rounding: float  # [m]: what is nearer than this to a plane is on it
    flip: bool  # whether the first is N
    anyway: bool  # whether faces count whatever their normals are
