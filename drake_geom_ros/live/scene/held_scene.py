"""The live scene while it is held: its parts, and operations on all of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from drake_geom_ros.geometry import ArgumentError, FrameId, QueryObject, SceneGraph
from drake_geom_ros.live.conversions.names import MAPS, TRACKED, WORLD
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.half_spaces import overlapping_half_spaces
from drake_geom_ros.live.scene.prepared_scene import HAS_MAPS, PreparedScene
from drake_geom_ros.live.scene.scene_cameras import SceneCameras
from drake_geom_ros.live.scene.scene_draft import SceneDraft
from drake_geom_ros.live.scene.scene_filters import SceneFilters
from drake_geom_ros.live.scene.scene_log import SceneLog
from drake_geom_ros.live.scene.scene_maps import SceneMaps
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.live.scene.scene_poses import ScenePoses
from drake_geom_ros.live.scene.scene_rules import Blind, SceneRules
from drake_geom_ros.live.scene.scene_snapshot import SceneSnapshot, SnapshotMark
from drake_geom_ros.live.scene.scene_stopping import SceneStopping
from drake_geom_ros.live.scene.scene_tracked import NAMED_AS_TRACKED, SceneTracked
from drake_geom_ros.live.scene.scene_view import SceneStamp, SceneView
from drake_geom_ros.live.scene.waiting import Waiting, WaitingNames, waiting
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import Gate, LoadedScene, SceneDescription

_Result = TypeVar('_Result')
_IS_THE_WORLD = (
    'the frame {!r} is called as the parameter world_frame is, so it is the world: the pose that '
    'the scene file gives it is left out; give it none, or choose another world_frame'
)


class HeldScene:
    """The scene, in parts; ``LiveScene`` hands it out for the length of a ``with`` block.

    In the block no other thread has it. It is not kept for longer.

    - ``model``: the scene graph, names, joints of robots, versions.
    - ``poses``: where frames are, since when, who posed them, and how they move.
    - ``filters``: transient filters with their owners and leases, and filters that wait.
    - ``maps``, ``tracked``: sensed maps, tracked bodies.
    - ``cameras``, ``rules``, ``stopping``: cameras, proximity rules, and whether robots can stop.
    - ``log``: lines for a node to log.

    Example::

        with live.editing() as scene:
            scene.poses.take(message)
            scene.query.ComputeSignedDistancePairwiseClosestPoints()
    """

    def __init__(
        self, scene_graph: SceneGraph, clocks: Clocks, world_frame: str, version: int
    ) -> None:
        """``clocks`` measure the ages of poses; ``version`` is that of an empty scene."""
        self.clocks = clocks
        self.log = SceneLog()
        self.model = SceneModel(scene_graph, world_frame, version)
        self.query: QueryObject = self.model.query  # live: it sees later poses
        self.rules = SceneRules()  # they outlive a scene that is replaced
        self.poses = ScenePoses(self.model, clocks, self.rules, self.log)
        self.stopping = SceneStopping(self.model, self.poses, self.rules)
        self.filters = SceneFilters(self.model, clocks, self.log)
        self.maps = SceneMaps(self.model, self.rules)
        self.tracked = SceneTracked(self.model, clocks)
        self.cameras = SceneCameras()
        # Called when an answer is to name the scene, whose names must be told then.
        self.tell_named: Callable[[HeldScene], object] = lambda _: None
        self.gates: tuple[Gate, ...] = ()  # of the node; they outlive a scene that is replaced
        self.replaced = 0  # how often another scene, or other sources, took the place of these
        self._waiting_names = WaitingNames()

    # Changes.

    def make(self, change: Change[HeldScene, _Result]) -> _Result:
        """Make a change at once, and return its result; see ``LiveScene.change``.

        Raises what the change raises, and nothing has changed then.
        """
        change.first(self)
        try:
            made = change.on(self.model.scene_graph, None)
        except BaseException:
            self.model.refresh()  # memory may have ended in the middle of it
            raise
        if not change.same_content:
            self.model.robots = change.robots_after(self.model.robots)
            self.model.maps_source = change.maps_after(self.model.maps_source, made)
        self.model.refresh(same_content=change.same_content)
        return change.then(self, made)

    def take_over(self, draft: SceneDraft) -> bool:
        """Adopt a changed draft; return False if the scene has changed since it was made.

        In a moment, whatever was changed: all that cycles need was made by the draft.
        """
        parts = draft.context, draft.robots, draft.maps_source, draft.tables
        if not self.model.take_over(*parts):
            return False
        self.rules.offer(draft.rules)
        return True

    def replace(self, other: PreparedScene) -> tuple[int, int]:
        """Put another scene in the place of this one; return its frames and geometries.

        Versions go on growing. Raises RuntimeError for a camera that the node cannot publish, and
        where the other scene has a source that is called as that of maps.
        """
        self.cameras.refuse_beyond_limits(camera for _, camera in other.loaded.cameras)
        if self.maps.stand is not None and MAPS in other.loaded.sources:
            raise ArgumentError(HAS_MAPS)
        if self.tracked.heartbeat is not None and TRACKED in other.loaded.sources:
            raise ArgumentError(NAMED_AS_TRACKED)
        other.scene_graph.set_default_accuracy(self.accuracy)
        other.context.set_default_accuracy(self.accuracy)
        self.poses.begin_anew()
        self.filters.begin_anew()
        self.cameras.clear()
        self.maps.by_name = other.maps.maps
        had_tracker = self.tracked.heartbeat is not None
        self.tracked.forget()
        self.replaced += 1
        self.model.adopt(
            other.scene_graph,
            other.context,
            self.model.version + 1,
            list(other.loaded.robots.values()),
            other.maps.source,
            None if other.draft is None else other.draft.tables,
        )
        self.query = self.model.query
        if other.draft is not None:
            self.rules.offer(other.draft.rules)
        if self.maps.stand is not None:
            self.maps.stand(self)  # before rules are bound: those about maps go on
        if had_tracker and self.tracked.stand is not None:
            self.tracked.stand(self)
        return self.begin(other.loaded)

    def begin(self, loaded: LoadedScene) -> tuple[int, int]:
        """Take over what was registered; return how many frames and geometries."""
        self.poses.begin(loaded, self._frames_that_are_the_world(loaded))
        self.log.warnings += loaded.warnings
        if loaded.rules or self.rules.rules:
            self.bind_rules()
        self.log.warnings += self.rules.take(loaded.rules)
        for frame, touch_links in loaded.touch_links.items():
            owner = f'attach {self.model.names.frame_names[frame]}'
            self.filters.begin_attached(frame, owner, touch_links)
        self.filters.awaited.begin(loaded.awaited)
        self.filters.bind()
        self.cameras.begin(loaded.cameras)
        return len(loaded.frames), len(loaded.geometry_ids)

    def _frames_that_are_the_world(self, loaded: LoadedScene) -> dict[FrameId, RigidTransform]:
        """Return the pose of a loaded frame called as the world frame, such as a robot's base.

        Nobody sends a transform of it. Where several sources have one, none is the world.
        """
        world_frame, names = self.model.world_frame, self.model.names
        if world_frame == WORLD:
            return {}
        called = names.frames_called(world_frame)
        posed = {
            frame: RigidTransform()
            for frame in loaded.frames.values()
            if (called == [frame] or names.frame_names[frame] == world_frame)
            and self.model.inspector.GetParentFrame(frame) == names.world
        }
        for frame, X_WF in posed.items():
            if not loaded.X_PFs.get(frame, X_WF).IsExactlyIdentity():
                self.log.warnings.append(_IS_THE_WORLD.format(names.frame_names[frame]))
        return posed

    def forget_source(self, name: str, frames: Sequence[FrameId]) -> None:
        """Forget what is known of a source that has gone, and of its frames."""
        self.forget_frames(frames)
        self.filters.awaited.forget(name)
        if self.tracked.heartbeat is not None and self.tracked.heartbeat.frame in frames:
            self.tracked.forget()

    def forget_frames(self, frames: Sequence[FrameId]) -> None:
        """Forget what is known of frames that have gone."""
        self.poses.forget(frames)
        self.cameras.forget(frames)
        self.filters.forget_frames(frames)

    def bind_rules(self) -> None:
        """Bind the proximity rules to the present scene."""
        self.rules.bind(self.query, self.model.names_version)

    @property
    def accuracy(self) -> str:
        """The accuracy of queries that name none, as messages have it."""
        return str(self.model.scene_graph.default_accuracy())

    def set_accuracy(self, accuracy: str) -> None:
        """Set the accuracy of queries that name none."""
        self.model.scene_graph.set_default_accuracy(accuracy)
        self.model.context.set_default_accuracy(accuracy)
        self.rules.change_accuracy()

    # Reports of all parts.

    def moment(self) -> SceneStamp:
        """Return which scene and poses an answer of now is for."""
        self.tell_named(self)
        model, ages = self.model, self.poses.ages
        return SceneStamp(
            model.version,
            model.names_version,
            ages.newest_stamp,
            ages.oldest(model.names),
            model.world_frame,
        )

    def waiting(self) -> Waiting:
        """Return the frames and pairs that wait for a first pose."""
        beside, absent = self.maps.beside_bodies(), self.poses.visitors.absent
        return waiting(self.query, self.model.names, beside, absent, self._waiting_names)

    def troubles(self) -> list[str]:
        """Return faults of incoming poses, twists and lists, in words."""
        rules = self.rules.troubles(watches_motion=self.poses.watches_motion)
        rules += [*self.maps.finer_rules(), self._unseen()]
        troubles = [
            *self.poses.troubles(),
            *self.filters.awaited.troubles(),
            *rules,
            overlapping_half_spaces(self.query, self.model.names),
            *self.poses.feeder_troubles(),
        ]
        return [*filter(None, troubles)]

    def blind_frames(self, stale_after: float) -> Blind:
        """Return the frames that rules cannot rely on: maps have limits [s] of their own."""
        unreliable = self.poses.blind_frames(stale_after)
        return self.maps.among_blind(unreliable, self.poses.since, self.clocks)

    def _unseen(self) -> str:
        sights = self.maps.sights()
        if sights and self.rules.rules:
            self.bind_rules()  # its bodies must be those of the query
            return self.rules.unseen(self.query, sights)
        return ''

    # Copies that may be kept beyond the block.

    def view(self, *, moving: bool = False, stale_after: float = math.inf) -> SceneView:
        """Return a snapshot, which may be kept; ``moving``: with the twists of now.

        It names the poses that are older than ``stale_after`` [s].
        """
        model, poses = self.model, self.poses
        context, owners = model.context.what_if(), self.filters.owners()
        twists, unknown = poses.twists() if moving else None, poses.unknown_ages()
        stale = self.maps.among_stale(poses.ages.stale(stale_after), poses.since, self.clocks)
        beside = self.maps.beside_bodies()
        return SceneView(
            context=context,
            query=QueryObject(context),
            names=model.names,
            moment=self.moment(),
            filter_owners=owners,
            unknown_ages=unknown,
            joints=model.joints.entries,
            twists=twists,
            beside=beside,
            stale=stale,
            touch_links=self.filters.touch_links.names(),
            absent=poses.visitors.absent,
        )

    def snapshot(self) -> SceneSnapshot:
        """Return a copy to be described, which takes long and needs no scene."""
        model, visitors = self.model, self.poses.visitors
        joints, context = model.joints.robots, model.context.what_if()
        visitors.activate_all(context)
        return SceneSnapshot(
            context,
            self.mark(),
            tuple(
                joints[robot.name].as_now(robot) if robot.name in joints else robot
                for robot in model.robots
            ),
            self.poses.ages.static(),
            self.filters.awaited.waiting(),
            self.rules.rules,
            model.maps_source,
            self.maps.sources,
            self.gates,
            has_tracked=self.tracked.heartbeat is not None,
            touch_links=self.filters.lasting_touch_links(),
            gone_after=dict(visitors.gone_after),
        )

    def mark(self) -> SnapshotMark:
        """Return the mark of a description of the present scene."""
        model = self.model
        return SnapshotMark(
            model.model_version,
            model.inspector.candidate_pairs(),
            tuple(model.filter_manager.active_filter_ids()),
            self.cameras.by_name(),
            self.filters.awaited.all(),
        )

    def moved_since(self, before: SceneSnapshot) -> dict[tuple[str, str], RigidTransform]:
        """Return X_PF by source and name of the frames that are elsewhere than before.

        Those of sensed maps are left out, which stand where they were seen.
        """
        names = self.model.names
        frames = [frame for frame in names.labels if frame not in names.of_maps]
        ids = np.array([frame.get_value() for frame in frames], dtype=np.int64)
        R_WFs, p_WFs, is_placed = self.model.context.X_WFs(ids)
        R_was, p_was, was_placed = before.context.X_WFs(ids)
        moved = (R_WFs != R_was).any(axis=(1, 2)) | (p_WFs != p_was).any(axis=1)
        rows = np.flatnonzero(is_placed & (moved | ~was_placed)).tolist()
        return {names.labels[frames[k]]: self.query.X_PF(frames[k]) for k in rows}

    def description(self) -> SceneDescription:
        """Return the scene as it is now; see ``SceneSnapshot.description``."""
        return self.snapshot().description()
