"""The objects of a planning scene as values: read from the live scene, and after a request."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    ArgumentError,
    Convex,
    FrameId,
    GeometryId,
    HalfSpace,
    Mesh,
    QueryObject,
    Role,
    SceneGraphInspector,
    Shape,
)
from drake_geom_ros.live.conversions.allowed_collisions import AllowedCollisions
from drake_geom_ros.live.conversions.collision_objects import (
    OCTOMAP_ID,
    AttachedRequest,
    ObjectRequest,
    Operation,
)
from drake_geom_ros.live.conversions.moveit_shapes import PlacedShape
from drake_geom_ros.live.conversions.names import WORLD, shortened, some_of
from drake_geom_ros.live.conversions.planning_scene import OctomapRequest, SceneRequest
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.link_paddings import Enlargement, merged, unknown_links
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.tolerances import WELDED_STAYS
from drake_geom_ros.scene_files import touched_geometries

SOURCE = 'planning_scene'  # of MoveIt's objects
OCTOMAP_MAP = 'planning_scene'  # the sensed map that MoveIt's octomap becomes


class ObjectShape(NamedTuple):
    """A shape S of an object O; ``geometry`` is None where it is still to be registered."""

    name: str
    shape: Shape
    X_OS: RigidTransform
    is_solid: bool
    geometry: GeometryId | None


class Subframe(NamedTuple):
    """A subframe B of an object O; ``frame`` is None where it is still to be registered."""

    X_OB: RigidTransform
    frame: FrameId | None


@dataclass(frozen=True)
class WorldObject:
    """An object: in the world, with the pose ``X_PO`` there, or attached to the frame ``link``.

    ``frame`` is None where it is still to be registered. ``touching`` are the geometries that an
    attached object may touch.
    """

    X_PO: RigidTransform
    shapes: tuple[ObjectShape, ...] = ()
    subframes: Mapping[str, Subframe] = field(default_factory=dict, hash=False)
    link: FrameId | None = None
    touching: frozenset[GeometryId] = frozenset()
    frame: FrameId | None = None


class PlanningWorld:
    """The objects of a scene after some requests; the scene itself stays as it is.

    ``matrix`` are the collisions that MoveIt allows, None where it never said, and ``links`` what
    it enlarges. ``octomap`` is the one that a request brings, or takes away, None without one.
    ``objects`` are by id, ``notes`` what was not read, or read otherwise, in words. A request that
    is refused raises ArgumentError, which names the object; the world is of no use then.
    """

    def __init__(
        self,
        scene: HeldScene,
        matrix: AllowedCollisions | None = None,
        links: Mapping[str, Enlargement] | None = None,
        query: QueryObject | None = None,
    ) -> None:
        """``query`` is of other poses than those of now: those that a request brings, too."""
        self._scene, self._query = scene, query or scene.query
        self.enlarged = dict(links or {})
        self.octomap: OctomapRequest | None = None
        self.X_WM = RigidTransform()  # of the octomap
        self.before = objects_of(scene)
        self.objects = dict(self.before)
        self.matrix = self.matrix_before = matrix
        self.notes: list[str] = []

    def take_scene(self, request: SceneRequest) -> None:
        """Apply a PlanningScene in MoveIt's order: attached objects, then the world."""
        self.notes += request.notes
        if request.clears_attached:
            self.objects = {k: each for k, each in self.objects.items() if each.link is None}
        if request.clears_world:
            self.objects = {k: each for k, each in self.objects.items() if each.link is not None}
        if request.matrix is not None:
            self.matrix = request.matrix
        self.enlarged = merged(self.enlarged, request.paddings, request.scales)
        self._note_enlarged({*request.paddings, *request.scales})
        for attached in request.attached:
            self.take_attached(attached)
        for each in request.objects:
            self.take(each)
        if request.matrix is not None:
            self._note_strangers(request.matrix)
        self.octomap = request.octomap
        if self.octomap is not None and self.octomap.cells is not None:
            try:
                self.X_WM = self._X_WF(self.octomap.frame) @ self.octomap.X_FM
            except RuntimeError as error:
                raise ArgumentError(f'world.octomap: {error}') from error

    def _note_enlarged(self, names: Collection[str]) -> None:
        """Note where MoveIt treats the enlarged links of a message differently."""
        enlarged = {name: self.enlarged[name] for name in names}
        if any(each != Enlargement() for each in enlarged.values()):
            self.notes.append(
                'paddings and scales of links count between links of robots, too, where MoveIt '
                'leaves them out'
            )
        if strangers := unknown_links(self._scene, enlarged):
            self.notes.append(
                f'link_padding, link_scale: {some_of(strangers)} is no link of a robot of the '
                'scene; they count for robots that come later'
            )

    def links(self) -> dict[str, FrameId]:
        """Return the frames that names of the matrix stand for, without objects.

        A default is about all links of robots, which are added where the matrix has one.
        """
        if self.matrix is None:
            return {}
        model = self._scene.model
        robots, labels = model.robot_names(), model.names.labels
        wanted = set(self.matrix.names()).difference(self.objects)
        if self.matrix.defaults:
            wanted |= {name for source, name in labels.values() if source in robots}
        links = {name: self._link_called(name) for name in sorted(wanted)}
        is_meant = OCTOMAP_ID in wanted or bool(self.matrix.defaults)
        if is_meant and OCTOMAP_MAP in self._scene.maps.by_name:
            links[OCTOMAP_ID] = self._scene.maps.by_name[OCTOMAP_MAP].frame
        return {name: frame for name, frame in links.items() if frame is not None}

    def _link_called(self, name: str) -> FrameId | None:
        names = self._scene.model.names
        frames = [f for f in names.frames_called(name) if names.labels[f][0] != SOURCE]
        return frames[0] if len(frames) == 1 else None

    def _note_strangers(self, matrix: AllowedCollisions) -> None:
        names = self.objects.keys() | self.links().keys() | {OCTOMAP_ID}
        strangers = [name for name in matrix.names() if name not in names]
        if strangers:
            self.notes.append(
                f'allowed_collision_matrix: {some_of(strangers)} is no frame, or several, of the '
                'scene; what it allows counts for objects that come later'
            )

    def allow_again(self) -> None:
        """Apply the matrix to links that were added since."""
        self.matrix_before = None

    def take(self, request: ObjectRequest) -> None:
        """Apply a CollisionObject."""
        self.notes += request.notes
        if request.operation == Operation.REMOVE:
            self._remove(request.id)
            return
        present = self.objects.get(request.id)
        if present is not None and present.link is not None:
            raise ArgumentError(
                f'object {shortened(request.id)!r}: it is attached to {self._name(present.link)}; '
                'detach it first, by an AttachedCollisionObject with REMOVE'
            )
        self._refuse_world(request.id)
        X_WO = self._in_world(request)
        if request.operation == Operation.MOVE:
            self.objects[request.id] = _moved(request, present, X_WO)
        elif not request.shapes:
            raise ArgumentError(f'object {shortened(request.id)!r}: it has no shape')
        elif request.operation == Operation.APPEND and present is not None:
            if request.has_pose and not X_WO.IsNearlyEqualTo(present.X_PO, WELDED_STAYS):
                self.notes.append(
                    f'object {shortened(request.id)!r}: APPEND leaves it where it is; its pose is '
                    'ignored, as by MoveIt'
                )
            self.objects[request.id] = _appended(request, present)
        else:
            self.objects[request.id] = _or_present(_new(request, X_WO), present)

    def take_attached(self, request: AttachedRequest) -> None:
        """Apply an AttachedCollisionObject."""
        part, name = request.object, shortened(request.object.id)
        self.notes += part.notes
        if part.operation == Operation.REMOVE:
            self._detach_asked(request)
            return
        if part.operation == Operation.MOVE:
            raise ArgumentError(
                f'object {name!r}: MOVE does not go with an attached object; send ADD with its '
                'pose, or move its link'
            )
        self._refuse_world(part.id)
        link = self._link(request)
        present = self.objects.get(part.id)
        attached = self._on_link(part, present, link)
        touching = self._touching(part.id, attached.frame, request, link)
        if part.operation == Operation.APPEND and present is not None:
            touching |= present.touching
        attached = replace(attached, link=link, touching=touching)
        self.objects[part.id] = _or_present(attached, present)

    def _on_link(
        self, request: ObjectRequest, present: WorldObject | None, link: FrameId
    ) -> WorldObject:
        """Return the object that an ADD or APPEND puts on a link, with its pose there.

        Without shapes it is the object of the world, which stays where it is.
        """
        name, X_LW = shortened(request.id), self._query.X_WF(link).inverse()
        if not request.shapes:
            if present is None or request.operation == Operation.APPEND:
                raise ArgumentError(
                    f'object {name!r}: it has no shape, and the world has no such object to attach'
                    if present is None
                    else f'object {name!r}: APPEND without a shape adds nothing'
                )
            return replace(present, X_PO=X_LW @ self._X_WO(present))
        if request.operation == Operation.ADD or present is None or present.link is None:
            if present is not None and request.operation == Operation.APPEND:
                self.notes.append(
                    f'object {name!r}: APPEND to an attached object takes the place of the one '
                    'in the world, whose shapes go, as for MoveIt'
                )
            return _new(request, X_LW @ self._in_world(request))
        X_WO = self._in_world(request) if request.has_pose else self._X_WO(present)
        return replace(_appended(request, present), X_PO=X_LW @ X_WO)

    def _remove(self, name: str) -> None:
        """Remove one object of the world, or all with an empty name; attached ones stay."""
        if not name:
            for each in [k for k, state in self.objects.items() if state.link is None]:
                self._forget(each)
            self.objects = {k: each for k, each in self.objects.items() if each.link is not None}
            return
        present = self.objects.get(name)
        if present is None or present.link is not None:
            is_attached = present is not None and present.link is not None
            where = '; one of this id is attached' if is_attached else ''
            self.notes.append(
                f'object {shortened(name)!r}: REMOVE does nothing, for the world has no such '
                f'object{where}'
            )
            return
        del self.objects[name]
        self._forget(name)

    def _forget(self, name: str) -> None:
        if self.matrix is not None and name in self.matrix.entry_names:
            self.matrix = self.matrix.without(name)

    def _detach_asked(self, request: AttachedRequest) -> None:
        """Put attached objects back into the world: one, those of a link, or all."""
        name, link = request.object.id, None
        if request.link:
            link = self._link(request)
        present = self.objects.get(name)
        if not name:
            for each, state in self.objects.items():
                if state.link is not None and link in (None, state.link):
                    self._detach(each)
        elif present is None or present.link is None:
            self.notes.append(
                f'object {shortened(name)!r}: REMOVE does nothing, for no such object is attached'
            )
        elif link not in (None, present.link):
            raise ArgumentError(
                f'object {shortened(name)!r}: it is attached to {self._name(present.link)}, not '
                f'to {shortened(request.link)!r}; leave link_name empty, or name that one'
            )
        else:
            self._detach(name)

    def _detach(self, name: str) -> None:
        present = self.objects[name]
        self.objects[name] = replace(
            present, X_PO=self._X_WO(present), link=None, touching=frozenset()
        )

    # Frames and poses.

    def _refuse_world(self, name: str) -> None:
        if name in (WORLD, self._scene.model.world_frame):
            raise ArgumentError(f'object {name!r}: this is the name of the world frame')

    def _X_WO(self, present: WorldObject) -> RigidTransform:
        """Return the pose of an object in the world."""
        if present.link is None:
            return present.X_PO
        return self._query.X_WF(present.link) @ present.X_PO

    def _in_world(self, request: ObjectRequest) -> RigidTransform:
        """Return X_WO as a request gives it, in the frame that its header names."""
        try:
            return self._X_WF(request.frame) @ request.X_FO
        except RuntimeError as error:
            raise ArgumentError(f'object {shortened(request.id)!r}: {error}') from error

    def _X_WF(self, name: str) -> RigidTransform:
        """Return where a frame is: of the world, of the scene, or of the objects of now."""
        name = name.removeprefix('/')
        scene, names = self._scene, self._scene.model.names
        if not name:
            raise ArgumentError('header.frame_id is empty; it must name a frame of the scene')
        own = self._own_frame(name)
        others = [f for f in names.frames_called(name) if names.labels[f][0] != SOURCE]
        if own is not None and (others or name == scene.model.world_frame):
            raise ArgumentError(
                f'header.frame_id {shortened(name)!r} is the name of an object and of another '
                'frame; rename the object'
            )
        if own is not None:
            return own
        frame = names.frame(name)
        if frame != names.world and names.labels[frame][0] == SOURCE:
            raise ArgumentError(f'header.frame_id {shortened(name)!r} is an object that is gone')
        return scene.poses.pose_in(frame, names.world, self._query)

    def _own_frame(self, name: str) -> RigidTransform | None:
        """Return the pose in the world of an object, or of a subframe ``object/subframe``."""
        for key, each in self.objects.items():
            if name == key:
                return self._X_WO(each)
            subframe = each.subframes.get(name.removeprefix(f'{key}/'))
            if name.startswith(f'{key}/') and subframe is not None:
                return self._X_WO(each) @ subframe.X_OB
        return None

    def _link(self, request: AttachedRequest) -> FrameId:
        """Return the frame that is to carry an object; raises ArgumentError for none."""
        names, name = self._scene.model.names, shortened(request.object.id)
        try:
            link = names.frame(request.link)
            if link == names.world or names.labels[link][0] == SOURCE:
                raise ArgumentError(
                    f'link_name is {request.link!r}; it must be a link of a robot, or another '
                    'frame that no planning scene brought'
                )
            self._scene.poses.pose_in(link, names.world, self._query)
        except RuntimeError as error:
            raise ArgumentError(f'object {name!r}: {error}') from error
        return link

    def _touching(
        self, name: str, frame: FrameId | None, request: AttachedRequest, link: FrameId
    ) -> frozenset[GeometryId]:
        """Return the geometries that an object may touch: of its link, and of ``touch_links``."""
        model = self._scene.model
        touched = set(model.inspector.GetGeometries(link, Role.kProximity))
        own = FrameId.get_new_id() if frame is None else frame  # a new object carries nothing
        for pattern in dict.fromkeys(request.touch_links):
            try:
                touched.update(touched_geometries(model.inspector, model.robots, own, [pattern]))
            except ArgumentError as error:
                self.notes.append(
                    f'object {shortened(name)!r}: {error}; it is ignored, as by MoveIt'
                )
        return frozenset(touched)

    def _name(self, frame: FrameId) -> str:
        return repr(shortened(self._scene.model.names.frame_names[frame]))


