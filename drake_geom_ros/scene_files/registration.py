"""Registration of scene descriptions through the public interface of SceneGraph."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    Mesh,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphContext,
    SourceId,
    UnknownIdError,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import ProximityRule, check_zone
from drake_geom_ros.scene_files.description import (
    WORLD,
    AwaitedFilter,
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
)
from drake_geom_ros.scene_files.drake_names import drake_name
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.touch_links import (
    TouchLinks,
    full_names,
    touch_filter,
    touched_geometries,
)


class GeometriesByName(dict[tuple[str, str, str], GeometryId]):
    """Ids of geometries by source, frame and name, or the name that Drake gives a geometry.

    Its keys are the own names; ``[]`` also finds a geometry by Drake's name, where no own name of
    its link is equal.
    """

    def __init__(self) -> None:
        super().__init__()
        self.by_drake_name: dict[tuple[str, str, str], GeometryId] = {}

    def __missing__(self, key: tuple[str, str, str]) -> GeometryId:
        return self.by_drake_name[key]


@dataclass(frozen=True)
class LoadedScene:
    """Registered ids by name, and the parts of a description that a scene graph does not hold.

    - ``sources``: ids by name.
    - ``frames``: ids by (source, frame).
    - ``geometries``: ids of those with the proximity role, by (source, frame, geometry); the
      frame is ``world`` if they are anchored. ``[]`` also finds them by Drake's names.
    - ``geometry_ids``: all geometries, in the order of the description.
    - ``robots``: by name, with the URDF and base pose for forward kinematics.
    - ``X_PFs``: initial poses that the description gives; new contexts begin with them.
    - ``static``: for frames whose description says so, whether the pose never becomes stale.
    - ``cameras``: with the frames that they are on.
    - ``warnings``: those of the description, and the vertices welded to make meshes solid.
    - ``awaited``, ``rules``: the awaited filters and proximity rules of the description.
    - ``gone_after``: the seconds without a pose after which frames leave that come and go.
    - ``touch_links``: the transient filters of attached frames that may touch something.
    """

    sources: Mapping[str, SourceId] = field(default_factory=dict)
    frames: Mapping[tuple[str, str], FrameId] = field(default_factory=dict)
    geometries: Mapping[tuple[str, str, str], GeometryId] = field(default_factory=dict)
    geometry_ids: tuple[GeometryId, ...] = ()
    robots: Mapping[str, RobotDescription] = field(default_factory=dict)
    X_PFs: Mapping[FrameId, RigidTransform] = field(default_factory=dict)
    static: Mapping[FrameId, bool] = field(default_factory=dict)
    cameras: tuple[tuple[FrameId, CameraDescription], ...] = ()
    warnings: tuple[str, ...] = ()
    awaited: tuple[AwaitedFilter, ...] = ()
    rules: tuple[ProximityRule, ...] = ()
    touch_links: Mapping[FrameId, TouchLinks] = field(default_factory=dict)
    gone_after: Mapping[FrameId, float] = field(default_factory=dict)

    def name_of(self, id: GeometryId | FrameId | int) -> str:
        """Return ``source::frame/geometry``, or ``source::frame`` of a FrameId.

        A number is the value of a GeometryId, as in arrays of results; the name of 0 is empty.
        Raises UnknownIdError for an id that this scene did not register.
        """
        names: Mapping[GeometryId | FrameId | int, str] = self._names
        if not isinstance(id, FrameId):
            id = id.get_value() if isinstance(id, GeometryId) else int(id)
        if id not in names:
            raise UnknownIdError(f'{id!r} is nothing that this scene has registered by name')
        return names[id]

    @cached_property
    def first_poses(self) -> FramePoseVector:
        """The poses ``X_PFs`` as a FramePoseVector."""
        return FramePoseVector(self.X_PFs)

    def names_of(self, ids: Iterable[GeometryId | FrameId | int]) -> list[str]:
        """Return ``name_of`` each id, for example of ``id_A`` of results."""
        return [self.name_of(id) for id in ids]

    @cached_property
    def _names(self) -> dict[GeometryId | FrameId | int, str]:
        names: dict[GeometryId | FrameId | int, str] = {
            id.get_value(): f'{source}::{frame}/{name}'
            for (source, frame, name), id in self.geometries.items()
        }
        names[0] = ''
        return names | {id: '::'.join(key) for key, id in self.frames.items()}


def apply_filter(scene_graph: SceneGraph, entry: FilterDescription) -> None:
    """Apply a filter to the contents of a scene graph.

    Raises SceneFileError that names its place; the scene graph is unchanged then.
    """
    # The filter may be several statements, so it is rehearsed on a copy.
    for context in (scene_graph.CreateDefaultContext(), None):
        _Registration.of_all(scene_graph, context).apply(entry)


def register(scene_graph: SceneGraph, description: SceneDescription) -> LoadedScene:
    """Register all of a description, or nothing, and return the ids.

    The registration is rehearsed on a context, a copy that refuses what the scene graph would.
    Raises SceneFileError, with the place in the description, for everything that the scene graph
    refuses: a source or geometry name that is taken, an unknown parent, persistent filters while
    transient ones are active, and so on.
    """
    warm_up(scene_graph, description, scene_graph.CreateDefaultContext())
    return register_rehearsed(scene_graph, description)


def register_rehearsed(scene_graph: SceneGraph, description: SceneDescription) -> LoadedScene:
    """Register like ``register``, without the rehearsal that ``warm_up`` just did."""
    return _registered(scene_graph, description, None)


def warm_up(
    scene_graph: SceneGraph, description: SceneDescription, context: SceneGraphContext
) -> LoadedScene:
    """Register all of a description in a context only; raises what ``register`` would raise.

    This reads the mesh files, whose contents are cached for ``register``.
    """
    return _registered(scene_graph, description, context)


def _registered(
    scene_graph: SceneGraph, description: SceneDescription, context: SceneGraphContext | None
) -> LoadedScene:
    """Register all of a description, and set its initial poses for new contexts."""
    loaded = _Registration(scene_graph, description, context).run()
    scene_graph.SetFirstPoses(context=context, poses=loaded.first_poses)
    return loaded


class _Registration:
    """One run through a description, into a scene graph or a context of it."""

    def __init__(
        self,
        scene_graph: SceneGraph,
        description: SceneDescription,
        context: SceneGraphContext | None = None,
    ):
        self._scene_graph = scene_graph
        self._description = description
        self._context = context
        self._sources: dict[str, SourceId] = {}
        self._frames: dict[tuple[str, str], FrameId] = {}
        self._geometries = GeometriesByName()
        self._geometry_ids: list[GeometryId] = []
        self._welded: list[str] = []

    def run(self) -> LoadedScene:
        description = self._description
        for name in description.sources:
            with _blame(Location(description.file, key=f'source {name}')):
                self._sources[name] = self._scene_graph.RegisterSource(
                    context=self._context, name=name
                )
        for frame in description.frames:
            with _blame(frame.where):
                self._register_frame(frame)
        for frame in description.frames:
            if frame.mounted_on is not None:
                with _blame(frame.where):
                    self._mount(frame, frame.mounted_on)
        for frame in description.frames:
            if frame.attached_to is not None:
                with _blame(frame.where):
                    self._attach(frame, frame.attached_to)
        for geometry in description.geometries:
            with _blame(geometry.where):
                self._register_geometry(geometry)
        for kind, entries in groupby(description.filters, type):
            if kind is CliqueDescription:
                self._add_cliques([e for e in entries if isinstance(e, CliqueDescription)])
            else:
                for entry in entries:
                    self.apply(entry)
        touch_links: dict[FrameId, TouchLinks] = {}
        for frame in description.frames:  # last: no persistent filter follows a transient one
            if frame.touch_links:
                with _blame(frame.where):
                    touch_links |= self._let_touch(frame)
        return LoadedScene(
            self._sources,
            self._frames,
            self._geometries,
            tuple(self._geometry_ids),
            {robot.name: robot for robot in description.robots},
            {
                self._frames[frame.source, frame.name]: frame.X_PF
                for frame in description.frames
                if frame.X_PF is not None
            },
            {
                self._frames[frame.source, frame.name]: frame.static
                for frame in description.frames
                if frame.static is not None
            },
            tuple((self._frame_id(c.source, c.frame), c) for c in description.cameras),
            (*description.warnings, *self._welded),
            description.awaited,
            description.rules,
            touch_links,
            {
                self._frames[frame.source, frame.name]: frame.gone_after
                for frame in description.frames
                if frame.gone_after is not None
            },
        )

    @classmethod
    def of_all(cls, scene_graph: SceneGraph, context: SceneGraphContext | None) -> _Registration:
        """Return a registration with the ids of everything that a scene graph has."""
        run = cls(scene_graph, SceneDescription(), context)
        inspector = scene_graph.model_inspector()
        for frame in inspector.GetAllFrameIds():
            if frame != inspector.world_frame_id():
                name = inspector.GetOwningSourceName(frame), inspector.GetName(frame)
                run._frames[name] = frame
        for id in inspector.GetAllGeometryIds(Role.kProximity):
            frame = inspector.GetFrameId(id)
            on = WORLD if frame == inspector.world_frame_id() else inspector.GetName(frame)
            run._geometries[inspector.GetOwningSourceName(id), on, inspector.GetName(id)] = id
        return run

    def apply(self, entry: FilterDescription) -> None:
        """Apply a filter; raises SceneFileError that names its place."""
        with _blame(entry.where):
            self._apply(entry)

    def _frame_id(self, source: str, name: str) -> FrameId:
        if name == WORLD:
            return self._scene_graph.world_frame_id()
        if (source, name) not in self._frames:
            frames = ', '.join(frame for owner, frame in self._frames if owner == source)
            raise RuntimeError(
                f'source {source!r} has no frame {name!r} so far; it has {frames or "none"}, '
                f'and there is {WORLD!r}'
            )
        return self._frames[source, name]

    def _register_frame(self, frame: FrameDescription) -> None:
        if frame.name == WORLD:
            raise RuntimeError(f'a frame cannot be called {WORLD!r}: that is the world frame')
        self._frames[frame.source, frame.name] = self._scene_graph.RegisterFrame(
            context=self._context,
            source_id=self._sources[frame.source],
            parent_id=self._frame_id(frame.source, frame.parent),
            frame=GeometryFrame(frame.name, frame.group),
        )
        if frame.welded:
            manager = self._scene_graph.collision_filter_manager(self._context)
            manager.WeldToWorld([self._frames[frame.source, frame.name]])

    def _mount(self, frame: FrameDescription, on: Member) -> None:
        self._scene_graph.MountFrame(
            context=self._context,
            source_id=self._sources[frame.source],
            frame_id=self._frames[frame.source, frame.name],
            parent_id=self._frame_id(on.source, on.frame),
        )

    def _attach(self, frame: FrameDescription, to: Member) -> None:
        if frame.X_PF is None:
            raise RuntimeError('attached_to needs the pose in the frame that it follows')
        self._scene_graph.AttachFrame(
            context=self._context,
            source_id=self._sources[frame.source],
            frame_id=self._frames[frame.source, frame.name],
            parent_id=self._frame_id(to.source, to.frame),
            X_PF=frame.X_PF,
            is_part=frame.part_of_robot,
        )

    def _let_touch(self, frame: FrameDescription) -> dict[FrameId, TouchLinks]:
        """Exclude an attached frame from what it may touch; return the filter by its frame."""
        inspector = self._scene_graph.model_inspector()
        if self._context is not None:
            inspector = QueryObject(self._context).inspector()
        frame_id, robots = self._frames[frame.source, frame.name], self._description.robots
        touched = touched_geometries(inspector, robots, frame_id, frame.touch_links)
        if not touched:
            return {}
        manager = self._scene_graph.collision_filter_manager(self._context)
        filter_id = manager.ApplyTransient(touch_filter(inspector, frame_id, touched))
        return {frame_id: TouchLinks(filter_id, full_names(inspector, touched))}

    def _register_geometry(self, geometry: GeometryDescription) -> None:
        source_id = self._sources[geometry.source]
        check_zone(geometry.shape, geometry.roles.get(Role.kIllustration))
        geometry_id = self._scene_graph.RegisterGeometry(
            context=self._context,
            source_id=source_id,
            frame_id=self._frame_id(geometry.source, geometry.frame),
            geometry=GeometryInstance(geometry.X_FG, geometry.shape, geometry.name),
        )
        for properties in geometry.roles.values():
            self._scene_graph.AssignRole(
                context=self._context,
                source_id=source_id,
                geometry_id=geometry_id,
                properties=properties,
            )
        self._geometry_ids.append(geometry_id)
        if Role.kProximity in geometry.roles:
            self._geometries[geometry.source, geometry.frame, geometry.name] = geometry_id
            if name := drake_name(geometry.roles[Role.kProximity]):
                key = geometry.source, geometry.frame, name
                self._geometries.by_drake_name[key] = geometry_id
            self._note_weldings(geometry)

    def _note_weldings(self, geometry: GeometryDescription) -> None:
        """Add warnings about vertices that were welded to make a mesh solid."""
        properties, shape = geometry.roles[Role.kProximity], geometry.shape
        if isinstance(shape, Mesh) and properties.GetPropertyOrDefault('mesh', 'solid', False):
            name = f'{geometry.source}::{geometry.frame}/{geometry.name}'
            self._welded += [f'{name}: {welding}' for welding in shape.weldings()]

    def _set(self, members: tuple[Member, ...]) -> GeometrySet:
        geometry_ids = [
            self._geometries[member.source, member.frame, member.geometry]
            for member in members
            if member.geometry is not None
        ]
        frame_ids = [
            self._frame_id(member.source, member.frame)
            for member in members
            if member.geometry is None
        ]
        return GeometrySet(geometry_ids=geometry_ids, frame_ids=frame_ids)

    def _apply(self, entry: FilterDescription) -> None:
        manager = self._scene_graph.collision_filter_manager(self._context)
        if isinstance(entry, GroupDescription):
            manager.AddGroup(entry.name, self._set(entry.members), entry.ignores)
        elif isinstance(entry, CliqueDescription):
            manager.AddClique(entry.name, self._set(entry.members))
        elif isinstance(entry, DeactivationDescription):
            manager.Deactivate(self._set(entry.members))
        else:
            manager.Apply(self._declaration(entry))

    def _add_cliques(self, entries: Sequence[CliqueDescription]) -> None:
        manager = self._scene_graph.collision_filter_manager(self._context)
        try:
            manager.AddCliques([(entry.name, self._set(entry.members)) for entry in entries])
        except RuntimeError:  # one by one, for an error that names its place
            for entry in entries:
                self.apply(entry)

    def _declaration(self, entry: DeclarationDescription) -> CollisionFilterDeclaration:
        declaration = CollisionFilterDeclaration()
        for statement in entry.statements:
            sets = (statement.set_a, statement.set_b)
            operands = sets if statement.operation.takes_two_sets else sets[:1]
            declaration.Declare(statement.operation, *map(self._set, operands))
        return declaration


@contextmanager
def _blame(where: Location) -> Iterator[None]:
    """Turn an error of the scene graph into a SceneFileError that names the place."""
    try:
        yield
    except RuntimeError as error:
        raise where.error(str(error)) from error
