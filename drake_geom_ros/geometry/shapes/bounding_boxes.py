"""Bounding boxes: axis-aligned (``Aabb``) and oriented (``Obb``)."""

from __future__ import annotations

import itertools
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError
from drake_geom_ros.geometry.shapes.plane import Plane
from drake_geom_ros.geometry.shapes.primitives import HalfSpace
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.arrays import as_vector

_B = TypeVar('_B', bound='_BoundingBox')


class _BoundingBox:
    """A box with centre Bo and axes B, posed in the frame H of the bounded object."""

    __slots__ = ('_X_HB', '_half_width')

    def __init__(self, X_HB: RigidTransform, half_width: ArrayLike) -> None:
        self._X_HB = RigidTransform(X_HB)
        self._half_width = as_vector(half_width, f'{type(self).__name__}: half_width')
        if (self._half_width < 0.0).any():
            raise ArgumentError(
                f'{type(self).__name__}: half_width = {self._half_width.tolist()} must be >= 0'
            )

    def center(self) -> Floats:
        """Return the centre (3,) [m], in H."""
        return self._X_HB.translation().copy()

    def half_width(self) -> Floats:
        """Return half the sizes (3,) [m] along the box's axes."""
        return self._half_width.copy()

    def pose(self) -> RigidTransform:
        """Return X_HB, the pose of the box."""
        return RigidTransform(self._X_HB)

    def CalcVolume(self) -> float:
        """Return the volume [m^3]."""
        return float(8.0 * self._half_width.prod())

    def Equal(self: _B, other: _B) -> bool:
        """Return whether the other box has the same numbers, to the last bit."""
        same = np.array_equal(self._half_width, other._half_width)
        return type(other) is type(self) and same and self._X_HB == other._X_HB

    @staticmethod
    def HasOverlap(
        a_G: Any = None,
        b_H: Any = None,
        X_GH: RigidTransform | None = None,
        *,
        obb_G: Obb | None = None,
        aabb_G: Aabb | None = None,
        bv_H: Obb | Aabb | None = None,
        obb_H: Obb | None = None,
        aabb_H: Aabb | None = None,
        hs_C: HalfSpace | None = None,
        plane_P: Plane | None = None,
        X_CH: RigidTransform | None = None,
        X_PH: RigidTransform | None = None,
    ) -> bool:
        """Return whether a box of a frame G overlaps a box of H, which is posed in G.

        Touching counts. Also returns whether a box of H overlaps a half space or a plane in whose
        frame H is posed: ``HasOverlap(bv_H, hs_C, X_CH)``, ``HasOverlap(bv_H, plane_P, X_PH)``.
        """
        box = _only(_BoundingBox, a_G, obb_G, aabb_G, bv_H)
        other = _only((_BoundingBox, HalfSpace, Plane), b_H, obb_H, aabb_H, hs_C, plane_P)
        X_OH = _only(RigidTransform, X_GH, X_CH, X_PH)
        if isinstance(other, _BoundingBox):
            X_AB = box._X_HB.InvertAndCompose(X_OH @ other._X_HB)
            return _boxes_overlap(X_AB, box._half_width, other._half_width)
        X_OB = X_OH @ box._X_HB
        if isinstance(other, Plane):
            return other.BoxOverlaps(box._half_width, X_OB.translation(), X_OB.rotation())
        below = X_OB.translation()[2] - np.abs(X_OB.rotation().row(2)) @ box._half_width
        return bool(below <= 0.0)


class Obb(_BoundingBox):
    """An oriented box: half sizes (3,) [m] along the axes of B, which is posed in a frame H.

    >>> box = Obb(X_HB=RigidTransform([1, 0, 0]), half_width=[1, 2, 3])
    >>> box.CalcVolume()
    48.0
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return f'Obb(X_HB={self._X_HB!r}, half_width={self._half_width.tolist()})'


class Aabb(_BoundingBox):
    """A box along the axes of a frame H: its centre (3,) and half sizes (3,) [m]."""

    __slots__ = ()

    def __init__(self, p_HoBo: ArrayLike, half_width: ArrayLike) -> None:
        super().__init__(RigidTransform(as_vector(p_HoBo, 'Aabb: p_HoBo')), half_width)

    def lower(self) -> Floats:
        """Return the corner (3,) [m] with the smallest coordinates, in H."""
        return self.center() - self._half_width

    def upper(self) -> Floats:
        """Return the corner (3,) [m] with the largest coordinates, in H."""
        return self.center() + self._half_width

    def __repr__(self) -> str:
        return f'Aabb(p_HoBo={self.center().tolist()}, half_width={self._half_width.tolist()})'


def _only(kind: Any, *values: Any) -> Any:
    """Return the value that is not None; ArgumentTypeError unless there is one of that kind."""
    present = [value for value in values if value is not None]
    if len(present) != 1 or not isinstance(present[0], kind):
        raise ArgumentTypeError(
            f'HasOverlap: {present} is not a box, a half space, a plane, a pose'
        )
    return present[0]


def _boxes_overlap(X_AB: RigidTransform, a: Floats, b: Floats) -> bool:
    """Return whether boxes of half sizes a, b (3,) [m] overlap: none of 15 axes separates them.

    Source: Gottschalk, Lin and Manocha, OBBTree, SIGGRAPH 1996.
    """
    R_AB, p_AB = X_AB.rotation().matrix(), X_AB.translation()
    axes = [*np.eye(3), *R_AB.T]
    axes += [np.cross(i, j) for i, j in itertools.product(np.eye(3), R_AB.T)]
    for axis in axes:
        if abs(axis @ p_AB) > np.abs(axis) @ a + np.abs(axis @ R_AB) @ b:
            return False
    return True
