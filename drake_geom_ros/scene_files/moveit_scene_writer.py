"""Writes MoveIt's text format of planning scenes, see ``moveit_scene``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import (
    GeometryId,
    PoseError,
    SceneGraph,
    SceneGraphInspector,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.moveit_objects import MoveItObject, ids_of, moveit_objects
from drake_geom_ros.scene_files.moveit_shapes import (
    MoveItBody,
    NoMoveItTypeError,
    moveit_bodies,
)
from drake_geom_ros.scene_files.registration import LoadedScene

_NO_COLOUR = 0.0, 0.0, 0.0, 0.0


class MoveItScene(NamedTuple):
    """A text of MoveIt's format, and in words what it does not hold."""

    text: str
    left_out: tuple[str, ...]


def to_moveit_scene(
    scene_graph: SceneGraph, loaded: LoadedScene, title: str = 'scene'
) -> MoveItScene:
    """Return the bodies of a scene beside its robots, as objects of MoveIt's world.

    A frame with geometries becomes an object at its first pose, an anchored geometry one of its
    own. Robots are left out, since MoveIt has their models, and with them what hangs on them;
    filters, paddings, and roles beside proximity are left out too. A capsule becomes a cylinder
    and two spheres, an ellipsoid the polyhedron around it.

    Raises SceneFileError for shapes that the format does not have, PoseError for objects without
    a pose.
    """
    context = scene_graph.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(context)
    inspector = scene_graph.model_inspector()
    every, of_robots, waiting = moveit_objects(query, loaded.robots, loaded.name_of)
    if waiting:
        raise PoseError(f'{loaded.name_of(waiting[0])} has no pose, which an object must have')
    objects = [each for each in every if each.link is None]
    lines = [title]
    for each, id in zip(objects, ids_of(objects), strict=True):
        lines += _lines_of(each, id, inspector)
    text = '\n'.join([*lines, '.', ''])
    left_out = of_robots + sum(len(each.geometries) for each in every if each.link is not None)
    note = f'{counted(left_out, "geometry")} of robots and on them'
    return MoveItScene(text, (note,) if left_out else ())


def _lines_of(each: MoveItObject, id: str, inspector: SceneGraphInspector) -> list[str]:
    shapes = [lines for g in each.geometries for lines in _shapes_of(g, each.name, inspector)]
    lines = [f'* {id}', *_pose(each.X_PO), str(len(shapes))]
    lines += [line for shape in shapes for line in shape]
    lines.append(str(len(each.subframes)))
    for name, X_OS in each.subframes.items():
        lines += [name, *_pose(X_OS)]
    return lines


def _shapes_of(
    geometry: GeometryId, name: str, inspector: SceneGraphInspector
) -> Iterable[list[str]]:
    """Return the lines of each shape of a geometry, with pose and colour."""
    X_OG = inspector.GetPoseInFrame(geometry)
    properties = inspector.GetProximityProperties(geometry)
    is_solid = properties is not None and properties.GetPropertyOrDefault('mesh', 'solid', False)
    look = inspector.GetIllustrationProperties(geometry)
    colour = _NO_COLOUR
    if look is not None and look.HasProperty('phong', 'diffuse'):
        diffuse = look.GetProperty('phong', 'diffuse')
        colour = diffuse.r(), diffuse.g(), diffuse.b(), diffuse.a()
    try:
        bodies = list(moveit_bodies(inspector.GetShape(geometry), is_solid))
    except NoMoveItTypeError as error:
        raise SceneFileError(f'{name}: {error}, nor in its files', '.scene') from error
    return [[*_body(body), *_pose(X_OG @ body.X_GS), _text(colour)] for body in bodies]


def _body(body: MoveItBody) -> list[str]:
    """Return the lines with type and dimensions of a body."""
    if body.kind != 'mesh':
        return [body.kind, _text(body.sizes)]
    rows = [_text(row) for row in body.vertices]
    rows += [' '.join(map(str, row)) for row in body.triangles.tolist()]
    return ['mesh', f'{len(body.vertices)} {len(body.triangles)}', *rows]


def _pose(X: RigidTransform) -> list[str]:
    row = X.ToArray()
    return [_text(row[:3]), _text(row[3:])]


def _text(numbers: Iterable[float]) -> str:
    """Return numbers in the shortest form that reads back the same."""
    return ' '.join(repr(float(number)) for number in numbers)
