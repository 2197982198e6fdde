"""The live scene as it was at a stamp: what is measured then belongs to the poses of then. No ROS.

The pose of a stamp comes with the next message of its sender, so it is waited for, a little. What
is not known by then is not guessed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector, QueryObject
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.conversions.fields import seconds_of
from drake_geom_ros.ros.conversions.names import some_of
from drake_geom_ros.ros.scene.clocks import ALWAYS, Since
from drake_geom_ros.ros.scene.held_scene import HeldScene
from drake_geom_ros.ros.scene.live_scene import LiveScene

PATIENCE = 0.5  # [s] until a pose of a stamp has to be known
_AHEAD = 0.1  # [s] by which a stamp may be later than the node's time: clocks differ
_OLDEST = 10.0  # [s] by which it may be earlier
_LOOKS = 0.005  # [s] between two looks


class Moment(NamedTuple):
    """What the scene was at a stamp: frames of interest are where they were then."""

    query: QueryObject
    X_WF: RigidTransform  # of the frame that was asked about
    since: Since
    stamp: Any
    replaced: int  # of the scene that it is of


# Where a frame is that may be none of the scene: one of the scene, and its pose X_PF in that; or
# the name of what is not known of that time yet.
Hanging = Callable[[HeldScene, str, float], tuple[FrameId, RigidTransform] | str]


def moment_of(
    live: LiveScene,
    header: Any,
    waited: float,
    hanging: Hanging,
    bodies: Callable[[QueryObject], Collection[FrameId]],
) -> Moment:
    """Return the scene at the stamp of a header, the frame of which may be any.

    ``bodies`` tells which other frames have to be where they were. Raises ArgumentError where
    the stamp or the frame is none, and where it is not known where they were then.
    """
    stamp = header.stamp
    held = seconds_of(stamp)
    if not held:
        raise ArgumentError('header.stamp is 0; what a sensor saw belongs to the poses of a time')
    arrival = live.clocks.arrival(waited)
    deadline = time.monotonic() + PATIENCE
    while True:
        ahead = held - live.clocks.node()
        if ahead < -_OLDEST:
            raise ArgumentError(
                f'header.stamp is {-ahead:.3f} s before the time of the node; at most '
                f'{_OLDEST:g} s are taken'
            )
        found = None if ahead > _AHEAD else _look(live, header, held, hanging, bodies)
        if isinstance(found, Moment):
            return found._replace(since=arrival.since(held), stamp=stamp)
        if time.monotonic() > deadline:
            break
        time.sleep(_LOOKS)
    if found is None:
        raise ArgumentError(
            f'header.stamp is {ahead:.3f} s after the time of the node: it is from the future'
        )
    raise ArgumentError(
        f'where {found} was at the stamp of the message is not known: no pose of then or later '
        f'came within {PATIENCE:g} s'
    )


def _look(
    live: LiveScene,
    header: Any,
    held: float,
    hanging: Hanging,
    bodies: Callable[[QueryObject], Collection[FrameId]],
) -> Moment | str:
    """Return the moment, or the names of the frames of which it is not known yet."""
    with live.reading() as scene:
        place = hanging(scene, header.frame_id, held)
        if isinstance(place, str):
            return place
        frame, X_PF = place
        view = scene.view()
        wanted = _moving(scene, {frame, *bodies(view.query)})
        assert scene.history is not None, 'who takes what sensors saw has it kept'
        then = scene.history.at(held, wanted)
        names = {f.get_value(): name for f, name in scene.names.frame_names.items()}
        replaced = scene.replaced
    if then.lost:
        lost = some_of(sorted(names[value] for value in then.lost))
        raise ArgumentError(
            f'where {lost} was at the stamp of the message is not known: it is before the poses '
            'that are kept, or in a gap between them'
        )
    if then.later:
        return some_of(sorted(names[value] for value in then.later))
    view.context.UpdateFramePoses(FramePoseVector.FromArrays(then.ids, then.rows))
    X_WF = view.query.X_WF(frame) @ X_PF
    return Moment(view.query, X_WF, ALWAYS, header.stamp, replaced)


def _moving(scene: HeldScene, frames: Collection[FrameId]) -> set[int]:
    """Return the frames, and those that they hang on, whose poses do not hold for good.

    Raises ArgumentError where one never had a pose.
    """
    inspector, world = scene.inspector, scene.names.world
    found: set[int] = set()
    seen: set[FrameId] = set()
    for start in frames:
        frame = start
        while frame != world and frame not in seen:
            seen.add(frame)
            since = scene.posed_since(frame)
            if since is None or not scene.query.is_placed(frame):
                raise ArgumentError(
                    f'{scene.names.frame_names[frame]} has no pose yet, so nobody knows where '
                    'what was seen is'
                )
            if since != ALWAYS:
                found.add(frame.get_value())
            frame = inspector.GetParentFrame(frame)
    return found
