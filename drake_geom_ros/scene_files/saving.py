"""Description of a scene graph through the public interface of SceneGraph."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

from drake_geom_ros.geometry import (
    CollisionFilterManager,
    FrameId,
    GeometryId,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphContext,
    SceneGraphInspector,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    WORLD,
    CameraDescription,
    CliqueDescription,
    DeactivationDescription,
    DeclarationDescription,
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    GroupDescription,
    Member,
    RobotDescription,
    SceneDescription,
    Statement,
)
from drake_geom_ros.scene_files.errors import SceneFileError

_ROLES = (Role.kProximity, Role.kIllustration, Role.kPerception)


def describe(
    scene_graph: SceneGraph,
    X_PFs: Mapping[FrameId, RigidTransform] | None = None,
    robots: Iterable[RobotDescription] = (),
    static: Mapping[FrameId, bool] | None = None,
    cameras: Iterable[tuple[FrameId, CameraDescription]] = (),
    *,
    context: SceneGraphContext | None = None,
) -> SceneDescription:
    """Return the description of a scene, from which ``register`` makes the same scene.

    It omits transient declarations and robots whose URDF came as text. A geometry that was
    registered on another geometry is described on their frame, in the same place.

    ``X_PFs`` are poses of frames in their parents; other frames get none. ``static`` is as in
    ``FrameDescription``. ``cameras`` are described with the current names of their frames. With a
    ``context`` its copy of a scene is described.

    Raises SceneFileError for a frame that is named as the world frame.
    """
    inspector = scene_graph.model_inspector()
    describer = _Describer(inspector if context is None else QueryObject(context).inspector())
    manager = scene_graph.collision_filter_manager(context)
    filters = describer.filters(manager)
    described = describer.describe(X_PFs or {}, robots, filters, static or {})
    welded = {describer.name(id) for id in manager.welded_frames()}
    frames = (replace(f, welded=(f.source, f.name) in welded) for f in described.frames)
    described = replace(described, frames=tuple(frames))
    return replace(described, cameras=tuple(describer.camera(*each) for each in cameras))


def describe_moment(query: QueryObject) -> SceneDescription:
    """Return the description of a query object's scene, with the poses of all posed frames.

    It holds sources, frames and geometries with exact numbers. Filters and robots are omitted,
    since they do not change the distance of two geometries. Raises SceneFileError like
    ``describe``.
    """
    return _Describer(query.inspector()).describe(poses_in_parents(query))


def poses_in_parents(query: QueryObject) -> dict[FrameId, RigidTransform]:
    """Return X_PF by frame of a query object, without frames that have never received a pose."""
    inspector = query.inspector()
    without = {inspector.world_frame_id(), *query.waiting_frames()}
    return {id: query.X_PF(id) for id in inspector.GetAllFrameIds() if id not in without}


class _Describer:
    """Reads one model through its inspector."""

    def __init__(self, inspector: SceneGraphInspector):
        self._inspector = inspector
        self._world = inspector.world_frame_id()

    def describe(
        self,
        X_PFs: Mapping[FrameId, RigidTransform],
        robots: Iterable[RobotDescription] = (),
        filters: Iterable[FilterDescription] = (),
        static: Mapping[FrameId, bool] = MappingProxyType({}),
    ) -> SceneDescription:
        inspector = self._inspector
        internal = inspector.GetOwningSourceId(self._world)
        source_ids = [id for id in inspector.GetAllSourceIds() if id != internal]
        frame_ids = [id for id in inspector.GetAllFrameIds() if id != self._world]
        return SceneDescription(
            sources=tuple(inspector.GetName(id) for id in source_ids),
            robots=tuple(self._robot(robot) for robot in robots if robot.urdf is not None),
            frames=tuple(self._frame(id, X_PFs.get(id), static.get(id)) for id in frame_ids),
            geometries=tuple(self._geometry(id) for id in inspector.GetAllGeometryIds()),
            filters=tuple(filters),
        )

    def name(self, frame_id: FrameId) -> tuple[str, str]:
        """Return the names of a frame's source and of itself."""
        return self._inspector.GetOwningSourceName(frame_id), self._inspector.GetName(frame_id)

    def _frame_name(self, frame_id: FrameId) -> str:
        if frame_id == self._world:
            return WORLD
        name = self._inspector.GetName(frame_id)
        if name == WORLD:
            source = self._inspector.GetOwningSourceName(frame_id)
            raise SceneFileError(
                f'source {source!r} has a frame {name!r}, which in a scene file is the world '
                'frame; rename it with RenameFrame',
                '<scene>',
            )
        return name

    def _frame(
        self, frame_id: FrameId, X_PF: RigidTransform | None, static: bool | None
    ) -> FrameDescription:
        inspector = self._inspector
        attached, mount = inspector.IsAttached(frame_id), self._mount(frame_id)
        home = self._world if mount else inspector.GetHomeFrame(frame_id)
        return FrameDescription(
            inspector.GetOwningSourceName(frame_id),
            self._frame_name(frame_id),
            self._frame_name(home),
            inspector.GetFrameGroup(frame_id),
            X_PF,
            static,
            attached_to=self._member(inspector.GetParentFrame(frame_id)) if attached else None,
            mounted_on=mount,
            part_of_robot=inspector.IsPartOfParent(frame_id) or not attached,
        )

    def _member(self, frame_id: FrameId) -> Member:
        return Member(self._inspector.GetOwningSourceName(frame_id), self._frame_name(frame_id))

    def _mount(self, frame_id: FrameId) -> Member | None:
        """Return the frame of another source that a frame is mounted on, or None."""
        inspector = self._inspector
        home = inspector.GetHomeFrame(frame_id)
        if home == self._world:
            return None
        own = inspector.GetOwningSourceId(frame_id) == inspector.GetOwningSourceId(home)
        return None if own else self._member(home)

    def _robot(self, robot: RobotDescription) -> RobotDescription:
        """Return a robot with the current name of the frame that carries it."""
        if robot.mounted_on is None:
            return robot
        (source,) = (
            id
            for id in self._inspector.GetAllSourceIds()
            if self._inspector.GetName(id) == robot.name
        )
        mounts = filter(None, map(self._mount, self._inspector.FramesForSource(source)))
        return replace(robot, mounted_on=next(mounts, None))

    def _geometry(self, geometry_id: GeometryId) -> GeometryDescription:
        inspector = self._inspector
        roles = {role: inspector.GetProperties(geometry_id, role) for role in _ROLES}
        return GeometryDescription(
            inspector.GetOwningSourceName(geometry_id),
            self._frame_name(inspector.GetFrameId(geometry_id)),
            inspector.GetName(geometry_id),
            inspector.GetShape(geometry_id),
            inspector.GetPoseInFrame(geometry_id),
            {role: properties for role, properties in roles.items() if properties is not None},
        )

    def camera(self, frame_id: FrameId, camera: CameraDescription) -> CameraDescription:
        frame = self._frame_name(frame_id)
        source = '' if frame == WORLD else self._inspector.GetOwningSourceName(frame_id)
        return replace(camera, source=source, frame=frame)

    def filters(self, manager: CollisionFilterManager) -> Iterator[FilterDescription]:
        """Yield the persistent filters."""
        for name, group in manager.filter_groups().items():
            yield GroupDescription(name, self._members(group.members), tuple(group.ignored))
        for name, ids in manager.cliques().items():
            yield CliqueDescription(name, self._members(ids))
        for declaration in manager.declarations():
            statements = (
                Statement(operation, self._members(set_A), self._members(set_B))
                for operation, set_A, set_B in declaration
            )
            yield DeclarationDescription(tuple(statements))
        if inactive := manager.deactivated_geometries():
            yield DeactivationDescription(self._members(inactive))

    def _members(self, ids: Iterable[GeometryId]) -> tuple[Member, ...]:
        """Return the members of a set, a frame instead of its geometries if all are in it."""
        by_frame: defaultdict[FrameId, list[GeometryId]] = defaultdict(list)
        for geometry_id in ids:
            by_frame[self._inspector.GetFrameId(geometry_id)].append(geometry_id)
        members: list[Member] = []
        for frame_id, inside in by_frame.items():
            frame = self._frame_name(frame_id)
            count = self._inspector.NumGeometriesForFrameWithRole(frame_id, Role.kProximity)
            if frame != WORLD and len(inside) == count:
                members.append(Member(self._inspector.GetOwningSourceName(frame_id), frame))
                continue
            for geometry_id in inside:
                source = self._inspector.GetOwningSourceName(geometry_id)
                members.append(Member(source, frame, self._inspector.GetName(geometry_id)))
        return tuple(members)
