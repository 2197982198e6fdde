"""Which pairs have their gradients from surfaces of triangles."""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined


@inlined
def is_of_surfaces(type_a, type_b):  # type: ignore[no-untyped-def]
    """Tell whether a distance is that of a solid's surface; a half space meets its hull."""
    return (type_a == SOLID or type_b == SOLID) and type_a != HALF_SPACE and type_b != HALF_SPACE
