"""Writes MoveIt's text format of planning scenes, see ``moveit_scene``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    FrameId,
    GeometryId,
    HalfSpace,
    Mesh,
    Role,
    SceneGraph,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.registration import LoadedScene

_NO_COLOUR = 0.0, 0.0, 0.0, 0.0
_BELOW = 0.0, 0.0, 1.0, 0.0  # the plane z = 0, whose normal points out


class MoveItScene(NamedTuple):
    """A text of MoveIt's format, and in words what it does not hold."""

    text: str
    left_out: tuple[str, ...]


class _Object(NamedTuple):
    """An object of the world: its full name, its geometries, and frames on it without any."""

    name: str
    X_WO: RigidTransform
    geometries: list[GeometryId]
    subframes: dict[str, RigidTransform]


def to_moveit_scene(
    scene_graph: SceneGraph, loaded: LoadedScene, title: str = 'scene'
) -> MoveItScene:
    """Return the bodies of a scene beside its robots, as objects of MoveIt's world.

    A frame with geometries becomes an object at its first pose, an anchored geometry one of its
    own. Robots are left out, since MoveIt has their models, and with them what hangs on them;
    filters, paddings, and roles beside proximity are left out too. A capsule becomes a cylinder
    and two spheres.

    Raises SceneFileError for shapes that the format does not have, and for objects without a pose.
    """
    context = scene_graph.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(context)
    inspector, robots = scene_graph.model_inspector(), set(loaded.robots)
    world = inspector.world_frame_id()
    by_frame: dict[FrameId, list[GeometryId]] = {}
    left_out = 0
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        frame = inspector.GetFrameId(geometry)
        if _hangs_on(inspector, frame, robots):
            left_out += 1
        else:
            by_frame.setdefault(frame, []).append(geometry)
    objects = []
    for frame, geometries in by_frame.items():
        if frame == world:
            here = RigidTransform()
            objects += [_Object(loaded.name_of(g), here, [g], {}) for g in geometries]
        else:
            subframes = {
                inspector.GetName(f).removeprefix(f'{inspector.GetName(frame)}/'): query.X_PF(f)
                for f in inspector.GetAllFrameIds()
                if inspector.GetParentFrame(f) == frame and f not in by_frame
            }
            name = loaded.name_of(frame)
            objects.append(_Object(name, query.X_WF(frame), geometries, subframes))
    lines = [title]
    for each, id in zip(objects, _ids(objects), strict=True):
        lines += _lines_of(each, id, inspector)
    text = '\n'.join([*lines, '.', ''])
    note = f'{counted(left_out, "geometry")} of robots and on them'
    return MoveItScene(text, (note,) if left_out else ())


def _hangs_on(inspector: SceneGraphInspector, frame: FrameId, robots: set[str]) -> bool:
    """Return whether a frame is one of a robot, or hangs on one."""
    while frame != inspector.world_frame_id():
        if inspector.GetName(inspector.GetOwningSourceId(frame)) in robots:
            return True
        frame = inspector.GetParentFrame(frame)
    return False


def _ids(objects: list[_Object]) -> list[str]:
    """Return ids of objects: their names without their source, where these are unique."""
    short = [each.name.split('::', 1)[1].removeprefix('world/') for each in objects]
    counts = Counter(short)
    return [
        own if counts[own] == 1 else each.name for own, each in zip(short, objects, strict=True)
    ]


def _lines_of(each: _Object, id: str, inspector: SceneGraphInspector) -> list[str]:
    shapes = [lines for g in each.geometries for lines in _shapes_of(g, each.name, inspector)]
    lines = [f'* {id}', *_pose(each.X_WO), str(len(shapes))]
    lines += [line for shape in shapes for line in shape]
    lines.append(str(len(each.subframes)))
    for name, X_OS in each.subframes.items():
        lines += [name, *_pose(X_OS)]
    return lines


def _shapes_of(
    geometry: GeometryId, name: str, inspector: SceneGraphInspector
) -> Iterator[list[str]]:
    """Yield the lines of each shape of a geometry, with pose and colour."""
    X_OG = inspector.GetPoseInFrame(geometry)
    properties = inspector.GetProximityProperties(geometry)
    is_solid = properties is not None and properties.GetPropertyOrDefault('mesh', 'solid', False)
    look = inspector.GetIllustrationProperties(geometry)
    colour = _NO_COLOUR
    if look is not None and look.HasProperty('phong', 'diffuse'):
        diffuse = look.GetProperty('phong', 'diffuse')
        colour = diffuse.r(), diffuse.g(), diffuse.b(), diffuse.a()
    for lines, X_GS in _bodies(inspector.GetShape(geometry), is_solid, name):
        yield [*lines, *_pose(X_OG @ X_GS), _text(colour)]


def _bodies(shape: Shape, is_solid: bool, name: str) -> Iterator[tuple[list[str], RigidTransform]]:
    """Yield the type and dimensions of each body that a shape is made of, with its pose."""
    here = RigidTransform()
    if isinstance(shape, Box):
        yield ['box', _text(shape.size())], here
    elif isinstance(shape, Sphere):
        yield ['sphere', _text([shape.radius()])], here
    elif isinstance(shape, Cylinder):
        yield ['cylinder', _text([shape.radius(), shape.length()])], here
    elif isinstance(shape, Capsule):
        yield ['cylinder', _text([shape.radius(), shape.length()])], here
        for z in (-0.5 * shape.length(), 0.5 * shape.length()):
            yield ['sphere', _text([shape.radius()])], RigidTransform([0.0, 0.0, z])
    elif isinstance(shape, HalfSpace):
        yield ['plane', _text(_BELOW)], here
    elif isinstance(shape, Convex | Mesh):
        if is_solid and isinstance(shape, Mesh):
            vertices, triangles = shape.surface()
        else:
            vertices, triangles = shape.hull_surface()
        rows = [_text(row) for row in vertices]
        rows += [' '.join(map(str, row)) for row in triangles.tolist()]
        yield ['mesh', f'{len(vertices)} {len(triangles)}', *rows], here
    else:
        raise SceneFileError(
            f'{name}: a {type(shape).__name__} has no type in a .scene file of MoveIt', '.scene'
        )


def _pose(X: RigidTransform) -> list[str]:
    row = X.ToArray()
    return [_text(row[:3]), _text(row[3:])]


def _text(numbers: Iterable[float]) -> str:
    """Return numbers in the shortest form that reads back the same."""
    return ' '.join(repr(float(number)) for number in numbers)
