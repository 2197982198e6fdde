"""Objects of a planning scene that come, go, move, and are attached, in one change."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    CollisionFilterManager,
    FilterId,
    FrameId,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    SceneGraphContext,
    SceneGraphInspector,
    SourceId,
)
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.link_paddings import PADDING, Padded, with_padding
from drake_geom_ros.live.scene.world_objects import (
    SOURCE,
    ObjectShape,
    PlanningWorld,
    WorldObject,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import LoadedScene, TouchLinks

_ALLOWED = f'{SOURCE}: allowed_collision_matrix'  # the owner of its filter


class SceneChangedError(GeometryError):
    """The scene has changed since a change was made for it."""


@dataclass
class _Made:
    """The frames that went, came and moved; the filters of attachments that ended and began."""

    removed: list[FrameId] = field(default_factory=list)
    new: dict[tuple[str, str], FrameId] = field(default_factory=dict)
    X_PFs: dict[FrameId, RigidTransform] = field(default_factory=dict)  # of new and moved ones
    in_world: list[FrameId] = field(default_factory=list)  # of new and moved ones
    detached: set[FrameId] = field(default_factory=set)
    attached: dict[FrameId, str] = field(default_factory=dict)  # ids of objects
    ended: list[FilterId] = field(default_factory=list)
    filters: dict[FrameId, FilterId] = field(default_factory=dict)
    allowed: FilterId | None = None  # of the matrix


def world_change(
    scene: HeldScene, world: PlanningWorld, padded: Mapping[GeometryId, Padded]
) -> Change[HeldScene, None]:
    """Return the change after which the scene holds the objects of a planning world.

    ``padded`` are the paddings of geometries of robots. All of it is made or nothing. It raises
    SceneChangedError where the scene has changed since.
    """
    model = scene.model
    inspector, version = model.inspector, model.model_version
    sources = {inspector.GetName(source): source for source in inspector.GetAllSourceIds()}
    frames = [each.frame for each in world.before.values() if each.frame is not None]
    active = {f: scene.filters.touch_links.filter_of(f) for f in frames}
    filters = {f: filter_id for f, filter_id in active.items() if filter_id is not None}
    owners, links = scene.filters.owners(), world.links()
    matrix_filters = [FilterId(number) for number, owner in owners.items() if owner == _ALLOWED]

    roles = _roles(inspector, changed_paddings(scene, padded))

    def first(scene: HeldScene) -> None:
        if scene.model.model_version != version:
            raise SceneChangedError('the scene changed meanwhile; nothing was changed')

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> _Made:
        if context is None:  # a refusal is to come before anything is removed
            run(graph, graph.CreateDefaultContext())
        return run(graph, context)

    def run(graph: SceneGraph, context: SceneGraphContext | None) -> _Made:
        edit = _Edit(graph, context, sources.get(SOURCE), filters)
        made = edit.run(world)
        edit.allow(world, links, matrix_filters)
        for source, geometry, properties in roles:
            graph.AssignRole(
                context=context,
                source_id=source,
                geometry_id=geometry,
                properties=properties,
                assign=RoleAssign.kReplace,
            )
        return made

    def then(scene: HeldScene, made: _Made) -> None:
        _settle(scene, made, world)

    return Change(on, first, then)


def without_matrix(scene: HeldScene) -> Change[HeldScene, None]:
    """Return the change that ends the filter of the matrix, until it is made again.

    Persistent filters, such as those of a robot that comes, cannot change beside it.
    """
    owners = scene.filters.owners()
    ids = [FilterId(number) for number, owner in owners.items() if owner == _ALLOWED]

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> list[FilterId]:
        return graph.collision_filter_manager(context).RemoveDeclarations(ids)

    def then(scene: HeldScene, ended: list[FilterId]) -> None:
        for filter_id in ended:
            scene.filters.end(filter_id)

    return Change(on, then=then, same_content=True)


def _roles(
    inspector: SceneGraphInspector, paddings: Mapping[GeometryId, float]
) -> list[tuple[SourceId, GeometryId, ProximityProperties]]:
    """Return the sources of geometries and their properties with other paddings [m]."""
    roles = []
    for geometry, padding in paddings.items():
        properties = inspector.GetProximityProperties(geometry)
        assert properties is not None, 'it has the role'
        source = inspector.GetOwningSourceId(geometry)
        roles.append((source, geometry, with_padding(properties, padding)))
    return roles


def changed_paddings(
    scene: HeldScene, padded: Mapping[GeometryId, Padded]
) -> dict[GeometryId, float]:
    """Return the paddings [m] that are other ones than those of the scene."""
    changed = {}
    for geometry, each in padded.items():
        properties = scene.model.inspector.GetProximityProperties(geometry)
        assert properties is not None, 'it has the role'
        if properties.GetPropertyOrDefault(*PADDING, 0.0) != each.now:
            changed[geometry] = each.now
    return changed


def changes_nothing(world: PlanningWorld) -> bool:
    """Return whether a world holds the same objects as before, and allows the same."""
    return (
        world.objects.keys() == world.before.keys()
        and all(each is world.before[name] for name, each in world.objects.items())
        and world.matrix == world.matrix_before
        and world.octomap is None
    )


def adds_shapes(world: PlanningWorld) -> bool:
    """Return whether shapes come, for which kernels may have to be compiled."""
    return any(s.geometry is None for each in world.objects.values() for s in each.shapes)


class _Edit:
    """One run through the objects of a world, on a scene graph or on a context of it."""

    def __init__(
        self,
        graph: SceneGraph,
        context: SceneGraphContext | None,
        source: SourceId | None,
        filters: Mapping[FrameId, FilterId],
    ) -> None:
        self._graph, self._context, self._filters = graph, context, filters
        self._source = source
        self._made = _Made()
        self._on_link: dict[FrameId, list[FrameId]] = {}
        self._has_new_shapes = False

    def run(self, world: PlanningWorld) -> _Made:
        made, before = self._made, world.before
        for name, old in before.items():
            if (present := world.objects.get(name)) is None or present.frame is None:
                self._remove(old)
        for name, each in world.objects.items():
            if before.get(name) is not each:
                self._put(name, each, before.get(name))
            elif each.link is not None and each.frame is not None:
                self._on_link.setdefault(each.link, []).append(each.frame)
        gone = {s.geometry for old in before.values() for s in old.shapes} - {
            s.geometry for each in world.objects.values() for s in each.shapes
        }
        self._renew_filters_beside_detached(world)
        for frame, name in made.attached.items():
            self._let_touch(frame, world.objects[name], gone)
        new = {f: made.X_PFs[f] for f in made.new.values() if f not in made.attached}
        self._graph.SetFirstPoses(context=self._context, poses=FramePoseVector(new))
        if self._context is not None:
            self._context.UpdateFramePoses(FramePoseVector(made.X_PFs))
            _weld(self._graph.collision_filter_manager(self._context), made.in_world)
        return made

    def allow(
        self, world: PlanningWorld, links: Mapping[str, FrameId], old: Iterable[FilterId]
    ) -> None:
        """Exclude the pairs that the matrix allows, in the place of those of before."""
        matrix = world.matrix
        is_same = matrix is world.matrix_before and world.octomap is None
        if matrix is None or (is_same and not self._has_new_shapes):
            return
        manager = self._graph.collision_filter_manager(self._context)
        self._made.ended += manager.RemoveDeclarations(old)
        frames = dict(links)
        for name, each in world.objects.items():
            frame = each.frame or self._made.new[SOURCE, name]
            frames[name] = frame
        declaration, is_empty = CollisionFilterDeclaration(), True
        for name, partners in matrix.partners(frames).items():
            others = GeometrySet(frame_ids=[frames[each] for each in partners])
            declaration.ExcludeBetween(GeometrySet(frame_ids=[frames[name]]), others)
            is_empty = False
        if not is_empty:
            self._made.allowed = manager.ApplyTransient(declaration)

    def _own(self) -> SourceId:
        if self._source is None:
            self._source = self._graph.RegisterSource(context=self._context, name=SOURCE)
        return self._source

    def _remove(self, old: WorldObject) -> None:
        frames = [each.frame for each in old.subframes.values()] + [old.frame]
        for frame in frames:
            if frame is not None:
                self._graph.RemoveFrame(
                    context=self._context, source_id=self._own(), frame_id=frame
                )
                self._made.removed.append(frame)

    def _put(self, name: str, each: WorldObject, old: WorldObject | None) -> None:
        """Register what an object lacks, remove what it has no more, and move it."""
        frame = each.frame
        stood = old if frame is not None else None  # before, with the same frame
        if frame is None:
            frame = self._register_frame(name, None)
        stays = {shape.geometry for shape in each.shapes}
        for shape in () if stood is None else stood.shapes:
            if shape.geometry is not None and shape.geometry not in stays:
                self._graph.RemoveGeometry(
                    context=self._context, source_id=self._own(), geometry_id=shape.geometry
                )
        for shape in each.shapes:
            if shape.geometry is None:
                self._register_geometry(frame, shape)
        for own_name, (X_OB, subframe) in each.subframes.items():
            if subframe is None:
                subframe = self._register_frame(f'{name}/{own_name}', frame)
            self._made.X_PFs[subframe] = X_OB
        self._hang(name, frame, each, stood)

    def _hang(self, name: str, frame: FrameId, each: WorldObject, old: WorldObject | None) -> None:
        """Attach, detach, or move an object, and weld one in the world to it."""
        made, context, own = self._made, self._context, self._own()
        was_attached = old is not None and old.link is not None
        if each.link is not None:
            self._graph.AttachFrame(
                context=context,
                source_id=own,
                frame_id=frame,
                parent_id=each.link,
                X_PF=each.X_PO,
            )
            made.attached[frame] = name
            self._on_link.setdefault(each.link, []).append(frame)
        elif was_attached:
            self._graph.DetachFrame(context=context, source_id=own, frame_id=frame, X_PF=each.X_PO)
            made.detached.add(frame)
        made.X_PFs[frame] = each.X_PO
        self._end_filter(frame)
        if each.link is None:
            self._graph.collision_filter_manager(context).WeldToWorld([frame])
            made.in_world.append(frame)

    def _end_filter(self, frame: FrameId) -> None:
        """Remove the filter of an attached object's touch links, if there is one."""
        manager = self._graph.collision_filter_manager(self._context)
        ended = self._filters.get(frame)
        if ended is not None and manager.RemoveDeclaration(ended):
            self._made.ended.append(ended)

    def _renew_filters_beside_detached(self, world: PlanningWorld) -> None:
        """Have objects get new filters where one that hung on the same link does so no more.

        Their filters exclude the pairs with all that hung there.
        """
        left = {
            old.link
            for name, old in world.before.items()
            if name in world.objects and world.objects[name].link != old.link
        }
        for name, each in world.objects.items():
            frame = each.frame
            if frame is None or each.link is None or frame in self._made.attached:
                continue
            if each.link in left:
                self._end_filter(frame)
                self._made.attached[frame] = name

    def _let_touch(
        self, frame: FrameId, each: WorldObject, gone: Iterable[GeometryId | None]
    ) -> None:
        """Exclude the pairs with what an attached object may touch, and with its neighbours."""
        assert each.link is not None
        touching = sorted(each.touching.difference(gone))
        beside = [other for other in self._on_link[each.link] if other != frame]
        if not touching and not beside:
            return
        declaration = CollisionFilterDeclaration()
        declaration.ExcludeBetween(
            GeometrySet(frame_ids=[frame]), GeometrySet(geometry_ids=touching, frame_ids=beside)
        )
        manager = self._graph.collision_filter_manager(self._context)
        self._made.filters[frame] = manager.ApplyTransient(declaration)

    def _register_frame(self, name: str, parent: FrameId | None) -> FrameId:
        frame = self._graph.RegisterFrame(
            context=self._context,
            source_id=self._own(),
            parent_id=parent,
            frame=GeometryFrame(name),
        )
        self._made.new[SOURCE, name] = frame
        return frame

    def _register_geometry(self, frame: FrameId, shape: ObjectShape) -> None:
        self._has_new_shapes = True
        properties = ProximityProperties()
        if shape.is_solid:
            properties.AddProperty('mesh', 'solid', True)
        instance = GeometryInstance(shape.X_OS, shape.shape, shape.name)
        instance.set_proximity_properties(properties)
        self._graph.RegisterGeometry(
            context=self._context, source_id=self._own(), frame_id=frame, geometry=instance
        )


