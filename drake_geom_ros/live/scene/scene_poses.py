"""Poses of the frames of the live scene: their ages, their senders, twists and the past."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    QueryObject,
    SourceId,
    closing_speeds,
)
from drake_geom_ros.live.conversions.fields import nanoseconds_of, seconds_of
from drake_geom_ros.live.conversions.message_types import (
    FramePosesMessage,
    FrameTwistsMessage,
    TimeMessage,
)
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Clocks, Since, oldest
from drake_geom_ros.live.scene.feeders import JOINTS, MESSAGES, OBSTACLES, TF, Feeders
from drake_geom_ros.live.scene.pose_ages import PoseAges, PosedFrames, UnknownAges
from drake_geom_ros.live.scene.pose_history import Parts, PoseHistory
from drake_geom_ros.live.scene.scene_log import SceneLog
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.live.scene.scene_rules import Blind, SceneRules
from drake_geom_ros.live.scene.scene_visitors import SceneVisitors
from drake_geom_ros.live.scene.sender_troubles import clock_troubles, sender_troubles
from drake_geom_ros.live.scene.senders import Joint, Senders, links_of
from drake_geom_ros.live.scene.twists import FrameTwists
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import LoadedScene

_REMEMBERED = 5.0  # [s] for which a pose is told of that was left out


class Place(NamedTuple):
    """The pose of a frame whose source is replaced, and since when it holds."""

    parent: str
    X_PF: RigidTransform
    since: Since


class _Waiting(NamedTuple):
    """The frames that wait for a pose, and the values of their ids."""

    frames: list[FrameId]
    values: frozenset[int]


class ScenePoses:
    """Takes poses and twists of frames; knows their ages, their senders and their past.

    - ``ages``: since when each frame has its pose. ``feeders``: which input posed it last.
      ``senders``: which publisher. ``history``: where frames were, if somebody has to know.
    - ``visitors``: frames that come and go.
    - ``moved``: frames that were posed since the robots on them followed.
    - ``keep_rows``: called with the id values (n,) of frames and the poses (n, 7) that came.
    """

    def __init__(
        self, model: SceneModel, clocks: Clocks, rules: SceneRules, log: SceneLog
    ) -> None:
        """``clocks`` measure the ages of poses; ``rules`` measure again where something moves."""
        self._model, self._clocks, self._rules, self._log = model, clocks, rules, log
        self.history: PoseHistory | None = None
        self.moved = set[int]()
        self._waiting = _Waiting([], frozenset())
        self.keep_rows: Callable[[NDArray[np.int64], NDArray[np.float64]], object] | None = None
        self._longest_gap: float | None = None
        self.visitors = SceneVisitors(model, clocks, log)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget all poses: another scene replaces this one."""
        clocks = self._clocks
        self.ages = PoseAges(clocks)
        self.visitors.begin_anew()
        self.feeders, self.senders = Feeders(clocks.steady), Senders(clocks.steady)
        # When [s] a pose of an attached frame was left out last, by the value of its id.
        self._left_out: dict[int, float] = {}
        self._twists: FrameTwists | None = None
        if self._longest_gap is not None:
            self._twists = FrameTwists(self._longest_gap, clocks)

    # Inputs.

    def take(self, message: FramePosesMessage, waited: float = 0.0, sender: str = '') -> int:
        """Take a FramePoses whole that came ``waited`` [s] ago; return how many frames.

        ``sender`` is the identity of its publisher, empty where nobody knows it. Raises
        RuntimeError for what cannot be taken.
        """
        poses, frames, rows = self._model.reader.read(message)
        stamp = message.header.stamp
        held = seconds_of(stamp)
        since = self._clocks.arrival(waited).since(held)
        posed = self.ages.posed_by(frames, since, stamp)
        if sender:
            self.senders.note_frames(sender, frames)
        self.pose(poses, posed, stamp, MESSAGES, rows)
        return len(frames)

    def pose(
        self,
        poses: FramePoseVector,
        posed: PosedFrames,
        stamp: TimeMessage,
        feeder: str,
        rows: NDArray[np.float64] | None = None,
        parts: Parts | None = None,
        named: Collection[int] | None = None,
    ) -> None:
        """Pose frames; ``posed`` says since when these hold.

        ``rows`` (n, 7) are what the poses were read from, for who keeps them; ``parts`` are what
        they were made of, where these have times of their own. ``named`` are the frames that the
        messages named, without those that moved along; None: all.
        """
        ids = poses.id_values()
        if self.visitors.gone_after:
            self.welcome(ids.tolist() if named is None else named)
            if absent := self.visitors.absent.intersection(ids.tolist()):
                poses, posed = _without(absent, poses, posed)
                rows = None if rows is None else rows[~np.isin(ids, list(absent))]
                ids = poses.id_values()
        if self.keep_rows is not None and rows is not None:
            self.keep_rows(ids, rows)
        welded = self._model.filter_manager.welded_frames()
        free_ids = ids
        if self._model.attached:
            poses, posed = self._without_attached(poses, posed)
            free_ids = poses.id_values()
        if self.history is not None and rows is not None:
            self.history.note((ids, rows), posed, feeder, self._clocks.node(), parts)
        self._model.context.UpdateFramePoses(poses)
        self.moved.update(free_ids.tolist())
        self._rules.measure_again()
        if welded and feeder != OBSTACLES:  # a map is welded again where it is posed
            self._warn_of_welds(welded)
        if posed:
            self.ages.note(posed, stamp)
            for frames in posed:
                self.feeders.note(feeder, frames)
            if self._twists is not None:
                self._twists.note_poses(poses, _stamps(posed, stamp, feeder))

    def _without_attached(
        self, poses: FramePoseVector, posed: PosedFrames
    ) -> tuple[FramePoseVector, PosedFrames]:
        """Return poses without those of attached frames."""
        attached = self._model.attached.intersection(*[frozenset().union(*posed)])
        if not attached:
            return poses, posed
        self.leave_out(map(FrameId, attached))
        return _without(attached, poses, posed)

    def leave_out(self, frames: Iterable[FrameId]) -> None:
        """Note that a pose came for attached frames, which is reported for a while."""
        now = self._clocks.steady()
        self._left_out.update((frame.get_value(), now) for frame in frames)

    def _warn_of_welds(self, welded: Collection[FrameId]) -> None:
        """Warn of the frames that were welded and are not any more."""
        gone = set(welded).difference(self._model.filter_manager.welded_frames())
        if not gone:
            return
        names = some_of(sorted(self._model.names.frame_names[frame] for frame in gone))
        self._log.warnings.append(
            f'{names}: welded to the world by its URDF or scene file, but posed elsewhere than '
            'before; its pairs with what is anchored are reported from now on'
        )

    def welcome(self, named: Collection[int]) -> None:
        """Note which frames a message named; those that were absent come back.

        They, and frames of the same source, wait for a pose from now on.
        """
        self.ages.wait(self.visitors.name(named))

    def take_out_silent(self, stale_after: float) -> list[int]:
        """Take out the frames that come and go, and that no message names; return them.

        None goes before its age is ``stale_after`` [s].
        """

        def stays(value: int) -> bool:
            return self.ages.since(value) == ALWAYS  # by a static transform

        gone = self.visitors.leave(stale_after, stays)
        if gone:
            self._model.context.UnposeFrames(map(FrameId, gone))
            self.ages.wait(gone)
            self.ages.keep(gone, ALWAYS)  # nobody waits for it
            self._let_go(gone)
            if self.history is not None:
                self.history.begin_anew(gone, self._clocks.node())
            self._rules.measure_again()
        return gone

    def renew(self, posed: PosedFrames) -> None:
        """Note since when frames hold the poses that they have."""
        fixed = self._model.attached | self.visitors.absent
        stand = {
            frozenset(f for f in frames - fixed if self.ages.since(f) is not None): since
            for frames, since in posed.items()
        }
        stand.pop(frozenset(), None)
        if stand:
            self.ages.note(stand, self.ages.newest_stamp)

    def take_twists(self, message: FrameTwistsMessage, waited: float = 0.0) -> None:
        """Take a FrameTwists whole that came ``waited`` [s] ago.

        Raises RuntimeError where its stamp says no time.
        """
        frames, twists = self._model.reader.read_twists(message)
        stamp = nanoseconds_of(message.header.stamp)
        if not stamp:
            raise ArgumentError('header.stamp is 0; twists belong to the poses of their time')
        if self._twists is not None:
            since = self._clocks.arrival(waited).since(seconds_of(message.header.stamp))
            self._twists.note_twists(frames, twists, stamp, since)
            self._rules.measure_again()

    def note_joint_twists(
        self, frames: NDArray[np.int64], twists: NDArray[np.float64], stamp: int, since: Since
    ) -> None:
        """Note the twists V_PF (n, 6) of frames (n,) at a stamp [ns], if motion is watched."""
        if self._twists is not None:
            self._twists.note_twists(frames, twists, stamp, since, in_parent=True)

    def watch_motion(self, longest_gap: float) -> None:
        """Keep the twists of frames from now on: see ``FrameTwists``."""
        self._longest_gap = longest_gap
        self._twists = FrameTwists(longest_gap, self._clocks)
        # Of no pair at all: what it takes is there now, and not in the first cycle only.
        none = self._model.query.ComputeSignedDistancePairwiseClosestPoints(-math.inf)
        closing_speeds(none, self.twists() or {})

    # Ages and faults.

    @property
    def watches_motion(self) -> bool:
        """True if twists of frames are kept."""
        return self._twists is not None

    def twists(self) -> dict[FrameId, NDArray[np.float64]] | None:
        """Return the twists V_WF (6,) of now of the frames that have one; None: nobody watches."""
        if self._twists is None:
            return None
        return self._twists.in_world(self._model.query, self.ages.static())

    def ages_by_name(self) -> dict[str, float]:
        """Return the age [s] of the pose of every frame by name; inf for one that is unknown."""
        return self.ages.by_name(self._model.names)

    def unknown_ages(self) -> UnknownAges:
        """Return the frames that were not posed since the node's clock jumped."""
        return UnknownAges(self.ages.unknown(self._model.names))

    def since(self, frame: FrameId) -> Since | None:
        """Return since when a frame has its pose; None where it waits, or nobody knows."""
        return self.ages.since(frame.get_value())

    def ages_now(self) -> Callable[[Since], float]:
        """Return a function of ages [s], for which the clocks are read once."""
        return self._clocks.ages()

    def blind_frames(self, stale_after: float) -> Blind:
        """Return the frames whose poses are older [s], never came, or are not to be trusted."""
        frames = self._model.query.waiting_frames()
        if frames != self._waiting.frames:
            values = frozenset(frame.get_value() for frame in frames)
            self._waiting = _Waiting(frames, values)
        stale = self.ages.older_than(stale_after, self._model.names)
        others = self.contested_frames(), self.ages.of_other_clocks()
        return Blind(stale, self._waiting.values, *others)

    def contested_frames(self) -> set[int]:
        """Return the frames, by the values of their ids, that two senders pose in turn."""
        contested = self.senders.contested_frames().union(self.feeders.contested())
        if joints := self.senders.contested_joints():
            contested |= links_of(self._model.joints.robots.values(), joints)
        return contested

    def links_of_stale_joints(self, seconds: float, named: Collection[Joint]) -> set[int]:
        """Return the links of joints whose values are older [s], but for those ``named``."""
        robots = self._model.joints.robots.values()
        values = [(r.name, k, v.since) for r in robots for k, v in enumerate(r.values) if v]
        ages = self._clocks.ages_of([since for _, _, since in values])
        old = {(n, k) for (n, k, _), age in zip(values, ages, strict=True) if age > seconds}
        return links_of(robots, old.difference(named))

    def troubles(self) -> list[str]:
        """Return faults of incoming poses and twists, in words."""
        twists = [] if self._twists is None else self._twists.troubles(self._model.names)
        return [*twists, *self.sender_troubles(), *self._left_out_in_words()]

    def sender_troubles(self) -> list[str]:
        """Return faults of senders of poses and of their clocks, in words."""
        names = self._model.names
        troubles = sender_troubles(self.senders, self._model.joints, names)
        return troubles + clock_troubles(self.ages.of_other_clocks(), names)

    def feeder_troubles(self) -> list[str]:
        """Return which frames two inputs pose in turn, in words."""
        names = self._names_of(set(self.feeders.contested()))
        if not names:
            return []
        return [
            f'{counted(len(names), "frame")} {are(len(names))} posed by two of {TF}, '
            f'{MESSAGES} and {JOINTS} in turn, and the last one counts: {some_of(names)}; '
            'stop one of the two'
        ]

    def _left_out_in_words(self) -> list[str]:
        """Return the attached frames for which poses still arrive."""
        now = self._clocks.steady()
        posed = {value for value, at in self._left_out.items() if now - at < _REMEMBERED}
        names = self._names_of(posed & self._model.attached)
        if not names:
            return []
        return [
            f'poses of {counted(len(names), "attached frame")} are left out: {some_of(names)}; '
            'what holds a frame says where it is, until detach'
        ]

    def _names_of(self, frames: Collection[int]) -> list[str]:
        labels = self._model.names.frame_names.items()
        return [name for frame, name in labels if frame.get_value() in frames]

    # Changes of the scene.

    def begin(self, loaded: LoadedScene, at_world: Mapping[FrameId, RigidTransform]) -> None:
        """Add registered frames; those ``at_world`` coincide with the world."""
        self._model.context.UpdateFramePoses(loaded.first_poses)
        self._model.context.UpdateFramePoses(FramePoseVector(at_world))
        with_poses = [frame.get_value() for frame in {**loaded.X_PFs, **at_world}]
        declared = {frame.get_value(): static for frame, static in loaded.static.items()}
        self.ages.begin(with_poses, declared)
        self.visitors.begin(loaded.gone_after)
        for frame in loaded.frames.values():
            if self._model.inspector.IsAttached(frame):
                self.ages.rest(frame.get_value())

    def forget(self, frames: Iterable[FrameId]) -> None:
        """Forget what is known of frames that have gone."""
        gone = [frame.get_value() for frame in frames]
        self.ages.forget(gone)
        self.visitors.forget(gone)
        self._let_go(gone)

    def _let_go(self, frames: Collection[int]) -> None:
        self.feeders.forget(frames)
        if self._twists is not None:
            self._twists.forget(frames)

    def places_of(self, sources: Collection[SourceId]) -> dict[tuple[str, str], Place]:
        """Return where the frames of sources are, as far as they are posed and not attached."""
        places, inspector = {}, self._model.inspector
        for frame, label in self._model.names.labels.items():
            since = self.since(frame)
            if (
                since is not None
                and frame.get_value() not in self.visitors.absent
                and inspector.GetOwningSourceId(frame) in sources
                and not inspector.IsAttached(frame)
            ):
                parent = inspector.GetName(inspector.GetParentFrame(frame))
                places[label] = Place(parent, self._model.query.X_PF(frame), since)
        return places

    def stay(self, places: Mapping[tuple[str, str], Place], loaded: LoadedScene) -> None:
        """Let frames stand where those of the same source and name did, until poses come."""
        inspector = self._model.inspector
        for label, frame in loaded.frames.items():
            old = places.get(label)
            parent = inspector.GetName(inspector.GetParentFrame(frame))
            if old is not None and frame not in loaded.X_PFs and parent == old.parent:
                self._model.context.UpdateFramePoses(FramePoseVector({frame: old.X_PF}))
                self.ages.keep([frame.get_value()], old.since)

    def put(self, places: Mapping[tuple[str, str], RigidTransform]) -> None:
        """Have frames by source and name stand at X_PF."""
        if places:
            labels = self._model.names.labels.items()
            X_PFs = {frame: places[label] for frame, label in labels if label in places}
            self._model.context.UpdateFramePoses(FramePoseVector(X_PFs))

    # Frames that are attached to others.

    def pose_in(
        self, frame: FrameId, parent: FrameId, query: QueryObject | None = None
    ) -> RigidTransform:
        """Return where a frame is in another one; raises ArgumentError where nobody knows.

        ``query`` is of other poses than those of now.
        """
        query, names = query or self._model.query, self._model.names.frame_names
        if unplaced := [names[each] for each in (frame, parent) if not query.is_placed(each)]:
            raise ArgumentError(
                f'{some_of(unplaced)} has no pose yet, so nobody knows where the frame is; pose '
                'it first, or give `pose` with pose_given'
            )
        return query.X_WF(parent).InvertAndCompose(query.X_WF(frame))

    def rest_at(self, frame: FrameId, X_PF: RigidTransform) -> None:
        """Keep the present pose of a frame that is attached now."""
        self._hang_at(frame, X_PF)
        self.ages.rest(frame.get_value())
        self._let_go([frame.get_value()])

    def move_again_from(self, frame: FrameId, X_PF: RigidTransform, since: Since) -> None:
        """Leave a frame in its home, where messages pose it from now on."""
        self._hang_at(frame, X_PF)
        self.ages.rest_no_more(frame.get_value(), since)
        # TF leaves it there until a transform of this very frame comes.
        self.feeders.note(MESSAGES, frozenset([frame.get_value()]))

    def _hang_at(self, frame: FrameId, X_PF: RigidTransform) -> None:
        """Pose a frame that hangs on another one now."""
        self._model.context.UpdateFramePoses(FramePoseVector({frame: X_PF}))
        self._rules.measure_again()
        if self.history is not None:
            self.history.begin_anew([frame.get_value()], self._clocks.node())

    def since_now(self, frame: FrameId | None) -> Since:
        """Return now, or since when the pose of a frame in the world holds, if that is older.

        It holds since the oldest of the poses that led to it came.
        """
        since = self._clocks.arrival().since(0.0)
        if frame is None:
            return since
        line = ALWAYS
        while frame != self._model.names.world:
            line = oldest(line, self.since(frame) or ALWAYS)
            frame = self._model.inspector.GetParentFrame(frame)
        return oldest(since, line)


def _without(
    left_out: Collection[int], poses: FramePoseVector, posed: PosedFrames
) -> tuple[FramePoseVector, PosedFrames]:
    """Return poses without those of some frames."""
    free_poses = {f: poses.value(f) for f in poses.ids() if f.get_value() not in left_out}
    rest = {frames.difference(left_out): since for frames, since in posed.items()}
    rest.pop(frozenset(), None)
    return FramePoseVector(free_poses), rest


def _stamps(posed: PosedFrames, stamp: TimeMessage, feeder: str) -> dict[int, tuple[int, Since]]:
    """Return the stamps [ns] of poses by frame, and since when they hold.

    All of a message bear the same one; transforms have their own, which ``posed`` knows. Those
    that hold for good bear none.
    """
    stamps: dict[int, tuple[int, Since]] = {}
    for frames, since in posed.items():
        own = 0
        if since != ALWAYS:
            own = int(since.held * 1e9) if feeder == TF else nanoseconds_of(stamp)
        stamps.update(dict.fromkeys(frames, (own, since)))
    return stamps
