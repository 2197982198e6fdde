"""The arrays that bodies are packed into, and those that surfaces come out in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.arrays import Vector

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

VOLUME, SURFACE, HALF_SPACE = 0, 1, 2  # what a body is
# Columns of ``Bodies.table``.
KIND, FIRST_POINT, FIRST_ELEMENT, ELEMENTS, FIRST_NODE, LEAVES = range(6)
# Columns of ``Surfaces.sums``, of each pair; numbers in World.
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

    table: Indices  # (b, 6)
    numbers: Floats  # (b, 2): farthest from the origin [m]; pressure slope of a half space [Pa/m]
    inner: Floats  # (b, 3): a point well inside [m]; of a surface, a corner
    points: Floats  # (p, 3) [m]
    elements: Indices  # (e, 4), the last column of no meaning for triangles
    fields: Floats  # (e, 5): pressure gradient, pressure at the origin, length of the gradient
    # Of a tetrahedron (e, 4, 4): outward unit normal and offset [m] of the face against each
    # corner; of a triangle, its own in the first.
    planes: Floats
    beyond: Indices  # (e, 4): which element is beyond that face, of all elements; -1: none
    nodes: Floats  # (k, 6): middle and half size of the boxes of heaps, body after body [m]


class Surfaces(NamedTuple):
    """Room for surfaces: polygons one after another; ``ends[i]`` is where polygon i ends."""

    points: Floats  # (p, 3) [m], in World
    pressures: Floats  # (p,) [Pa]
    ends: Indices  # (f,)
    faces: Floats  # (f, 13)
    sums: Floats  # (pairs, 14)
    pair_ends: Indices  # (pairs,): where the polygons of each pair end
    # (pairs,): without polygons, though the bodies overlap: one is deep within the other.
    swallowed: NDArray[np.bool_]
    counts: Indices  # (2,): polygons, points


class Scratch(NamedTuple):
    """Room to compute in: for polygons, for the walk, and for the pose of a body in another."""

    work: Floats
    stack: Indices
    R: Floats  # (3, 3)


class Between(NamedTuple):
    """Two bodies, and where they are: the second in the first, and the first in World."""

    pair: int  # the row of ``Surfaces.sums``
    a: int  # the rows of the bodies; the first has tetrahedra, or b is a half space
    b: int
    R: Floats  # (3, 3)
    p: Vector
    R_W: Floats  # (3, 3)
    p_W: Vector
    rounding: float  # [m]: what is nearer than this to a plane is on it
    flip: bool  # whether the first is N
