"""A mesh file as a scene of one body."""

from __future__ import annotations

import os
import re
from pathlib import Path

from drake_geom_ros.geometry import Mesh, ProximityProperties, Role
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    FrameDescription,
    GeometryDescription,
    RobotOptions,
    SceneDescription,
)
from drake_geom_ros.scene_files.errors import Location, SceneFileError
from drake_geom_ros.scene_files.flat_meshes import with_flat_meshes

# By the suffix, in lower case: what geometry.Mesh reads.
MESH_SUFFIXES = tuple(
    f'.{kind}' for kind in ['3mf', 'dae', 'glb', 'gltf', 'obj', 'off', 'ply', 'stl', 'vtk']
)
BODY, MESH = 'body', 'mesh'


def mesh_scene(path: Path, options: RobotOptions) -> SceneDescription:
    """Return the scene of a mesh file: a source with its name, a frame ``body``, the mesh on it.

    The body stands at the world's origin until it is posed. The mesh counts as its convex hull, or
    as a solid where ``solid_meshes`` of the options match ``body`` or ``body/mesh``. Raises
    SceneFileError for a file that is no mesh.
    """
    where = Location(str(path))
    name = source_name(path)
    properties = ProximityProperties()
    if options.is_solid(BODY, MESH):
        properties.AddProperty('mesh', 'solid', True)
    if padding := options.padding(BODY, MESH):
        properties.AddProperty('proximity', 'padding', padding)
    shape = Mesh(str(path))
    try:
        shape.surface()
    except RuntimeError as error:
        raise SceneFileError(str(error), str(path)) from error
    geometry = GeometryDescription(
        name, BODY, MESH, shape, RigidTransform(), {Role.kProximity: properties}, where
    )
    geometries, warnings = with_flat_meshes([geometry], options, where)
    return SceneDescription(
        str(path),
        sources=(name,),
        frames=(FrameDescription(name, BODY, X_PF=RigidTransform(), where=where),),
        geometries=geometries,
        warnings=warnings,
    )


def is_mesh_file(path: str | os.PathLike[str]) -> bool:
    """Return whether a file is a mesh, by its suffix."""
    return os.fspath(path).lower().endswith(MESH_SUFFIXES)


def source_name(path: Path) -> str:
    """Return the name of a mesh file's source: letters, digits and ``_``.

    >>> source_name(Path('left-part 2.stl'))
    'left_part_2'
    """
    name = re.sub('[^A-Za-z0-9_]', '_', path.stem)
    return name if name[:1].isalpha() else f'mesh_{name}'