def objects_of(scene: HeldScene) -> dict[str, WorldObject]:
    """Return the objects of the live scene by id: frames of the source of planning scenes."""
    inspector, names = scene.model.inspector, scene.model.names
    objects: dict[str, WorldObject] = {}
    own = [f for f, (source, _) in names.labels.items() if source == SOURCE]
    for frame in own:
        if inspector.GetHomeFrame(frame) == names.world and scene.query.is_placed(frame):
            objects[names.labels[frame][1]] = _object_of(scene, frame, own)
    return objects


def _object_of(scene: HeldScene, frame: FrameId, own: Iterable[FrameId]) -> WorldObject:
    inspector, names = scene.model.inspector, scene.model.names
    id, is_attached = names.labels[frame][1], inspector.IsAttached(frame)
    subframes = {
        names.labels[each][1].removeprefix(f'{id}/'): Subframe(scene.query.X_PF(each), each)
        for each in own
        if inspector.GetHomeFrame(each) == frame and scene.query.is_placed(each)
    }
    touching = scene.filters.touch_links.names().get(frame, ()) if is_attached else ()
    return WorldObject(
        scene.query.X_PF(frame),
        tuple(_shapes_of(inspector, frame)),
        subframes,
        inspector.GetParentFrame(frame) if is_attached else None,
        frozenset(map(names.geometry, touching)),
        frame,
    )


