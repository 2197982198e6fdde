"""Input of bodies that trackers see, such as people: each a frame and a geometry of the scene.

A message is taken whole or refused whole. Most move bodies that are there, which takes as long as
a message of poses. One that brings a body, or another shape, changes the scene, beside the cycles
where that takes long; meanwhile the heartbeat grows old, so rules do not take it for nothing near.
"""

from __future__ import annotations

import operator
import threading
from collections.abc import Collection, Sequence

import numpy as np

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError, FramePoseVector
from drake_geom_ros.live.conversions.fields import nanoseconds_of, seconds_of
from drake_geom_ros.live.conversions.names import TRACKED, some_of
from drake_geom_ros.live.conversions.tracked_objects import MOST_BODIES, Bodies
from drake_geom_ros.live.scene.changes.tracked_update import tracked_update
from drake_geom_ros.live.scene.clocks import Since
from drake_geom_ros.live.scene.feeders import TRACKERS
from drake_geom_ros.live.scene.feeds import Feed
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.moments import Hanging, moment_of
from drake_geom_ros.live.scene.pose_history import PoseHistory
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import compose, matrices_from_poses, poses_from_matrices


class TrackedInput:
    """Has the bodies of messages in the scene, until they are not named for their lifetimes."""

    def __init__(self, live: LiveScene, hanging: Hanging) -> None:
        """``hanging`` finds the frames of headers that are not the world."""
        self._live, self._hanging = live, hanging
        self._lock = threading.Lock()  # one changes bodies at a time; taken before the scene
        # Names and shapes of the last message, and the bodies of the scene that it was about.
        self._moved: tuple[object, object, object] = (), (), ()
        with live.editing() as scene:
            scene.tracked.stand = _stand

    def take(
        self, bodies: Bodies, waited: float = 0.0, sender: str = '', topic: str = TRACKERS
    ) -> int:
        """Take the bodies of a message that came ``waited`` [s] ago; return how many moved.

        ``sender`` is the identity of its publisher. Raises RuntimeError to refuse it whole.
        """
        with self._lock:
            bodies, since = self._in_world(bodies, waited)
            feed = Feed(topic, sender)

            def pose(scene: HeldScene) -> None:
                _pose(scene, bodies, since, feed, waited)

            with self._live.editing() as scene:
                if not self._changes(scene, bodies):
                    pose(scene)
                    return len(bodies.names)
                shapes = dict(zip(bodies.names, bodies.shapes, strict=True))
                gone = _leaving(scene, bodies)
                change = tracked_update(scene, shapes, gone, pose)
                is_new = not scene.tracked.kinds.issuperset(map(type, bodies.shapes))
            self._live.change(change, calls_for_more=is_new)
        return max(1, len(bodies.names))

    def move(
        self,
        scene: HeldScene,
        bodies: Bodies,
        waited: float = 0.0,
        sender: str = '',
        topic: str = TRACKERS,
    ) -> bool:
        """Take a message like ``take``, in a scene that is held, if it only moves bodies.

        Return False where it does more, or its bodies are in a frame that is not the world, or
        other bodies are being taken; nothing has changed then.
        """
        is_in_world = bodies.header.frame_id in ('', self._live.world_frame)
        if not is_in_world or not self._lock.acquire(blocking=False):
            return False
        try:
            if self._changes(scene, bodies):
                return False
            bodies, since = self._in_world(bodies, waited)
            _pose(scene, bodies, since, Feed(topic, sender), waited)
        finally:
            self._lock.release()
        return True

    def sweep(self) -> int:
        """Take out the bodies that were not named for their lifetimes; return how many.

        While a message is being taken, which does the same, nothing is done.
        """
        if not self._lock.acquire(blocking=False):
            return 0
        try:
            with self._live.editing() as scene:
                gone = scene.tracked.ended()
                if not gone:
                    return 0
                change = tracked_update(scene, {}, gone)
                _note_gone(scene, gone)
            self._live.change(change)
        finally:
            self._lock.release()
        return len(gone)

    def _changes(self, scene: HeldScene, bodies: Bodies) -> bool:
        """Return whether bodies come, go or take another shape; raises for too many of them."""
        tracked = scene.tracked
        there = tracked.bodies
        if tracked.heartbeat is None or not bodies.gone.isdisjoint(there) or tracked.ended():
            return True
        same = bodies.names, bodies.shapes, there
        if all(map(operator.is_, same, self._moved)):
            return False
        is_same = all(
            name in there and (there[name].shape is shape or there[name].shape == shape)
            for name, shape in zip(bodies.names, bodies.shapes, strict=True)
        )
        if is_same:
            self._moved = same
        elif len(there.keys() | set(bodies.names)) > MOST_BODIES:
            raise ArgumentError(
                f'with these there would be more than {MOST_BODIES} tracked bodies; they leave '
                'when their lifetimes end'
            )
        return not is_same

    def _in_world(self, bodies: Bodies, waited: float) -> tuple[Bodies, Since]:
        """Return bodies in the world, and since when their poses hold."""
        header, live = bodies.header, self._live
        if header.frame_id in ('', live.world_frame):
            return bodies, live.clocks.arrival(waited).since(seconds_of(header.stamp))
        with live.editing() as scene:
            if scene.poses.history is None:
                scene.poses.history = PoseHistory()
        moment = moment_of(live, header, waited, self._hanging, lambda *_: ())
        return _moved(bodies, moment.X_WF), moment.since


