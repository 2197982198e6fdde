"""Which pairs have their gradients from surfaces of triangles, or of the cells of a map."""

from __future__ import annotations

from typing import TypeAlias

from drake_geom_ros.geometry._proximity.kernels.shapes.maps import is_map
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined

Scene: TypeAlias = tuple[Indices, Indices, Floats, Floats]  # types, starts, pool and R_WGs


@inlined
def is_of_surfaces(type_a: int, type_b: int) -> bool:
    """Tell whether a distance is that of a solid's surface, or of a map, which has no hull.

    A half space meets the hull of a solid.
    """
    highest = max(type_a, type_b)
    of_solid = highest == SOLID and type_a != HALF_SPACE and type_b != HALF_SPACE
    return of_solid or is_map(highest)