def _shapes_of(inspector: SceneGraphInspector, frame: FrameId) -> list[ObjectShape]:
    """Return the shapes on a frame in the order of their numbers."""
    shapes = []
    for geometry in inspector.GetGeometries(frame):
        properties = inspector.GetProximityProperties(geometry)
        is_solid = properties is not None and bool(
            properties.GetPropertyOrDefault('mesh', 'solid', False)
        )
        shapes.append(
            ObjectShape(
                inspector.GetName(geometry),
                inspector.GetShape(geometry),
                inspector.GetPoseInFrame(geometry),
                is_solid,
                geometry,
            )
        )
    return sorted(shapes, key=lambda each: (_number(each.name), each.name))


def _number(name: str) -> int:
    last = name.rpartition('_')[2]
    return int(last) if last.isdecimal() else -1


def _named(placed: Iterable[PlacedShape], first: int = 0) -> tuple[ObjectShape, ...]:
    """Return shapes with names of their kinds and numbers from ``first`` on."""
    return tuple(
        ObjectShape(f'{each.kind}_{k}', each.shape, each.X_OS, each.is_solid, None)
        for k, each in enumerate(placed, first)
    )


def _new(request: ObjectRequest, X_PO: RigidTransform) -> WorldObject:
    subframes = {name: Subframe(X_OB, None) for name, X_OB in request.subframes.items()}
    return WorldObject(X_PO, _named(request.shapes), subframes)


