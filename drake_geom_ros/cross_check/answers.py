"""Queries to another library (a peer), shapes as numbers, and answers in Drake's conventions."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

from drake_geom_ros.geometry import Convex, Mesh, Shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats

SIGNED_DISTANCE, PENETRATION = QUERIES = ('signed_distance', 'penetration')


class Unsupported(ValueError):  # noqa: N818  (not an error of the caller)
    """A peer lacks a query, a shape, a pair of shapes or a setting."""


class PairAnswer(NamedTuple):
    """Answer for a pair in Drake's conventions, with the peer's own numbers, NaN included.

    ``distance`` [m] is negative if the shapes overlap, ``nhat_BA_W`` (3,) points out of B into A,
    ``p_WCa`` and ``p_WCb`` (3,) [m] are the witness points in World. None: the peer has none.
    """

    distance: float
    nhat_BA_W: Floats | None
    p_WCa: Floats | None
    p_WCb: Floats | None


Ask = Callable[[RigidTransform, RigidTransform], 'PairAnswer | None']


class Peer(Protocol):
    """Protocol of a loaded library."""

    name: str

    def pair(self, query: str, shape_a: Shape, shape_b: Shape) -> Ask:
        """Return a function that queries the shapes at poses X_WA, X_WB.

        Everything that can be prepared is prepared here. ``penetration`` returns None if the peer
        reports no contact. Raises Unsupported for types that the peer refuses; for numbers that it
        refuses, its own errors are raised here or by the function.
        """


def checked(query: str) -> str:
    """Return the query; raises Unsupported if there is none of that name."""
    if query not in QUERIES:
        raise Unsupported(f'query = {query!r}: there are {", ".join(QUERIES)}')
    return query


def no_tolerance(name: str, tolerance: float | None) -> None:
    """Raise Unsupported for a tolerance of a peer that has no such setting."""
    if tolerance is not None:
        raise Unsupported(f'{name}: tolerance = {tolerance:g} cannot be set; it offers none')


class SolidMesh(Mesh):
    """A mesh that stands for the solid inside its surface, for peers that use triangles.

    For other peers it is its convex hull, as every mesh.
    """

    __slots__ = ()


# By type number: accessors of the constructor's arguments, and their factors for half sizes.
ACCESSORS: dict[str, tuple[str, ...]] = {
    'Sphere': ('radius',),
    'Box': ('width', 'depth', 'height'),
    'Capsule': ('radius', 'length'),
    'Cylinder': ('radius', 'length'),
    'Ellipsoid': ('a', 'b', 'c'),
    'HalfSpace': (),
}
HALVES = {'Box': (0.5, 0.5, 0.5), 'Capsule': (1.0, 0.5), 'Cylinder': (1.0, 0.5)}


def kind_of(shape: Shape) -> str:
    """Return the name of a shape's type; a Mesh counts as Convex, since peers get its hull."""
    return 'Convex' if isinstance(shape, (Convex, Mesh)) else type(shape).__name__


def measures(shape: Shape) -> tuple[float, ...]:
    """Return the sizes [m] of a shape, in the order of its constructor."""
    return tuple(float(getattr(shape, name)()) for name in ACCESSORS[type(shape).__name__])
