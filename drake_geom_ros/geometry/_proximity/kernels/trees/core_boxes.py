"""Box around a core, which is a single leaf in a walk with a tree."""

from drake_geom_ros.geometry._proximity.kernels.shapes.supports import local_support
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import NodeBox, box_between
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled


@compiled
def box_of_core(kind: int, shape: Floats) -> NodeBox:
    """Return the box around the core of a shape, in its frame."""
    above = (
        local_support(kind, shape, (1.0, 0.0, 0.0), 0.0)[0],
        local_support(kind, shape, (0.0, 1.0, 0.0), 0.0)[1],
        local_support(kind, shape, (0.0, 0.0, 1.0), 0.0)[2],
    )
    below = (
        local_support(kind, shape, (-1.0, 0.0, 0.0), 0.0)[0],
        local_support(kind, shape, (0.0, -1.0, 0.0), 0.0)[1],
        local_support(kind, shape, (0.0, 0.0, -1.0), 0.0)[2],
    )
    return box_between(below, above)