def _or_present(new: WorldObject, present: WorldObject | None) -> WorldObject:
    """Return the object that is there where the new one is the same: it keeps its ids then."""
    if present is None or (new.link, new.touching) != (present.link, present.touching):
        return new
    is_there = new.X_PO.IsNearlyEqualTo(present.X_PO, WELDED_STAYS)
    has_subframes = new.subframes.keys() == present.subframes.keys() and all(
        each.X_OB.IsExactlyEqualTo(present.subframes[name].X_OB)
        for name, each in new.subframes.items()
    )
    has_shapes = len(new.shapes) == len(present.shapes) and all(
        _is_same(a, b) for a, b in zip(new.shapes, present.shapes, strict=True)
    )
    return present if is_there and has_subframes and has_shapes else new


def _is_same(a: ObjectShape, b: ObjectShape) -> bool:
    """Return whether two shapes of an object have the same name, place and surface."""
    if (a.name, a.is_solid) != (b.name, b.is_solid) or not a.X_OS.IsExactlyEqualTo(b.X_OS):
        return False
    if isinstance(a.shape, Convex | Mesh) and type(a.shape) is type(b.shape):
        surfaces = [
            each.surface() if isinstance(each, Mesh) else each.hull_surface()
            for each in (a.shape, b.shape)
            if isinstance(each, Convex | Mesh)
        ]
        return all(np.array_equal(*parts) for parts in zip(*surfaces, strict=True))
    return a.shape == b.shape


