"""The live scene while it is held to be changed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ArgumentError,
    FilterError,
    FilterId,
    FrameId,
    FramePoseVector,
    SceneGraph,
    SceneGraphContext,
    SourceId,
)
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.names import WORLD, some_of
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changing_scene import ChangingScene, Place
from drake_geom_ros.live.scene.clocks import ALWAYS, Since
from drake_geom_ros.live.scene.feeders import MESSAGES, OBSTACLES, TF
from drake_geom_ros.live.scene.held_scene import shared_context
from drake_geom_ros.live.scene.pose_ages import PosedFrames
from drake_geom_ros.live.scene.pose_history import Parts
from drake_geom_ros.live.scene.scene_draft import SceneDraft
from drake_geom_ros.live.scene.scene_snapshot import MAPS
from drake_geom_ros.live.scene.twists import stamp_of
from drake_geom_ros.live.scene.waiting_maps import WaitingMaps, waiting_maps
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import (
    CameraDescription,
    LoadedScene,
    SceneDescription,
    register,
    register_rehearsed,
    warm_up,
)

_Result = TypeVar('_Result')
_HAS_MAPS = (
    f'the scene has a source {MAPS!r}, which is that of the sensed maps of this node; '
    'give it another name'
)
_IS_THE_WORLD = (
    'the frame {!r} is called as the parameter world_frame is, so it is the world: the pose that '
    'the scene file gives it is left out; give it none, or choose another world_frame'
)


@dataclass(frozen=True)
class PreparedScene:
    """A scene of its own that is ready to take the place of the live one.

    ``draft`` has its tables, where these were made ready, and ``maps`` wait in it.
    """

    scene_graph: SceneGraph
    context: SceneGraphContext  # shares it
    loaded: LoadedScene
    maps: WaitingMaps
    draft: SceneDraft | None = None


def prepared(
    description: SceneDescription,
    maps: Sequence[str] = (),
    margin: float = 0.0,
    accuracy: str = 'exact',
) -> PreparedScene:
    """Return what is described, its kernels compiled; raises RuntimeError for what cannot be.

    Takes long and holds nothing: so the live scene is replaced in a moment. ``maps`` wait in it,
    with a margin [m].
    """
    if maps and MAPS in description.sources:
        raise ArgumentError(_HAS_MAPS)
    scene_graph = SceneGraph(accuracy=accuracy)
    loaded = register(scene_graph, description)
    waiting = WaitingMaps(None, {})
    if maps:
        waiting = waiting_maps(scene_graph, None, None, maps, margin)
    context = shared_context(scene_graph)
    context.UpdateFramePoses(loaded.first_poses)
    context.compile_kernels()
    return PreparedScene(scene_graph, context, loaded, waiting)


class EditableScene(ChangingScene):
    """The scene and what may be changed of it. What raises RuntimeError has changed nothing."""

    @property
    def scene_graph(self) -> SceneGraph:
        """The scene graph, to register on and to filter."""
        return self._scene_graph

    def make(self, change: Change[EditableScene, _Result]) -> _Result:
        """Make a change at once, and return its result; see ``LiveScene.change``."""
        change.first(self)
        made = change.on(self._scene_graph, None)
        self._robots = change.robots_after(self._robots)  # before their frames are named
        return change.then(self, made)

    def take_over(self, draft: SceneDraft) -> bool:
        """Become what a draft has become; return False where the scene has changed since.

        In a moment, whatever was changed: all that cycles need was made by the draft.
        """
        if not self._scene_graph.TakeOver(draft.context, self._context):
            return False
        self._go_on_as(draft)
        return True

    def _go_on_as(self, draft: SceneDraft) -> None:
        """Have the tables of a draft whose content the scene has."""
        if (named := draft.named) is not None:
            named.joints.go_on_as(self._joints)
            self._robots = draft.robots
            self._names, self._reader, self._joints = named.names, named.reader, named.joints
            self._named_version = self.model_version
            self._attached = self.names_version, named.attached
        self.rules.offer(draft.rules)

    def add(self, description: SceneDescription) -> tuple[int, int]:
        """Register what is described at once; return frames, geometries added."""
        return self.make(self.addition(description))

    def addition(self, description: SceneDescription) -> Change[EditableScene, tuple[int, int]]:
        """Return the registration of what is described: so many frames and geometries.

        Frames stand where the description puts them until their first pose comes.
        """

        def first(scene: EditableScene) -> None:
            for camera in description.cameras:
                scene._refuse_taken(camera.name)
            scene._refuse_cameras(description.cameras)

        def then(scene: EditableScene, loaded: LoadedScene) -> tuple[int, int]:
            return scene._take(loaded)

        def on(graph: SceneGraph, context: SceneGraphContext | None) -> LoadedScene:
            return _registered(graph, description, context)

        return Change(on, first, then, description.robots, rules=description.rules)

    def swap(self, sources: Sequence[SourceId], description: SceneDescription) -> tuple[int, int]:
        """Put what is described in the place of sources at once; see ``exchange``."""
        return self.make(self.exchange(sources, description))

    def exchange(
        self, sources: Sequence[SourceId], description: SceneDescription
    ) -> Change[EditableScene, tuple[int, int]]:
        """Return the registration of what is described in the place of sources.

        Its result are the numbers of frames and geometries added. Frames of the same source and
        name, of which nothing else is said, keep their poses. That of sensed maps is refused.
        """
        for source in sources:
            self.refuse_maps(source)
        names = [self.inspector.GetName(source) for source in sources]
        places: dict[tuple[str, str], Place] = {}

        def first(scene: EditableScene) -> None:
            nonlocal places
            scene._refuse_exchange(sources, description)
            places = scene.places_of(sources)

        def on(graph: SceneGraph, context: SceneGraphContext | None) -> _Exchanged:
            if context is None:  # a refusal is to come before anything is removed
                _exchanged(graph, graph.CreateDefaultContext(), sources, description)
            return _exchanged(graph, context, sources, description)

        def then(scene: EditableScene, made: _Exchanged) -> tuple[int, int]:
            for name, frames in zip(names, made.removed, strict=True):
                scene.forget_source(name, frames)
            scene.replaced += 1
            added = scene._take(made.loaded)
            scene.stay(places, made.loaded)
            return added

        return Change(on, first, then, description.robots, names, description.rules)

    def _refuse_exchange(self, sources: Sequence[SourceId], description: SceneDescription) -> None:
        """Raise RuntimeError where what is described cannot be in the place of sources."""
        for camera in description.cameras:
            frame, _ = self._cameras.get(camera.name, (None, None))
            if frame is not None and self.inspector.GetOwningSourceId(frame) not in sources:
                self._refuse_taken(camera.name)
        self._refuse_cameras(description.cameras)
        if self.maps_source is not None and MAPS in description.sources:
            raise ArgumentError(
                f'the scene has a source {MAPS!r}, which is that of sensed maps; give it another '
                'name'
            )

    def attach(
        self,
        frame: FrameId,
        parent: FrameId,
        X_PF: RigidTransform | None,
        *,
        is_part: bool = True,
    ) -> RigidTransform:
        """Let a frame follow another one at once; see ``attachment``."""
        return self.make(self.attachment(frame, parent, X_PF, is_part=is_part))

    def detach(self, frame: FrameId, X_PF: RigidTransform | None) -> RigidTransform:
        """Put a frame back at once; see ``detachment``."""
        return self.make(self.detachment(frame, X_PF))

    def add_camera(self, frame: FrameId, camera: CameraDescription) -> None:
        """Add a camera on a frame; raises ArgumentError where its name is taken."""
        self._refuse_taken(camera.name)
        if reason := self.camera_limits.refusal(camera):
            raise ArgumentError(reason)
        self._cameras[camera.name] = frame, camera

    def remove_camera(self, name: str) -> None:
        """Remove a camera; raises ArgumentError where there is none of that name."""
        self.camera(name)
        del self._cameras[name]

    def _refuse_cameras(self, cameras: Iterable[CameraDescription]) -> None:
        """Raise SceneFileError for a camera that the node cannot publish."""
        for camera in cameras:
            if reason := self.camera_limits.refusal(camera):
                raise camera.where.error(reason)

    def _refuse_taken(self, name: str) -> None:
        if name in self._cameras:
            raise ArgumentError(f'there is a camera {name!r} already; remove it first')

    def replace(self, other: PreparedScene) -> tuple[int, int]:
        """Put another scene in the place of this one; versions go on growing."""
        self._refuse_cameras(camera for _, camera in other.loaded.cameras)
        if self.stand_maps is not None and MAPS in other.loaded.sources:
            raise ArgumentError(_HAS_MAPS)
        other.scene_graph.set_default_accuracy(self.accuracy)
        other.context.set_default_accuracy(self.accuracy)
        self._adopt(other.scene_graph, other.context, self.version + 1)
        self.replaced += 1
        self.maps_source, self.maps = other.maps
        self._robots = list(other.loaded.robots.values())
        if other.draft is not None:
            self._go_on_as(other.draft)
        if self.stand_maps is not None:
            self.stand_maps(self)  # before rules are bound: those about maps go on
        return self._take(other.loaded)

    def _take(self, loaded: LoadedScene) -> tuple[int, int]:
        """Take over what was registered."""
        self._context.UpdateFramePoses(loaded.first_poses)
        at_world = self._frame_that_is_the_world(loaded)
        self._context.UpdateFramePoses(FramePoseVector(at_world))
        X_PFs = {**loaded.X_PFs, **at_world}
        declared = {frame.get_value(): static for frame, static in loaded.static.items()}
        self._ages.begin([frame.get_value() for frame in X_PFs], declared)
        for frame in loaded.frames.values():
            if self.inspector.IsAttached(frame):
                self._ages.rest(frame.get_value())
        self.warned += loaded.warnings
        if loaded.rules or self.rules.rules:
            self.bind_rules()
        self.warned += self.rules.take(loaded.rules)
        self.awaited.begin(loaded.awaited)
        self.bind_filters()
        self._cameras.update((camera.name, (frame, camera)) for frame, camera in loaded.cameras)
        return len(loaded.frames), len(loaded.geometry_ids)

    def bind_filters(self) -> None:
        """Apply the filters of scene files that waited for what is there now."""
        self.told += self.awaited.bind(self._scene_graph)

    def _frame_that_is_the_world(self, loaded: LoadedScene) -> dict[FrameId, RigidTransform]:
        """Return the pose of a loaded frame called as the world frame, such as a robot's base.

        Nobody sends a transform of it. Where several sources have one, none is the world.
        """
        if self.world_frame == WORLD:
            return {}
        called = self.names.frames_called(self.world_frame)
        posed = {
            frame: RigidTransform()
            for frame in loaded.frames.values()
            if (called == [frame] or self.names.frame_names[frame] == self.world_frame)
            and self.inspector.GetParentFrame(frame) == self.inspector.world_frame_id()
        }
        for frame, X_WF in posed.items():
            if not loaded.X_PFs.get(frame, X_WF).IsExactlyIdentity():
                self.warned.append(_IS_THE_WORLD.format(self.names.frame_names[frame]))
        return posed

    def set_accuracy(self, accuracy: str) -> None:
        """Set the accuracy level of queries that name none."""
        self._scene_graph.set_default_accuracy(accuracy)
        self._context.set_default_accuracy(accuracy)
        self.rules.change_accuracy()

    def take_poses(self, message: Any, waited: float = 0.0, sender: str = '') -> int:
        """Take a FramePoses whole that came ``waited`` [s] ago; return how many frames.

        ``sender`` is the identity of its publisher, empty where nobody knows it.
        """
        poses, frames, rows = self.read_poses(message)
        since = self._clocks.arrival(waited).since(seconds_of(message.header.stamp))
        posed = self._ages.posed_by(frames, since, message.header.stamp)
        if sender:
            self.senders.note_frames(sender, frames)
        self.pose(poses, posed, message.header.stamp, MESSAGES, rows)
        return len(poses)

    def pose(
        self,
        poses: FramePoseVector,
        posed: PosedFrames,
        stamp: Any,
        feeder: str,
        rows: NDArray[np.float64] | None = None,
        parts: Parts | None = None,
    ) -> None:
        """Pose frames; ``posed`` says since when these hold.

        ``rows`` (n, 7) are what the poses were read from, for who keeps them; ``parts`` are what
        they were made of, where these have times of their own.
        """
        ids = poses.id_values()
        if self.keep_rows is not None and rows is not None:
            self.keep_rows(ids, rows)
        manager = self._scene_graph.collision_filter_manager()
        welded = manager.welded_frames()
        if self.attached:
            poses, posed = self.without_attached(poses, posed)
        if self.history is not None and rows is not None:
            self.history.note((ids, rows), posed, feeder, self._clocks.node(), parts)
        self._context.UpdateFramePoses(poses)
        self.moved.update(poses.id_values().tolist())
        self.rules.measure_again()
        is_map = feeder == OBSTACLES  # whose frame is welded again where it is posed
        if welded and not is_map and (gone := set(welded).difference(manager.welded_frames())):
            self._tell_of_welds(gone)
        if posed:
            self._ages.note(posed, stamp)
            for frames in posed:
                self.feeders.note(feeder, frames)
            if self._twists is not None:
                self._twists.note_poses(poses, _stamps(posed, stamp, feeder))

    def renew(self, posed: PosedFrames) -> None:
        """Note since when frames hold the poses that they have."""
        stand = {
            frozenset(f for f in frames - self.attached if self._ages.since(f) is not None): since
            for frames, since in posed.items()
        }
        stand.pop(frozenset(), None)
        if stand:
            self._ages.note(stand, self.newest_stamp)

    def _tell_of_welds(self, gone: set[FrameId]) -> None:
        names = some_of(sorted(self.names.frame_names[frame] for frame in gone))
        self.warned.append(
            f'{names}: welded to the world by its URDF or scene file, but posed elsewhere than '
            'before; its pairs with what is anchored are reported from now on'
        )

    def take_twists(self, message: Any, waited: float = 0.0) -> None:
        """Take a FrameTwists whole that came ``waited`` [s] ago.

        Raises RuntimeError where its stamp says no time.
        """
        self._refresh()
        frames, twists = self._reader.read_twists(message)
        stamp = stamp_of(message.header.stamp)
        if not stamp:
            raise ArgumentError('header.stamp is 0; twists belong to the poses of their time')
        if self._twists is not None:
            since = self._clocks.arrival(waited).since(seconds_of(message.header.stamp))
            self._twists.note_twists(frames, twists, stamp, since)
            self.rules.measure_again()

    def note_joint_twists(
        self, frames: NDArray[np.int64], twists: NDArray[np.float64], stamp: int, since: Since
    ) -> None:
        """Note the twists V_PF (n, 6) of frames (n,) at a stamp [ns], if motion is watched."""
        if self._twists is not None:
            self._twists.note_twists(frames, twists, stamp, since, in_parent=True)

    def lease(self, filter_id: FilterId, seconds: float) -> None:
        """Let a transient filter vanish after ``seconds``; 0: it stays."""
        self._leases.grant(filter_id, seconds)

    def refuse_too_many_filters(self, owner: str) -> None:
        """Raise FilterError where an owner has as many transient filters as one may have."""
        limit, owners = self.filters_per_owner, self._owners
        if list(owners.values()).count(owner) < limit:
            return  # some of these may be gone, which costs more to know
        if list(self.filter_owners().values()).count(owner) >= limit:
            raise FilterError(
                f'the owner {owner!r} has {limit} transient filters, the most that the parameter '
                'filters_per_owner allows; remove those that are no longer needed '
                '(remove_filter), or let their leases expire'
            )

    def own(self, filter_id: FilterId, owner: str, *, is_short: bool) -> None:
        """Keep in mind who asked for a transient filter, and whether it is soon removed."""
        self._owners[filter_id.get_value()] = owner
        if not is_short:
            self._long_filters.add(filter_id.get_value())

    def expire_filters(self) -> list[FilterId]:
        """Remove the transient filters whose lease ran out; return them.

        Filters that waited for these to go hold from now on.
        """
        manager = self._scene_graph.collision_filter_manager()
        expired = self._leases.take_expired()
        numbers_of: dict[str, list[int]] = {}
        for filter_id in manager.RemoveDeclarations(expired):
            number = filter_id.get_value()
            numbers_of.setdefault(self._owners.get(number, ''), []).append(number)
        for owner, numbers in numbers_of.items():
            self.told.append(f'the lease of {_filters(numbers)} expired: removed{owned_by(owner)}')
        self.bind_filters()
        return expired


class _Exchanged(NamedTuple):
    """The frames of each source that was removed, and what was registered."""

    removed: list[list[FrameId]]
    loaded: LoadedScene


def _exchanged(
    graph: SceneGraph,
    context: SceneGraphContext | None,
    sources: Iterable[SourceId],
    description: SceneDescription,
) -> _Exchanged:
    """Remove sources and register what is described."""
    removed = [graph.RemoveSource(context=context, source_id=source) for source in sources]
    if context is None:  # it was rehearsed
        return _Exchanged(removed, register_rehearsed(graph, description))
    return _Exchanged(removed, _registered(graph, description, context))


def _registered(
    graph: SceneGraph, description: SceneDescription, context: SceneGraphContext | None
) -> LoadedScene:
    """Register what is described, or nothing; in a context, frames stand where it puts them."""
    if context is None:
        return register(graph, description)
    loaded = warm_up(graph, description, context)
    context.UpdateFramePoses(loaded.first_poses)
    return loaded


def _stamps(posed: PosedFrames, stamp: Any, feeder: str) -> dict[int, tuple[int, Since]]:
    """Return the stamps [ns] of poses by frame, and since when they hold.

    All of a message bear the same one; transforms have their own, which ``posed`` knows. Those
    that hold for good bear none.
    """
    stamps: dict[int, tuple[int, Since]] = {}
    for frames, since in posed.items():
        own = 0
        if since != ALWAYS:
            own = int(since.held * 1e9) if feeder == TF else stamp_of(stamp)
        stamps.update(dict.fromkeys(frames, (own, since)))
    return stamps


def _filters(numbers: list[int]) -> str:
    """Return transient filters in words; thousands may go at once."""
    if len(numbers) == 1:
        return f'transient filter {numbers[0]}'
    return f'{len(numbers)} transient filters ({some_of(numbers)})'


def owned_by(owner: str) -> str:
    """Return an owner in words, to go behind what is owned; empty for none."""
    return f' (owner {owner!r})' if owner else ''