def _weld(manager: CollisionFilterManager, frames: Iterable[FrameId]) -> None:
    """Weld frames of objects at rest, whose welds a pose elsewhere has ended.

    Those that are welded stay as they are: a change of welds has all pairs looked at again.
    """
    welded = set(manager.welded_frames())
    manager.WeldToWorld([frame for frame in frames if frame not in welded])


def _settle(scene: HeldScene, made: _Made, world: PlanningWorld) -> None:
    """Update poses, welds and filters after a change."""
    scene.poses.forget(made.removed)
    scene.cameras.forget(made.removed)
    scene.filters.forget_frames(made.removed)
    new = set(made.new.values())
    static = dict.fromkeys(new, True)
    X_PFs = {frame: X for frame, X in made.X_PFs.items() if frame in new}
    scene.poses.begin(LoadedScene(frames=made.new, X_PFs=X_PFs, static=static), {})
    for frame, X_PF in made.X_PFs.items():
        if frame in made.detached:
            scene.poses.move_again_from(frame, X_PF, ALWAYS)
        elif frame not in new:
            scene.poses.rest_at(frame, X_PF)
    _weld(scene.model.filter_manager, made.in_world)
    for filter_id in made.ended:
        scene.filters.end(filter_id)
    _note_filters(scene, made, world)


def _note_filters(scene: HeldScene, made: _Made, world: PlanningWorld) -> None:
    touch_links, names = scene.filters.touch_links, scene.model.names
    if made.allowed is not None:
        scene.filters.begin(made.allowed, _ALLOWED, 0.0, is_short=False)
    for frame in made.detached:
        touch_links.end(frame)
    for frame, name in made.attached.items():
        filter_id = made.filters.get(frame)
        if filter_id is None:
            touch_links.end(frame)
            continue
        touching = world.objects[name].touching
        may_touch = tuple(
            sorted(names.geometry_names[g] for g in touching if g in names.geometry_names)
        )
        owner = f'attach {SOURCE}::{name}'
        scene.filters.begin_attached(frame, owner, TouchLinks(filter_id, may_touch))
