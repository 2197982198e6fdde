"""Topics of sensor data in a recording, whose maps are in no computed distance."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.message_types import CLOUD, GRID, IMAGE, OCTOMAP, RANGE, SCAN
from drake_geom_ros.recordings.raw_messages import RecordedTopic
from drake_geom_ros.recordings.recording_topics import Topics, few_of

_BY_DEFAULT = (CLOUD, IMAGE, OCTOMAP)  # types of messages from which a node makes maps
_SENSED = (*_BY_DEFAULT, SCAN, RANGE, GRID)  # of these only where its scene names the topic


def maps_in(
    recorded: Sequence[RecordedTopic], topics: Topics, of_scene: Iterable[str] = ()
) -> tuple[str, ...]:
    """Return the topics from which a node made maps, or may have, since it remaps its inputs.

    ``of_scene`` are those of the scene's obstacle sources, recorded or not. Raises RecordingError
    for a named topic that was not recorded, or is of another type.
    """
    if topics.obstacles is None:
        candidates = [topic.name for topic in recorded if _may_be_of_maps(topic)]
        return tuple(dict.fromkeys((*candidates, *map(topics.full, of_scene))))
    named = tuple(topics.full(name) for name in topics.obstacles.split(',') if name)
    by_name = {topic.name: topic for topic in recorded}
    like = [topic.name for topic in recorded if topic.type in _SENSED]
    for name in named:
        if name not in by_name:
            raise RecordingError(
                f'obstacles: no topic {name!r} was recorded{nearest(name, like)}; there are '
                f'{few_of(like)}'
            )
        if by_name[name].type not in _SENSED:
            raise RecordingError(
                f'{name} is of the type {by_name[name].type}, and obstacles are of '
                f'{", ".join(_SENSED)}; of these types there are {few_of(like)}'
            )
    return named


def maps_remark(maps: Sequence[str]) -> str:
    """Return a remark that sensed maps are in no distance; empty without maps."""
    if not maps:
        return ''
    return (
        f'what sensors see, on {" and ".join(maps)}, is in no distance: pairs with maps of it are '
        'not computed; --topic obstacles= says that no node made maps, obstacles=TOPIC of what it '
        'did'
    )


def _may_be_of_maps(topic: RecordedTopic) -> bool:
    is_image = topic.type == IMAGE
    return topic.type in _BY_DEFAULT and (not is_image or 'depth' in topic.name)
