"""The live scene while it is held to be changed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ArgumentError,
    FilterError,
    FilterId,
    FrameId,
    FramePoseVector,
    SceneGraph,
    SourceId,
)
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.names import WORLD, some_of
from drake_geom_ros.live.scene.changing_scene import ChangingScene
from drake_geom_ros.live.scene.clocks import ALWAYS, Since
from drake_geom_ros.live.scene.feeders import MESSAGES, OBSTACLES, TF
from drake_geom_ros.live.scene.held_scene import MAPS
from drake_geom_ros.live.scene.pose_ages import PosedFrames
from drake_geom_ros.live.scene.pose_history import Parts
from drake_geom_ros.live.scene.scene_draft import SceneDraft
from drake_geom_ros.live.scene.twists import stamp_of
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import (
    CameraDescription,
    LoadedScene,
    SceneDescription,
    register,
    register_rehearsed,
)

_IS_THE_WORLD = (
    'the frame {!r} is called as the parameter world_frame is, so it is the world: the pose that '
    'the scene file gives it is left out; give it none, or choose another world_frame'
)


@dataclass(frozen=True)
class PreparedScene:
    """A scene of its own that is ready to take the place of the live one."""

    scene_graph: SceneGraph
    loaded: LoadedScene


def prepared(description: SceneDescription) -> PreparedScene:
    """Return what is described, its kernels compiled; raises RuntimeError for what cannot be.

    Takes long and holds nothing: so the live scene is replaced in a moment.
    """
    scene_graph = SceneGraph()
    loaded = register(scene_graph, description)
    scene_graph.CreateSharedContext().compile_kernels()
    return PreparedScene(scene_graph, loaded)


class RegisteredDraft(NamedTuple):
    """A draft in which something was registered, and what that became."""

    draft: SceneDraft
    loaded: LoadedScene


class EditableScene(ChangingScene):
    """The scene and what may be changed of it. What raises RuntimeError has changed nothing."""

    @property
    def scene_graph(self) -> SceneGraph:
        """The scene graph, to register on and to filter."""
        return self._scene_graph

    def take_over(self, draft: SceneDraft) -> bool:
        """Become what a draft has become; return False where the scene has changed since.

        In a moment, whatever was changed: all that cycles need was made by the draft.
        """
        if not self._scene_graph.TakeOver(draft.context, self._context):
            return False
        if (named := draft.named) is not None:
            named.joints.go_on_as(self._joints)
            self._robots = draft.robots
            self._names, self._reader, self._joints = named.names, named.reader, named.joints
            self._named_version = self.model_version
            self._attached = self.names_version, named.attached
        self.rules.offer(draft.rules)
        return True

    def add(
        self, description: SceneDescription, copy: RegisteredDraft | None = None
    ) -> tuple[int, int]:
        """Register what is described; return frames, geometries added.

        Frames stand where the description puts them until their first pose comes. With a ``copy``
        that has it, it takes a moment: see ``registered_copy``.
        """
        for camera in description.cameras:
            self._refuse_taken(camera.name)
        self._refuse_cameras(description.cameras)
        if copy is not None and self.take_over(copy.draft):
            return self._take(copy.loaded)
        loaded = register(self._scene_graph, description)
        self._robots += loaded.robots.values()  # before their frames are called by names
        return self._take(loaded)

    def swap(self, sources: Sequence[SourceId], description: SceneDescription) -> tuple[int, int]:
        """Put what is described in the place of sources; return frames, geometries added.

        Frames of the same source and name, of which nothing else is said, keep their poses. The
        source of sensed maps is refused.
        """
        for source in sources:
            self.refuse_maps(source)
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
        places = self.make_room(sources, description)  # which rehearses it
        self.replaced += 1
        loaded = register_rehearsed(self._scene_graph, description)
        self._robots += loaded.robots.values()
        added = self._take(loaded)
        self.stay(places, loaded)
        return added

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
            raise ArgumentError(
                f'the scene has a source {MAPS!r}, which is that of the sensed maps of this node; '
                'give it another name'
            )
        other.scene_graph.set_default_accuracy(self.accuracy)
        self._adopt(other.scene_graph, self.version + 1)
        self.replaced += 1
        self._robots += other.loaded.robots.values()
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

    def own(self, filter_id: FilterId, owner: str) -> None:
        """Keep in mind who asked for a transient filter."""
        self._owners[filter_id.get_value()] = owner

    def owner_of(self, filter_id: FilterId) -> str:
        """Return who asked for a transient filter; empty: nobody said, or there is no such one."""
        return self._owners.get(filter_id.get_value(), '') if filter_id.is_valid() else ''

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
