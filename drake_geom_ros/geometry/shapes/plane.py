"""``Plane``: a plane with a normal."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.math import RotationMatrix
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.arrays import as_vector
from drake_geom_ros.math.tolerances import DIRECTION_NORM


class Plane:
    """The plane of a ``normal`` (3,) through a point (3,) [m], in some frame F.

    The normal is normalised, unless ``already_normalized`` is true. Raises RuntimeError for one
    shorter than 1e-10.

        >>> Plane(normal=[0, 0, 2], point_on_plane=[0, 0, 1]).CalcHeight([5, 5, 3])
        2.0
    """

    __slots__ = ('_normal', '_point')

    def __init__(
        self, normal: ArrayLike, point_on_plane: ArrayLike, already_normalized: bool = False
    ) -> None:
        vector = as_vector(normal, 'Plane: normal')
        length = float(np.linalg.norm(vector))
        if length < DIRECTION_NORM:
            raise ArgumentError(f'Plane: |normal| = {length:g} must be >= {DIRECTION_NORM:g}')
        self._normal: Floats = vector if already_normalized else vector / length
        self._point: Floats = as_vector(point_on_plane, 'Plane: point_on_plane')

    def unit_normal(self) -> Floats:
        """Return the unit normal (3,), in F."""
        return self._normal.copy()

    def reference_point(self) -> Floats:
        """Return the point (3,) [m] that defines the plane, in F."""
        return self._point.copy()

    def CalcHeight(self, point: ArrayLike) -> float:
        """Return the signed distance [m] of a point (3,) of F from the plane, along the normal."""
        return float(self._normal @ (as_vector(point, 'CalcHeight: point') - self._point))

    def BoxOverlaps(
        self,
        half_width: ArrayLike,
        box_center_in_plane: ArrayLike,
        box_orientation_in_plane: RotationMatrix,
    ) -> bool:
        """Return whether the plane intersects a box, posed in F, of half sizes (3,) [m]."""
        axes = box_orientation_in_plane.matrix()
        reach = np.abs(self._normal @ axes) @ as_vector(half_width, 'BoxOverlaps: half_width')
        return bool(abs(self.CalcHeight(box_center_in_plane)) <= reach)

    def __repr__(self) -> str:
        return f'Plane(normal={self._normal.tolist()}, point_on_plane={self._point.tolist()})'
