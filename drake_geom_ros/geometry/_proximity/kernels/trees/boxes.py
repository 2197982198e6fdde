"""Boxes of the nodes of a tree, and their separations."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from drake_geom_ros.geometry._proximity.kernels.vectors import add, norm, rotate, sub, vector_at
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined

NODE_WIDTH = 15
LOWER = 0  # 3: corner of the box
UPPER = 3  # 3


class NodeBox(NamedTuple):
    """An AABB: its centre and half its size [m]."""

    middle: Vector
    half: Vector


class NodeTree(Protocol):
    """Interface of a tree with leaves of any kind."""

    @property
    def nodes(self) -> int:
        """Start of the nodes in the parameters of its owner."""

    @property
    def leaves(self) -> int:
        """The number of leaves."""


class TreeOwner(Protocol):
    """A body with a tree, in whose frame all is computed."""

    @property
    def shape(self) -> Floats:
        """Its parameters."""

    @property
    def tree(self) -> NodeTree:
        """The place of its tree in the parameters."""


class TurnedTreeOwner(TreeOwner, Protocol):
    """A body rotated by R in that frame; one that is not a solid is a single leaf."""

    @property
    def kind(self) -> int:
        """Its shape type number."""

    @property
    def R(self) -> Floats:
        """Its orientation (3, 3)."""

    @property
    def box(self) -> NodeBox:
        """The box around it in its frame, if it is not a solid."""


NO_BOX = NodeBox((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # of a point


@inlined
def box_between(below: Vector, above: Vector) -> NodeBox:
    """Return the box between two corners."""
    return NodeBox(
        (0.5 * (below[0] + above[0]), 0.5 * (below[1] + above[1]), 0.5 * (below[2] + above[2])),
        (0.5 * (above[0] - below[0]), 0.5 * (above[1] - below[1]), 0.5 * (above[2] - below[2])),
    )


@inlined
def box_of_node(shape: Floats, tree: NodeTree, k: int) -> NodeBox:
    """Return the box of node k."""
    at = tree.nodes + NODE_WIDTH * k
    return box_between(vector_at(shape, at + LOWER), vector_at(shape, at + UPPER))


@inlined
def outside(distance: float, half_width: float) -> float:
    """Return the excess of a coordinate over half a width; 0 within."""
    return max(abs(distance) - half_width, 0.0)


@compiled
def separation_of_turned_boxes(box_A: NodeBox, R: Floats, p: Vector, box_B: NodeBox) -> float:
    """Return a lower bound [m] of the distance of two boxes, the first posed by R and p.

    Each box is enclosed in a box along the axes of the other; the larger of both distances counts.
    Nothing is farther from Bo than the pair's size, so a dozen roundings of EPS make the bound too
    large by less than ROUNDING EPS size. Callers add that to the limit beyond which they prune.
    """
    h, k = box_A.half, box_B.half
    d = sub(add(rotate(R, box_A.middle), p), box_B.middle)
    in_B = (
        outside(d[0], k[0] + abs(R[0, 0]) * h[0] + abs(R[0, 1]) * h[1] + abs(R[0, 2]) * h[2]),
        outside(d[1], k[1] + abs(R[1, 0]) * h[0] + abs(R[1, 1]) * h[1] + abs(R[1, 2]) * h[2]),
        outside(d[2], k[2] + abs(R[2, 0]) * h[0] + abs(R[2, 1]) * h[1] + abs(R[2, 2]) * h[2]),
    )
    x = R[0, 0] * d[0] + R[1, 0] * d[1] + R[2, 0] * d[2]
    y = R[0, 1] * d[0] + R[1, 1] * d[1] + R[2, 1] * d[2]
    z = R[0, 2] * d[0] + R[1, 2] * d[1] + R[2, 2] * d[2]
    in_A = (
        outside(x, h[0] + abs(R[0, 0]) * k[0] + abs(R[1, 0]) * k[1] + abs(R[2, 0]) * k[2]),
        outside(y, h[1] + abs(R[0, 1]) * k[0] + abs(R[1, 1]) * k[1] + abs(R[2, 1]) * k[2]),
        outside(z, h[2] + abs(R[0, 2]) * k[0] + abs(R[1, 2]) * k[1] + abs(R[2, 2]) * k[2]),
    )
    return max(norm(in_A), norm(in_B))


@inlined
def box_at(A: TurnedTreeOwner, i: int) -> NodeBox:
    """Return the box of node i of A, in A's frame."""
    return box_of_node(A.shape, A.tree, i) if A.kind == SOLID else A.box
