"""Which topics of a recording are used, and as what."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, fields, replace

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.message_types import CLOCK, JOINTS, POSES, TEXT, TF
from drake_geom_ros.recordings.raw_messages import Topic

_MOST_SHOWN = 20


@dataclass(frozen=True)
class Topics:
    """The topic of each kind of input; empty: none, None: the usual one if it was recorded.

    The usual ones are ``/tf``, ``/joint_states`` and so on, of poses the only topic of
    ``drake_geom_msgs/msg/FramePoses``. Descriptions of robots are taken where there is no scene,
    or where their topic is named.
    """

    tf: str | None = None
    tf_static: str | None = None
    joint_states: str | None = None
    frame_poses: str | None = None
    robot_description: str | None = None
    robot_description_semantic: str | None = None
    clock: str | None = None

    @classmethod
    def of(cls, texts: Iterable[str]) -> Topics:
        """Return what ``NAME=TOPIC`` says; raises RecordingError for another name."""
        names = [field.name for field in fields(cls)]
        given = {}
        for text in texts:
            name, equals, topic = text.partition('=')
            if name not in names or not equals:
                raise RecordingError(
                    f'a topic is given as NAME=TOPIC, and not {text!r}; NAME is one of '
                    f'{", ".join(names)}'
                )
            given[name] = topic
        return replace(cls(), **given)


_TYPES = {
    'tf': TF,
    'tf_static': TF,
    'joint_states': JOINTS,
    'frame_poses': POSES,
    'robot_description': TEXT,
    'robot_description_semantic': TEXT,
    'clock': CLOCK,
}


def roles_of(
    recorded: Sequence[Topic],
    asked: Topics,
    robots_topics: Collection[str] = (),
    *,
    with_robots: bool = True,
) -> dict[str, str]:
    """Return {topic: what it is used as} of those that were recorded.

    Topics of joint values that robots of the scene name have the role ``joint_states:TOPIC``.
    ``with_robots``: descriptions of robots count although their topics are not named. Raises
    RecordingError for one that is named and was not recorded, that is of another type, or where
    several could be meant.
    """
    found: dict[str, str] = {}
    for role, kind in _TYPES.items():
        named = getattr(asked, role)
        if named is None and role.startswith('robot') and not with_robots:
            continue
        if topic := _topic_of(role, kind, named, recorded):
            found[topic] = role
    for name in robots_topics:
        topic = name if name.startswith('/') else f'/{name}'
        _check(topic, 'joint_states', JOINTS, recorded)
        if any(each.name == topic for each in recorded):
            found[topic] = f'joint_states:{name}'
    return found


def _topic_of(role: str, kind: str, named: str | None, recorded: Sequence[Topic]) -> str:
    """Return the topic of a role; empty for none."""
    names = [topic.name for topic in recorded]
    if named == '':
        return ''
    if named is None and role == 'frame_poses':
        of_type = sorted({topic.name for topic in recorded if topic.type == kind})
        if len(of_type) > 1:
            raise RecordingError(
                f'poses were recorded on {" and ".join(of_type)}: say which by '
                f'frame_poses={of_type[0]}, or frame_poses= for none'
            )
        return of_type[0] if of_type else ''
    topic = f'/{role}' if named is None else named if named.startswith('/') else f'/{named}'
    if topic not in names:
        if named is None:
            return ''
        raise RecordingError(
            f'{role}: no topic {topic!r} was recorded{nearest(topic, names)}; there are '
            f'{_some(names)}'
        )
    _check(topic, role, kind, recorded)
    return topic


def _check(topic: str, role: str, kind: str, recorded: Sequence[Topic]) -> None:
    """Raise RecordingError for a topic of another type."""
    types = [each.type for each in recorded if each.name == topic and each.type != kind]
    if types:
        others = sorted({each.name for each in recorded if each.type == kind})
        like = f'; of this type there are {_some(others)}' if others else ''
        raise RecordingError(
            f'{topic} is of the type {types[0]}, and {role} is {kind}: name another topic by '
            f'{role}=TOPIC, or none by {role}={like}'
        )


def told_nothing(recorded: Sequence[Topic], roles: dict[str, str]) -> str:
    """Return in words which topics were used, and which others could be."""
    used = _some(sorted(roles)) if roles else 'none'
    like = {
        topic.name: role
        for topic in recorded
        for role, kind in _TYPES.items()
        if topic.type == kind and topic.name not in roles and kind != TEXT
    }
    hints = [f'{role}={name}' for name, role in sorted(like.items())]
    return f'topics used: {used}' + (f'; others could be: {_some(hints)}' if hints else '')


def _some(names: Sequence[str]) -> str:
    more = f' and {len(names) - _MOST_SHOWN} more' if len(names) > _MOST_SHOWN else ''
    return (', '.join(names[:_MOST_SHOWN]) or 'none') + more
