"""The bench's shapes as this project's: every side makes its own from these."""

from __future__ import annotations

from bench.peers.scenes import Shape
from drake_geom_ros import geometry
from drake_geom_ros.geometry.mesh_source import MeshData


def our_shape(shape: Shape) -> geometry.Shape:
    """Return a shape by the name and the arguments that the bench has for it."""
    if shape.vertices is not None:
        return geometry.Convex.FromMeshData(MeshData(shape.vertices))
    return getattr(geometry, shape.kind)(*shape.sizes)
