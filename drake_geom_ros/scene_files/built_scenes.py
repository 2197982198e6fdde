"""Scenes that a program has built with pydrake or MuJoCo, read from the objects themselves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    CoulombFriction,
    Cylinder,
    Ellipsoid,
    FilterOperation,
    GeometryProperties,
    HalfSpace,
    HydroelasticType,
    IllustrationProperties,
    Mesh,
    PerceptionProperties,
    ProximityProperties,
    RenderLabel,
    Rgba,
    Role,
    SceneGraph,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    WORLD,
    DeclarationDescription,
    FrameDescription,
    GeometryDescription,
    Member,
    RobotDescription,
    RobotOptions,
    SceneDescription,
    Statement,
)
from drake_geom_ros.scene_files.errors import Location, SceneFileError
from drake_geom_ros.scene_files.hydroelastic import COMPLIANCE, GROUP, MODULUS
from drake_geom_ros.scene_files.mujoco_models import model_name, parts_of_model
from drake_geom_ros.scene_files.registration import LoadedScene, register
from drake_geom_ros.scene_files.welding import welded_scene

_MUJOCO, _PYDRAKE = '<mujoco>', '<pydrake>'
_SIZES: Mapping[str, tuple[type[Shape], tuple[str, ...]]] = {
    'Box': (Box, ('width', 'depth', 'height')),
    'Capsule': (Capsule, ('radius', 'length')),
    'Cylinder': (Cylinder, ('radius', 'length')),
    'Ellipsoid': (Ellipsoid, ('a', 'b', 'c')),
    'HalfSpace': (HalfSpace, ()),
    'Sphere': (Sphere, ('radius',)),
}
_ROLES = (
    (Role.kProximity, 'GetProximityProperties', ProximityProperties),
    (Role.kIllustration, 'GetIllustrationProperties', IllustrationProperties),
    (Role.kPerception, 'GetPerceptionProperties', PerceptionProperties),
)


def from_mujoco(
    mj_model: Any, scene_graph: SceneGraph, options: RobotOptions | None = None
) -> LoadedScene:
    """Register the bodies of a compiled ``mujoco.MjModel``, and return the ids by name.

    The source has the model's name. Meaning and errors are those of an MJCF file; the scene graph
    is unchanged after an error. The model is read once: later changes of it have no effect.
    """
    chosen, name = options or RobotOptions(), model_name(mj_model)
    parts = parts_of_model(mj_model, name, chosen, _MUJOCO)
    robot = RobotDescription(name, None, RigidTransform(), tree=parts.tree)
    return register(scene_graph, welded_scene(_MUJOCO, [(robot, parts)], [], {}, [], chosen))


def from_pydrake(
    pydrake_scene_graph: Any, scene_graph: SceneGraph, query_object: Any = None
) -> LoadedScene:
    """Register the frames and geometries of a scene graph of pydrake, and return the ids by name.

    Sources, frames and geometries keep their names, poses, roles and properties, and the pairs
    that pydrake filters are filtered. The parent of each frame is the world, since pydrake
    gives no other. With a ``query_object`` of pydrake the frames have its poses as first poses,
    otherwise they wait for one.

    Raises SceneFileError for a shape that is not here and for a frame named ``world``; the scene
    graph is unchanged then.
    """
    inspector = pydrake_scene_graph.model_inspector()
    frames = _Frames(inspector)
    geometries, ids = [], {}
    for id in sorted(inspector.GetAllGeometryIds(), key=lambda g: int(g.get_value())):
        geometry = _geometry(inspector, id, frames)
        geometries.append(geometry)
        if Role.kProximity in geometry.roles:
            ids[id] = Member(geometry.source, geometry.frame, geometry.name)
    statements = tuple(_filters(inspector, ids))
    filters = (DeclarationDescription(statements, Location(_PYDRAKE)),) if statements else ()
    description = SceneDescription(
        _PYDRAKE,
        sources=tuple(dict.fromkeys([*frames.sources(), *(g.source for g in geometries)])),
        frames=tuple(frames.described(query_object)),
        geometries=tuple(geometries),
        filters=filters,
    )
    return register(scene_graph, description)


class _Frames:
    """Names of the frames of an inspector of pydrake."""

    def __init__(self, inspector: Any):
        self._inspector = inspector
        self._world = inspector.world_frame_id()
        self._ids = [id for id in _by_value(inspector.GetAllFrameIds()) if id != self._world]

    def name(self, id: Any) -> str:
        """Return the name of a frame."""
        return WORLD if id == self._world else str(self._inspector.GetName(id))

    def sources(self) -> list[str]:
        """Return the names of the sources of the frames."""
        return [str(self._inspector.GetOwningSourceName(id)) for id in self._ids]

    def described(self, query_object: Any) -> Iterator[FrameDescription]:
        """Yield the frames, all measured in the world."""
        inspector = self._inspector
        for id in self._ids:
            source, name = str(inspector.GetOwningSourceName(id)), self.name(id)
            if name == WORLD:
                raise SceneFileError(f'source {source!r} has a frame {name!r}', _PYDRAKE)
            X_WF = None
            if query_object is not None:
                X_WF = RigidTransform(query_object.GetPoseInWorld(id).GetAsMatrix4())
            yield FrameDescription(
                source,
                name,
                group=int(inspector.GetFrameGroup(id)),
                X_PF=X_WF,
                where=Location(_PYDRAKE, key=f'{source}::{name}'),
            )


def _by_value(ids: Any) -> list[Any]:
    return sorted(ids, key=lambda id: int(id.get_value()))


def _geometry(inspector: Any, id: Any, frames: _Frames) -> GeometryDescription:
    source = str(inspector.GetOwningSourceName(id))
    frame, name = frames.name(inspector.GetFrameId(id)), str(inspector.GetName(id))
    where = Location(_PYDRAKE, key=f'{source}::{frame}/{name}')
    roles = {}
    for role, getter, make in _ROLES:
        if (properties := getattr(inspector, getter)(id)) is not None:
            roles[role] = _properties(properties, make(), inspector, id)
    try:
        shape = _shape(inspector.GetShape(id))
    except (ValueError, RuntimeError) as error:
        raise where.error(str(error)) from error
    X_FG = RigidTransform(inspector.GetPoseInFrame(id).GetAsMatrix4())
    return GeometryDescription(source, frame, name, shape, X_FG, roles, where)


def _shape(shape: Any) -> Shape:
    """Return the shape of the same kind and size; ValueError for a kind that is not here."""
    kind = type(shape).__name__
    if kind in _SIZES:
        make, sizes = _SIZES[kind]
        return make(*(float(getattr(shape, size)()) for size in sizes))
    if kind in ('Mesh', 'Convex'):
        source = shape.source()
        if not source.is_path():
            raise ValueError('a mesh in memory is not read; give it by its file')
        return (Mesh if kind == 'Mesh' else Convex)(str(source.path()), shape.scale3())
    raise ValueError(f'the shape {kind} is not here; there are {", ".join([*_SIZES, "Mesh"])}')


def _properties(
    properties: Any, made: GeometryProperties, inspector: Any, id: Any
) -> GeometryProperties:
    for group in properties.GetGroupNames():
        for name, value in properties.GetPropertiesInGroup(group).items():
            if name == COMPLIANCE:  # a type that pydrake does not know
                made.AddProperty(group, name, _compliance(properties, inspector, id))
            else:
                made.AddProperty(group, name, _value(value.get_value()))
    return made


def _compliance(properties: Any, inspector: Any, id: Any) -> HydroelasticType:
    """Return the hydroelastic type by the mesh that pydrake has made, or by the modulus."""
    mesh = inspector.maybe_get_hydroelastic_mesh(id)
    if mesh is None:
        is_compliant = properties.HasProperty(GROUP, MODULUS)
    else:
        is_compliant = 'Volume' in type(mesh).__name__
    return HydroelasticType.kCompliant if is_compliant else HydroelasticType.kRigid


def _value(value: Any) -> Any:
    """Return the value of a property of pydrake as one of ours."""
    kind = type(value).__name__
    if kind == 'Rgba':
        return Rgba(value.r(), value.g(), value.b(), value.a())
    if kind == 'CoulombFriction':
        return CoulombFriction(value.static_friction(), value.dynamic_friction())
    if kind == 'RenderLabel':
        return RenderLabel(int(value))
    return np.array(value) if isinstance(value, np.ndarray) else value


def _filters(inspector: Any, members: Mapping[Any, Member]) -> Iterator[Statement]:
    """Yield, for each geometry, those after it that pydrake filters it from."""
    partners: dict[Any, list[Member]] = {id: [] for id in members}
    for a, b in combinations(members, 2):
        if inspector.CollisionFiltered(a, b):
            partners[a].append(members[b])
    for id, others in partners.items():
        if others:
            yield Statement(FilterOperation.EXCLUDE_BETWEEN, (members[id],), tuple(others))