def _leaving(scene: HeldScene, bodies: Bodies) -> list[str]:
    """Return the bodies that leave with a message, and note that."""
    there = scene.tracked.bodies
    ended = set(scene.tracked.ended()).difference(bodies.names)
    gone = sorted(bodies.gone.intersection(there) | ended)
    _note_gone(scene, sorted(ended))
    return gone


def _note_gone(scene: HeldScene, names: Collection[str]) -> None:
    if names:
        all_names = [f'{TRACKED}::{name}' for name in names]
        scene.log.notes.append(
            f'{counted(len(names), "tracked body")} not named for the lifetime, '
            f'taken out: {some_of(all_names)}'
        )


def _pose(scene: HeldScene, bodies: Bodies, since: Since, feed: Feed, waited: float) -> None:
    """Pose bodies that are there, all at once, and the heartbeat."""
    tracked, poses = scene.tracked, scene.poses
    assert tracked.heartbeat is not None
    tracked.feeds = tracked.feeds.with_message(feed, None, since)
    ids, frames = tracked.frames(bodies.names)
    stamp = bodies.header.stamp
    if len(ids):
        posed = poses.ages.posed_by(frames, since, stamp)
        if feed.publisher:
            poses.senders.note_frames(feed.publisher, frames)
        rows = np.ascontiguousarray(bodies.poses)
        poses.pose(FramePoseVector.FromArrays(ids, rows), posed, stamp, TRACKERS, rows)
        if bodies.velocities is not None:
            poses.note_joint_twists(ids, bodies.velocities, nanoseconds_of(stamp), since)
    tracked.hear(bodies.names, bodies.lifetimes, waited)
    beat = tracked.heartbeat.frame
    moments = [each for _, each in tracked.feeds.sinces()]
    oldest = max(moments, key=scene.clocks.ages()) if len(moments) > 1 else moments[0]
    if poses.since(beat) is None:
        origin = RigidTransform()
        at_rest = np.array([origin.ToArray()])
        value = frozenset([beat.get_value()])
        poses.pose(FramePoseVector({beat: origin}), {value: oldest}, stamp, TRACKERS, at_rest)
    else:
        poses.renew({frozenset([beat.get_value()]): oldest})


def _moved(bodies: Bodies, X_WH: RigidTransform) -> Bodies:
    """Return bodies of a frame H in the world."""
    R_WH, p_WH = X_WH.rotation().matrix(), X_WH.translation()
    R_HBs, p_HBs = matrices_from_poses(bodies.poses)
    poses = poses_from_matrices(*compose(R_WH[None], p_WH[None], R_HBs, p_HBs))
    velocities = bodies.velocities
    if velocities is not None:
        velocities = _turned(velocities, R_WH)
    return bodies._replace(poses=poses, velocities=velocities)


def _turned(velocities: Floats, R_WH: Floats) -> Floats:
    """Return spatial velocities (n, 6) in the axes of W."""
    turned: Floats = (velocities.reshape(-1, 2, 3) @ R_WH.T).reshape(-1, 6)
    return turned


def _stand(scene: HeldScene) -> None:
    """Have the heartbeat again in a scene that took the place of one with trackers."""
    scene.make(tracked_update(scene, {}))


def trackers_in_words(scene: HeldScene) -> Sequence[str]:
    """Return how many bodies trackers see, in words; nothing where there is no tracker."""
    if scene.tracked.heartbeat is None:
        return []
    return [f'{counted(len(scene.tracked.bodies), "tracked body")}']
