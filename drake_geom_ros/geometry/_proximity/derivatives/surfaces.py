"""Detection of pairs whose gradients come from triangle surfaces or from the cells of a map."""

from __future__ import annotations

from typing import TypeAlias

from drake_geom_ros.geometry._proximity.kernels.shapes.maps import is_map
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined

Scene: TypeAlias = tuple[Indices, Indices, Floats, Floats]  # types, starts, pool and R_WGs


@inlined
def is_of_surfaces(type_a: int, type_b: int) -> bool:
    """Return whether a distance is measured to the surface of a solid, or to a map.

    Against a half space the hull of a solid decides, so such a pair does not count.
    """
    highest = max(type_a, type_b)
    of_solid = highest == SOLID and type_a != HALF_SPACE and type_b != HALF_SPACE
    return of_solid or is_map(highest)
