"""The scene as MoveIt's message for RViz and MoveIt: ``~/planning_scene``, on demand.

The message is a diff, which leaves what MoveIt knows itself: its robots, allowed collisions and
paddings. It holds all bodies beside those of robots, in the world or on links, and removes those
that an earlier message brought and that are gone. So it is complete for whoever comes late.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import (
    FrameId,
    GeometryId,
    ProximityProperties,
    SceneGraphInspector,
)
from drake_geom_ros.live.conversions.collision_objects import OWN_TYPE, Operation
from drake_geom_ros.live.conversions.fields import fill_pose
from drake_geom_ros.live.conversions.names import MAPS, some_of
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.scene.world_objects import SOURCE
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.moveit_objects import MoveItObject, ids_of, moveit_objects
from drake_geom_ros.scene_files.moveit_shapes import (
    MoveItBody,
    NoMoveItTypeError,
    moveit_bodies,
)

PERIOD = 0.5  # [s] between two looks whether something is to be published


class PlanningSceneTypes(NamedTuple):
    """The classes of messages."""

    PlanningScene: Any
    CollisionObject: Any
    AttachedCollisionObject: Any
    SolidPrimitive: Any
    Mesh: Any
    MeshTriangle: Any
    Plane: Any
    Pose: Any
    Point: Any


class PlanningSceneTopic:
    """Publishes the bodies of a live scene as objects of MoveIt, when they changed."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        types: PlanningSceneTypes,
        node: str,
        taken: Callable[[], Collection[str]],
        did: Callable[[int, float], None],
        tell: Callable[[str], None],
    ) -> None:
        """``node`` is the full name of the node, which its objects bear.

        ``taken()`` returns the ids of objects that MoveIt's messages brought: these are left out.
        ``did(count, seconds)`` is called for each message, ``tell(text)`` logs what it lacks.
        """
        self._live, self._publisher, self._types, self._node = live, publisher, types, node
        self._taken, self._did, self._tell = taken, did, tell
        self._last: Any = None
        self._version = -1
        self._told = ''
        self._published = set[str]()  # ids of the world that a message ever brought
        self._attached = set[str]()
        self._shapes: dict[GeometryId, list[MoveItBody]] = {}

    def publish(self) -> None:
        """Publish the scene if somebody listens and it is another one than before."""
        if not self._publisher.get_subscription_count():
            self._last = None  # whoever comes gets it as it is then
            return
        start = time.perf_counter()
        with self._live.reading() as scene:
            view, robots = scene.view(), scene.model.robot_names()
            version = scene.model.model_version
        if version != self._version:  # shapes may be other ones by now
            self._version, self._shapes = version, {}
        objects, lacking = self._objects_of(view, robots)
        mark = version, dict(view.touch_links), tuple(_marks(objects))
        if mark == self._last:
            return
        self._last = mark
        self._publisher.publish(self._message(view, objects))
        self._did(len(objects), time.perf_counter() - start)
        if lacking != self._told:
            self._told = lacking
            if lacking:
                self._tell(f'~/planning_scene lacks {lacking}')

    def _objects_of(
        self, view: SceneView, robots: Collection[str]
    ) -> tuple[dict[str, MoveItObject], str]:
        """Return objects by id, and in words what they lack."""
        names, taken = view.names, self._taken()
        inspector = view.query.inspector()

        def name_of(id: FrameId | GeometryId) -> str:
            if isinstance(id, FrameId):
                return names.frame_names[id]
            return names.geometry_names[id]

        every = moveit_objects(view.query, robots, name_of)
        objects, lacking = [], [names.frame_names[frame] for frame in every.waiting]
        for each in every.objects:
            source, _, own = each.name.partition('::')
            if source == SOURCE and own in taken:
                continue
            if source == MAPS or not all(self._bodies(inspector, g) for g in each.geometries):
                lacking.append(each.name)
                continue
            objects.append(each)
        words = (
            f'{counted(len(lacking), "body")}, which MoveIt has no type for, or which wait for a '
            f'pose: {some_of(lacking)}'
        )
        return dict(zip(ids_of(objects), objects, strict=True)), words if lacking else ''

    def _bodies(self, inspector: SceneGraphInspector, geometry: GeometryId) -> list[MoveItBody]:
        """Return the bodies of a geometry; none where MoveIt has no type for it."""
        shape, properties = (
            inspector.GetShape(geometry),
            inspector.GetProximityProperties(geometry),
        )
        bodies = self._shapes.get(geometry)
        if bodies is None:
            try:
                bodies = list(moveit_bodies(shape, _is_solid(properties)))
            except NoMoveItTypeError:
                bodies = []
            self._shapes[geometry] = bodies
        return bodies

    def _message(self, view: SceneView, objects: Mapping[str, MoveItObject]) -> Any:
        message = self._types.PlanningScene()
        message.is_diff = message.robot_state.is_diff = True
        attached = {id: each for id, each in objects.items() if each.link is not None}
        message.robot_state.attached_collision_objects = [
            *(self._detached(id) for id in sorted(self._attached - attached.keys())),
            *(self._on_link(view, id, each) for id, each in attached.items()),
        ]
        message.world.collision_objects = [
            *(self._removed(id) for id in sorted(self._published - objects.keys())),
            *(
                self._added(view, id, each, view.moment.world_frame)
                for id, each in objects.items()
                if each.link is None
            ),
        ]
        self._published |= objects.keys() - attached.keys()
        self._attached |= attached.keys()
        return message

    def _removed(self, id: str) -> Any:
        return self._types.CollisionObject(id=id, operation=_operation(Operation.REMOVE))

    def _detached(self, id: str) -> Any:
        return self._types.AttachedCollisionObject(object=self._removed(id))

    def _on_link(self, view: SceneView, id: str, each: MoveItObject) -> Any:
        """Return an object on a link, with the links that it may touch."""
        assert each.link is not None
        link = view.names.labels[each.link][1]
        may_touch = () if each.frame is None else view.touch_links.get(each.frame, ())
        touched = (name.split('::', 1)[1] for name in may_touch)
        links = dict.fromkeys([link, *(name.split('/', 1)[0] for name in touched)])
        return self._types.AttachedCollisionObject(
            link_name=link, object=self._added(view, id, each, link), touch_links=list(links)
        )

    def _added(self, view: SceneView, id: str, each: MoveItObject, frame: str) -> Any:
        """Return an object with its shapes, measured in a frame."""
        message = self._types.CollisionObject(id=id, operation=_operation(Operation.ADD))
        message.header.frame_id = frame
        message.type.key, message.type.db = OWN_TYPE, self._node
        fill_pose(message.pose, each.X_PO)
        inspector = view.query.inspector()
        for geometry in each.geometries:
            X_OG = inspector.GetPoseInFrame(geometry)
            for body in self._bodies(inspector, geometry):
                self._put(message, body, X_OG @ body.X_GS)
        message.subframe_names = list(each.subframes)
        message.subframe_poses = [self._pose(X) for X in each.subframes.values()]
        return message

    def _put(self, message: Any, body: MoveItBody, X_OS: RigidTransform) -> None:
        types, sizes = self._types, list(body.sizes)
        kinds = SimpleNamespace(
            box=types.SolidPrimitive.BOX,
            sphere=types.SolidPrimitive.SPHERE,
            cylinder=types.SolidPrimitive.CYLINDER,
        )
        if body.kind == 'mesh':
            message.meshes.append(self._mesh(body))
            message.mesh_poses.append(self._pose(X_OS))
        elif body.kind == 'plane':
            message.planes.append(types.Plane(coef=sizes))
            message.plane_poses.append(self._pose(X_OS))
        else:
            if body.kind == 'cylinder':
                sizes.reverse()  # the height is first
            kind = getattr(kinds, body.kind)
            message.primitives.append(types.SolidPrimitive(type=kind, dimensions=sizes))
            message.primitive_poses.append(self._pose(X_OS))

    def _mesh(self, body: MoveItBody) -> Any:
        types = self._types
        points = [types.Point(x=x, y=y, z=z) for x, y, z in body.vertices.tolist()]
        corners = np.asarray(body.triangles, dtype=np.uint32)
        triangles = [types.MeshTriangle(vertex_indices=row) for row in corners]
        return types.Mesh(vertices=points, triangles=triangles)

    def _pose(self, X: RigidTransform) -> Any:
        message = self._types.Pose()
        fill_pose(message, X)
        return message


def _operation(operation: Operation) -> bytes:
    return bytes([operation])


def _is_solid(properties: ProximityProperties | None) -> bool:
    return properties is not None and bool(properties.GetPropertyOrDefault('mesh', 'solid', False))


def _marks(objects: Mapping[str, MoveItObject]) -> Iterator[tuple[str, FrameId | None, bytes]]:
    """Yield of each object what is another one where its message is."""
    for id, each in objects.items():
        poses = [each.X_PO, *each.subframes.values()]
        yield id, each.link, b''.join(X.ToArray().tobytes() for X in poses)
