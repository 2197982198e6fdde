"""The files that a scene is made of, beside its own: nothing may be written over them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from drake_geom_ros.geometry import Convex, Mesh, Role, SceneGraph
from drake_geom_ros.scene_files.description import RobotDescription

_TEXTURE = ('phong', 'diffuse_map')


def files_of(scene_graph: SceneGraph, robots: Iterable[RobotDescription]) -> Iterator[Path]:
    """Yield the URDF and SRDF files of the robots, and those of meshes and their textures."""
    for robot in robots:
        yield from filter(None, (robot.urdf, robot.srdf))
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds():
        shape = inspector.GetShape(geometry)
        if isinstance(shape, Convex | Mesh) and shape.source().is_path():
            yield shape.source().path()
        for role in (Role.kPerception, Role.kIllustration):
            properties = inspector.GetProperties(geometry, role)
            if properties is not None and properties.HasProperty(*_TEXTURE):
                yield Path(str(properties.GetProperty(*_TEXTURE)))
