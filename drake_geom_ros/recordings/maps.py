"""Which topics of a recording are what sensors see: no distance is computed with maps of it."""

from __future__ import annotations

from collections.abc import Sequence

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.message_types import CLOUD, IMAGE, OCTOMAP
from drake_geom_ros.recordings.raw_messages import Topic
from drake_geom_ros.recordings.topics import Topics, few_of

_SENSED = (CLOUD, IMAGE, OCTOMAP)  # types of messages that a node makes maps of


def maps_in(recorded: Sequence[Topic], asked: Topics) -> tuple[str, ...]:
    """Return the topics of which a node made maps, or may have: it remaps its inputs.

    Raises RecordingError for one that is named and was not recorded, or is of another type.
    """
    if asked.obstacles is None:
        found = [topic.name for topic in recorded if _may_be_of_maps(topic)]
        return tuple(dict.fromkeys(found))
    named = tuple(asked.full(name) for name in asked.obstacles.split(',') if name)
    known = {topic.name: topic for topic in recorded}
    like = [topic.name for topic in recorded if topic.type in _SENSED]
    for name in named:
        if name not in known:
            raise RecordingError(
                f'obstacles: no topic {name!r} was recorded{nearest(name, like)}; there are '
                f'{few_of(like)}'
            )
        if known[name].type not in _SENSED:
            raise RecordingError(
                f'{name} is of the type {known[name].type}, and obstacles are of '
                f'{", ".join(_SENSED)}; of these types there are {few_of(like)}'
            )
    return named


def told_maps(maps: Sequence[str]) -> str:
    """Return in words that what sensors see is not computed with; empty without maps."""
    if not maps:
        return ''
    return (
        f'what sensors see, on {" and ".join(maps)}, is in no distance: pairs with maps of it are '
        'not computed; --topic obstacles= says that no node made maps, obstacles=TOPIC of what it '
        'did'
    )


def _may_be_of_maps(topic: Topic) -> bool:
    is_image = topic.type == IMAGE
    return topic.type in _SENSED and (not is_image or 'depth' in topic.name)
