"""Opened recording, ready to play: its scene, and the roles of its topics."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from drake_geom_ros.geometry import AccuracyLike
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.playback import Playback
from drake_geom_ros.recordings.recorded_maps import maps_in
from drake_geom_ros.recordings.recording import Recording
from drake_geom_ros.recordings.recording_topics import Topics, no_robot_reason, roles_of
from drake_geom_ros.scene_files import ObstacleSource, SceneDescription, read_scene

_ROBOT = 'robot_description'


class Opened(NamedTuple):
    """A recording with its playback, the roles of its topics, and its sensor topics."""

    recording: Recording
    playback: Playback
    roles: dict[str, str]
    maps: tuple[str, ...]  # topics of sensor data, which are in no distance


def opened_recording(
    path: str | Path | Sequence[str | Path],
    *,
    scene: str | Path | SceneDescription | None,
    topics: Topics | None,
    stale_after: float,
    accuracy: AccuracyLike,
    world_frame: str,
    package_roots: Sequence[str | Path],
) -> Opened:
    """Open a recording; without a scene, use the robot whose description was recorded.

    Arguments are those of ``clearance``. Raises RecordingError, SceneFileError.
    """
    recording, topics = Recording(path), topics or Topics()
    if recording.is_empty:
        names = ', '.join(map(str, recording.files))
        raise RecordingError(f'{names}: no message was recorded')
    if isinstance(scene, (str, Path)):
        scene = read_scene(str(scene), package_roots=[str(root) for root in package_roots])
    alone = scene is None
    roles = roles_of(recording.topics, topics)
    silent = _silent_clocks(recording, roles)
    playback = Playback(
        scene,
        stale_after,
        simulated='clock' in roles.values() and not silent,
        world_frame=world_frame,
        package_roots=package_roots,
        accuracy=accuracy,
    )
    if alone and _ROBOT not in roles.values():
        raise RecordingError(no_robot_reason(recording.topics))
    for topic in silent:
        playback.note(f'{topic} has no message: the time of recording counts', recording.begin)
    _take_robots(recording, playback, roles, alone=alone)
    robots = playback.robots_topics()
    recorded = {topic.name for topic in recording.topics}
    for missing in sorted({*map(topics.full, robots)} - recorded):
        playback.note(f'{missing}, which moves a robot, was not recorded', recording.begin)
    roles = roles_of(recording.topics, topics, robots)
    roles = {topic: role for topic, role in roles.items() if topic not in silent}
    if 'tracked_objects' in roles.values():
        playback.expect_trackers()
    sensors = () if scene is None else map(_topic_of, scene.obstacle_sources)
    maps = maps_in(recording.topics, topics, sensors)
    return Opened(recording, playback, roles, maps)


def _topic_of(source: ObstacleSource) -> str:
    """Return the topic of a source, of a node that is called as usual."""
    return source.topic.replace('~/', '/scene_graph/')


def _silent_clocks(recording: Recording, roles: dict[str, str]) -> list[str]:
    """Return the clock topics without messages, by which time would stand still."""
    clocks = [topic for topic, role in roles.items() if role == 'clock']
    return [
        topic
        for topic in clocks
        if all(each.message is None for each in recording.messages([topic]))
    ]


def _take_robots(
    recording: Recording, playback: Playback, roles: dict[str, str], *, alone: bool
) -> None:
    """Process the first robot descriptions before others, since they are latched.

    ``alone``: there is no scene besides the robot, so a refused description raises
    RecordingError. Otherwise it is refused, and counted, when its turn comes.
    """
    missing = {topic for topic, role in roles.items() if role.startswith(_ROBOT)}
    if not missing:
        return
    for recorded in recording.messages(sorted(missing)):
        if recorded.topic.name in missing and recorded.message is not None:
            missing.discard(recorded.topic.name)
            is_semantic = roles[recorded.topic.name] != _ROBOT
            try:
                playback.take_robot(recorded.message.data, is_semantic=is_semantic)
            except RuntimeError as error:
                if alone:
                    raise RecordingError(f'{recorded.topic.name}: {error}') from None
        if not missing:
            return
