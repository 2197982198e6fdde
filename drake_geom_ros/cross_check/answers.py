"""What a peer is asked, shapes by their numbers, and its answers, in our conventions."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import Convex, Mesh, Shape
from drake_geom_ros.math import RigidTransform

Floats = NDArray[np.float64]

SIGNED_DISTANCE, PENETRATION = QUERIES = ('signed_distance', 'penetration')


class Unsupported(ValueError):  # noqa: N818  (it is no error of the caller's)
    """A peer has no such query, shape, pair of shapes or setting."""


class PairAnswer(NamedTuple):
    """One pair's answer: the peer's own numbers, NaN and zero vectors too, in our conventions.

    ``distance`` [m] is negative where the shapes overlap, ``nhat_BA_W`` (3,) points out of B into
    A, ``p_WCa`` and ``p_WCb`` (3,) [m] are the witness points in World. None: the peer gives none.
    """

    distance: float
    nhat_BA_W: Floats | None
    p_WCa: Floats | None
    p_WCb: Floats | None


Ask = Callable[[RigidTransform, RigidTransform], 'PairAnswer | None']


class Peer(Protocol):
    """A library that was loaded."""

    name: str

    def pair(self, query: str, shape_a: Shape, shape_b: Shape) -> Ask:
        """Return what asks the query of two shapes at poses X_WA, X_WB.

        All that can be made ahead is made here. ``penetration`` answers None where the peer
        reports no contact. Raises Unsupported for what the peer refuses by type; what it refuses
        for its numbers raises the peer's own errors, here or when asked.
        """


def checked(query: str) -> str:
    """Return the query, or raise Unsupported when there is none of that name."""
    if query not in QUERIES:
        raise Unsupported(f'query = {query!r}: there are {", ".join(QUERIES)}')
    return query


def no_tolerance(name: str, tolerance: float | None) -> None:
    """Raise Unsupported when a tolerance is given to a peer that has none to set."""
    if tolerance is not None:
        raise Unsupported(f'{name}: tolerance = {tolerance:g} cannot be set; it offers none')


class SolidMesh(Mesh):
    """A mesh that stands for the body which its surface encloses, for peers that take triangles.

    To the others it is its convex hull, as every mesh is.
    """

    __slots__ = ()


# By type number: what the constructor of a primitive takes, and the parts of it that are held by
# those who measure from the centre.
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
    """Return the name of a shape's type; a Mesh is a Convex, for peers get its hull."""
    return 'Convex' if isinstance(shape, (Convex, Mesh)) else type(shape).__name__


def measures(shape: Shape) -> tuple[float, ...]:
    """Return what the shape was made from [m], in the order of its constructor."""
    return tuple(float(getattr(shape, name)()) for name in ACCESSORS[type(shape).__name__])
