"""Shapes of a compiled model of MuJoCo."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    HeightField,
    Mesh,
    MeshData,
    ProximityProperties,
    Role,
    Shape,
    Sphere,
)
from drake_geom_ros.scene_files.description import GeometryDescription, RobotOptions
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.mujoco_joints import pose_of

_NOT_READ = {
    'SDF': 'a signed distance field is not read; give its surface as a mesh',
}


def geometries_of(
    model: Any, source: str, bodies: Sequence[str], options: RobotOptions, where: Location
) -> tuple[tuple[GeometryDescription, ...], tuple[int, ...]]:
    """Return the geometries that may collide in MuJoCo, and their ids there.

    Those are the ones with a bit in ``contype`` or ``conaffinity``, or in a ``<pair>``. Raises
    SceneFileError for a shape that is not read.
    """
    if model.nflex:
        raise where.error(f'{model.nflex} flexible bodies (flex) are not read; leave them out')
    paired = {*model.pair_geom1.tolist(), *model.pair_geom2.tolist()}
    made, ids = [], []
    names: defaultdict[int, set[str]] = defaultdict(set)
    for id in range(model.ngeom):
        if not (model.geom_contype[id] or model.geom_conaffinity[id] or id in paired):
            continue
        body = int(model.geom_bodyid[id])
        name = model.geom(id).name or f'collision_{len(names[body])}'
        while name in names[body]:
            name += '_'
        names[body].add(name)
        place = Location(where.file, key=f'body[{bodies[body]}].geom[{name}]')
        try:
            shape = _shape_of(model, id)
        except (ValueError, RuntimeError) as error:
            raise place.error(str(error)) from error
        properties = ProximityProperties()
        if isinstance(shape, Mesh) and options.is_solid(bodies[body], name):
            properties.AddProperty('mesh', 'solid', True)
        if padding := options.padding(bodies[body], name):
            properties.AddProperty('proximity', 'padding', padding)
        X_BG = pose_of(model.geom_pos[id], model.geom_quat[id])
        roles = {Role.kProximity: properties}
        made.append(GeometryDescription(source, bodies[body], name, shape, X_BG, roles, place))
        ids.append(id)
    return tuple(made), tuple(ids)


def _shape_of(model: Any, id: int) -> Shape:
    import mujoco

    kind = mujoco.mjtGeom(int(model.geom_type[id])).name.removeprefix('mjGEOM_')
    size = model.geom_size[id].tolist()
    if kind == 'PLANE':
        return HalfSpace()
    if kind == 'SPHERE':
        return Sphere(size[0])
    if kind == 'CAPSULE':
        return Capsule(size[0], 2.0 * size[1])
    if kind == 'CYLINDER':
        return Cylinder(size[0], 2.0 * size[1])
    if kind == 'ELLIPSOID':
        return Ellipsoid(*size)
    if kind == 'BOX':
        return Box(*(2.0 * half for half in size))
    if kind == 'MESH':
        return Mesh.FromMeshData(_mesh_of(model, int(model.geom_dataid[id])))
    if kind == 'HFIELD':
        return _height_field_of(model, int(model.geom_dataid[id]))
    raise ValueError(_NOT_READ.get(kind, f'the shape {kind} is not read'))


def _height_field_of(model: Any, field: int) -> HeightField:
    """Return a height field: rows of MuJoCo's data run along y, and the bottom is at -size[3]."""
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    first = model.hfield_adr[field]
    data = model.hfield_data[first : first + rows * columns].reshape(rows, columns)
    x, y, highest, below = model.hfield_size[field].tolist()
    xs, ys = np.linspace(-x, x, columns), np.linspace(-y, y, rows)
    return HeightField(xs, ys, highest * data.T.astype(float), -below)


def _mesh_of(model: Any, mesh: int) -> MeshData:
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    vertices = model.mesh_vert[first : first + count].astype(float)
    return MeshData(vertices, model.mesh_face[face : face + faces].astype(int))
