"""The live scene at the stamp of a measurement, which belongs to the poses of that time.

The pose of a stamp comes with the next message of its sender, so it is waited for, a little. What
is not known by then is not guessed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    QueryObject,
    SceneGraphInspector,
)
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Since
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.pose_history import PosesAround
from drake_geom_ros.live.scene.tracks import UnknownThenError
from drake_geom_ros.math import RigidTransform

PATIENCE = 0.5  # [s] until a pose of a stamp has to be known
_AHEAD = 0.1  # [s] by which a stamp may be later than the node's time: clocks differ
_OLDEST = 10.0  # [s] by which it may be earlier
_LOOKS = 0.005  # [s] between two looks


class UnknownYetError(ArgumentError):
    """The poses of a stamp are not known yet; they may be, later."""


class Moment(NamedTuple):
    """The scene at a stamp: frames of interest are where they were then."""

    query: QueryObject
    X_WF: RigidTransform  # of the frame that was asked about
    since: Since
    stamp: Any
    replaced: int  # of the scene that it is of


# Of a model of the scene: what is the same of two is the same but for the cells of sensed maps.
Model = tuple[int, int]

# Which other frames have to be where they were, by a query of the scene and its model.
Interest = Callable[[QueryObject, Model], Collection[FrameId]]

# Where a frame is that may be none of the scene: one of the scene, and its pose X_PF in that; or
# the name of what is not known of that time yet.
Hanging = Callable[[HeldScene, str, float], tuple[FrameId, RigidTransform] | str]


def moment_of(
    live: LiveScene,
    header: Any,
    waited: float,
    hanging: Hanging,
    bodies: Interest,
    patience: float = PATIENCE,
) -> Moment:
    """Return the scene at the stamp of a header, the frame of which may be any.

    ``bodies`` returns the other frames that have to be where they were. Raises ArgumentError where
    the stamp or the frame is none, and where it is not known where they were then;
    UnknownYetError where that may be known after ``patience`` [s].
    """
    stamp = header.stamp
    held = seconds_of(stamp)
    if not held:
        raise ArgumentError('header.stamp is 0; what a sensor saw belongs to the poses of a time')
    arrival = live.clocks.arrival(waited)
    deadline = time.monotonic() + patience
    while True:
        ahead = held - live.clocks.node()
        if ahead < -_OLDEST:
            raise ArgumentError(
                f'header.stamp is {-ahead:.3f} s before the time of the node; at most '
                f'{_OLDEST:g} s are taken'
            )
        moment = None if ahead > _AHEAD else _look(live, header, held, hanging, bodies)
        if isinstance(moment, Moment):
            return moment._replace(since=arrival.since(held), stamp=stamp)
        if time.monotonic() >= deadline:
            break
        time.sleep(_LOOKS)
    if moment is None:
        raise UnknownYetError(
            f'header.stamp is {ahead:.3f} s after the time of the node: it is from the future'
        )
    raise UnknownYetError(
        f'where {moment} was at the stamp of the message is not known: no pose of then or later '
        f'came within {PATIENCE:g} s'
    )


def lasting_moment(live: LiveScene, header: Any, hanging: Hanging) -> Moment:
    """Return the scene of now for what a header's frame holds for good; the stamp has no say.

    Raises ArgumentError for a frame that does not rest in the world.
    """
    with live.reading() as scene:
        X_WF = resting_pose(scene, header, hanging)
        return Moment(scene.view().query, X_WF, ALWAYS, header.stamp, scene.replaced)


def resting_pose(scene: HeldScene, header: Any, hanging: Hanging) -> RigidTransform:
    """Return the pose of a header's frame in the world; raises ArgumentError unless it rests."""
    place = hanging(scene, header.frame_id, math.inf)  # no moving transform knows that time
    moving = place if isinstance(place, str) else _moving_below(scene, place[0])
    if moving or isinstance(place, str):
        raise ArgumentError(
            f'the map is static, and its frame {header.frame_id[:80]!r} hangs on {moving}, '
            'which moves or has no pose: name a frame that rests in the world'
        )
    frame, X_PF = place
    return scene.query.X_WF(frame) @ X_PF