def _appended(request: ObjectRequest, present: WorldObject) -> WorldObject:
    """Return an object with more shapes and subframes; those of the same name move."""
    first = 1 + max((_number(each.name) for each in present.shapes), default=-1)
    subframes = dict(present.subframes)
    for name, X_OB in request.subframes.items():
        frame = subframes[name].frame if name in subframes else None
        subframes[name] = Subframe(X_OB, frame)
    shapes = present.shapes + _named(request.shapes, first)
    return replace(present, shapes=shapes, subframes=subframes)


def _moved(
    request: ObjectRequest, present: WorldObject | None, X_WO: RigidTransform
) -> WorldObject:
    """Return an object at another pose; a shape with another pose on it is registered anew."""
    name = shortened(request.id)
    if present is None:
        raise ArgumentError(f'object {name!r}: the world has no such object to MOVE')
    poses = request.shape_poses
    if poses and len(poses) != len(present.shapes):
        raise ArgumentError(
            f'object {name!r}: a MOVE with {len(poses)} poses of shapes; the object has '
            f'{len(present.shapes)}: give a pose for each, or none'
        )
    shapes = present.shapes
    if poses and any(isinstance(each.shape, HalfSpace) for each in shapes):
        raise ArgumentError(
            f'object {name!r}: a MOVE with poses of shapes; the object has a plane, which moves '
            'with the whole object only: send ADD instead'
        )
    if poses:
        shapes = tuple(_placed(each, X_OS) for each, X_OS in zip(shapes, poses, strict=True))
    return replace(present, X_PO=X_WO, shapes=shapes)


def _placed(present: ObjectShape, X_OS: RigidTransform) -> ObjectShape:
    """Return a shape at a pose; with another one than before it is still to be registered."""
    if present.X_OS.IsExactlyEqualTo(X_OS):
        return present
    return present._replace(X_OS=X_OS, geometry=None)