def _moving_below(scene: HeldScene, frame: FrameId) -> str:
    """Return the name of a frame, or one that carries it, that does not rest; empty: all do."""
    names = scene.model.names
    while frame != names.world:
        if scene.poses.since(frame) != ALWAYS:
            return names.frame_names[frame]
        frame = scene.model.inspector.GetParentFrame(frame)
    return ''


def _look(
    live: LiveScene,
    header: Any,
    held: float,
    hanging: Hanging,
    bodies: Interest,
) -> Moment | str:
    """Return the moment, or the names of the frames of which it is not known yet."""
    with live.reading() as scene:
        place = hanging(scene, header.frame_id, held)
        if isinstance(place, str):
            return place
        frame, X_PF = place
        assert scene.poses.history is not None, 'who takes what sensors saw has it kept'
        then = _Then(scene, scene.poses.history.around(held))
    # The scene moves on from here. The sensor comes first: mostly it is what is waited for.
    if later := then.know_all({frame}) or then.know_all(set(bodies(then.view.query, then.model))):
        return later
    ids = np.array([f.get_value() for f in then.moving], dtype=np.int64)
    rows = np.array(list(then.moving.values())).reshape(-1, 7)
    then.view.context.UpdateFramePoses(FramePoseVector.FromArrays(ids, rows))
    X_WF = then.view.query.X_WF(frame) @ X_PF
    return Moment(then.view.query, X_WF, ALWAYS, header.stamp, then.replaced)


class _Then:
    """Poses of frames at a time, each as far as it is known."""

    def __init__(self, scene: HeldScene, around: PosesAround) -> None:
        self.view = scene.view()
        self.names, self.replaced = scene.model.names, scene.replaced
        self.model = scene.replaced, scene.model.model_version
        self.moving: dict[FrameId, NDArray[np.float64]] = {}  # X_PF (7,) of those that do
        self._around = around
        self._since = {frame: scene.poses.since(frame) for frame in scene.model.names.labels}
        self._known: dict[FrameId, RigidTransform] = {}
        self._asked: list[FrameId] = []

    @property
    def inspector(self) -> SceneGraphInspector:
        return self.view.query.inspector()

    def X_WF(self, frame: FrameId) -> RigidTransform:
        if frame == self.names.world:
            return RigidTransform()
        return self.X_WF(self.inspector.GetParentFrame(frame)) @ self.X_PF(frame)

    def know_all(self, frames: Collection[FrameId]) -> str:
        """Find out where frames were, and what they hang on; return which are not known yet.

        Raises ArgumentError for those that never had a pose, and of which nobody will know.
        """
        later, lost = set[str](), set[str]()
        for each in frames:
            here = each
            while here != self.names.world:
                try:
                    self._know(here)
                except UnknownThenError as unknown:
                    (later if unknown.is_later else lost).add(self.names.frame_names[here])
                here = self.inspector.GetParentFrame(here)
        if lost:
            raise ArgumentError(
                f'where {some_of(sorted(lost))} was at the stamp of the message is not known: it '
                'is before the poses that are kept, in a gap between them, or before the frame '
                'was posed by another sender or hung on another frame'
            )
        return some_of(sorted(later))

    def X_PF(self, frame: FrameId) -> RigidTransform:
        """Return the pose in the parent; raises ArgumentError for what never had one."""
        self._know(frame)
        if frame not in self._known:
            self._known[frame] = RigidTransform.FromArray(self.moving[frame])
        return self._known[frame]

    def _know(self, frame: FrameId) -> None:
        if frame in self._known or frame in self.moving:
            return
        if frame in self._asked:  # a robot that stands on its own link
            raise UnknownThenError(is_later=False)
        self._asked.append(frame)
        try:
            self._find(frame)
        finally:
            self._asked.pop()

    def _find(self, frame: FrameId) -> None:
        since, query = self._since[frame], self.view.query
        if since is None or not query.is_placed(frame):
            raise ArgumentError(
                f'{self.names.frame_names[frame]} has no pose yet, so nobody knows where what was '
                'seen is'
            )
        if since == ALWAYS and not self._around.was_another(frame.get_value()):
            self._known[frame] = query.X_PF(frame)
        else:
            self.moving[frame] = self._around.row(frame.get_value(), self)
