"""Topics of a recording and their roles."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.message_types import (
    CLOCK,
    JOINTS,
    POSES,
    SCENE,
    TEXT,
    TF,
    TRACKED,
)
from drake_geom_ros.recordings.raw_messages import RecordedTopic

_MOST_SHOWN = 20


@dataclass(frozen=True)
class Topics:
    """Topic names by kind of input; empty: none, None: the default topic if it was recorded.

    Defaults are ``/tf``, ``/joint_states`` and so on, and for poses the only topic of
    ``drake_geom_msgs/msg/FramePoses``. Robot descriptions are used besides a scene too, as in a
    node. ``scene`` is the ``~/scene`` of the node, with which the played scene is compared; by
    default the one beside the poses, or all. ``tracked_objects`` are the bodies of trackers, by
    default the only topic of ``drake_geom_msgs/msg/TrackedObjects``.

    A ``namespace``, such as ``cell_1``, applies to all defaults but ``/clock``, to ``/tf`` and
    ``/tf_static`` if they were recorded in it, to names without a leading slash, also those of
    robots in the scene, and to the node's results.

    ``obstacles`` are the topics from which a node made maps, separated by commas. None: all
    clouds and OctoMaps, and images with ``depth`` in their topic's name, since any may be one.
    """

    tf: str | None = None
    tf_static: str | None = None
    joint_states: str | None = None
    frame_poses: str | None = None
    robot_description: str | None = None
    robot_description_semantic: str | None = None
    clock: str | None = None
    scene: str | None = None
    tracked_objects: str | None = None
    obstacles: str | None = None
    namespace: str = ''

    @classmethod
    def of(cls, texts: Iterable[str], namespace: str = '') -> Topics:
        """Return topics of texts ``NAME=TOPIC``; RecordingError for unknown or duplicate names."""
        topics = {'namespace': namespace}
        for text in texts:
            name, equals, topic = text.partition('=')
            if name not in NAMES or not equals:
                raise RecordingError(
                    f'a topic is given as NAME=TOPIC, and not {text!r}; NAME is one of '
                    f'{", ".join(NAMES)}'
                )
            if name in topics:
                raise RecordingError(
                    f'{name} is given twice, as {topics[name]!r} and {topic!r}; obstacles may be '
                    'several topics with commas between, all others are one'
                )
            topics[name] = topic
        return replace(cls(), **topics)

    def full(self, name: str) -> str:
        """Return the full name of a topic, as a node in the namespace resolves it."""
        return name if name.startswith('/') else f'{self.prefix}{name}'

    @property
    def prefix(self) -> str:
        """The prefix of names in the namespace."""
        space = self.namespace.strip('/')
        return f'/{space}/' if space else '/'


KINDS = {  # types of messages by role
    'tf': TF,
    'tf_static': TF,
    'joint_states': JOINTS,
    'frame_poses': POSES,
    'robot_description': TEXT,
    'robot_description_semantic': TEXT,
    'clock': CLOCK,
    'scene': SCENE,
    'tracked_objects': TRACKED,
}

_CALLED = {'frame_poses': 'poses', 'tracked_objects': 'tracked bodies'}
NAMES = (*KINDS, 'obstacles')  # fields of Topics


def roles_of(
    recorded: Sequence[RecordedTopic],
    topics: Topics,
    robots_topics: Collection[str] = (),
) -> dict[str, str]:
    """Return the roles of recorded topics by name.

    Topics of joint states that robots of the scene name have the role ``joint_states:TOPIC``.
    Raises RecordingError for a named topic that was not recorded or is of another type, and for
    an ambiguous default.
    """
    _check_namespace(topics, recorded)
    roles: dict[str, str] = {}
    for role, kind in KINDS.items():
        if role == 'scene' and topics.scene is None:
            continue
        if topic := _topic_of(role, kind, topics, recorded):
            roles[topic] = role
    if topics.scene is None:
        roles |= dict.fromkeys(_topics_of_scenes(topics, recorded, roles), 'scene')
    for name in robots_topics:
        topic = topics.full(name)
        _check(topic, 'the topic of joint values of a robot in the scene', JOINTS, recorded)
        if any(each.name == topic for each in recorded):
            roles[topic] = f'joint_states:{name}'
    return roles


def _check_namespace(topics: Topics, recorded: Sequence[RecordedTopic]) -> None:
    """Raise RecordingError for a namespace in which nothing was recorded."""
    names = [topic.name for topic in recorded]
    if names and not any(name.startswith(topics.prefix) for name in names):
        raise RecordingError(
            f'namespace {topics.namespace!r}: no topic in it was recorded; there are '
            f'{few_of(names)}'
        )


def _topic_of(role: str, kind: str, topics: Topics, recorded: Sequence[RecordedTopic]) -> str:
    """Return the topic of a role; empty for none."""
    names, named = [topic.name for topic in recorded], getattr(topics, role)
    if named == '':
        return ''
    if named is None and role in ('frame_poses', 'tracked_objects'):
        return _only_topic(role, kind, topics, recorded)
    topic = _usual(role, topics, names) if named is None else topics.full(named)
    if topic not in names:
        if named is None:
            return ''
        raise RecordingError(
            f'{role}: no topic {topic!r} was recorded{nearest(topic, names)}; there are '
            f'{few_of(names)}'
        )
    _check(topic, role, kind, recorded)
    return topic


def _only_topic(role: str, kind: str, topics: Topics, recorded: Sequence[RecordedTopic]) -> str:
    """Return the only topic of a type, whatever the name of the node."""
    of_type = sorted({topic.name for topic in recorded if topic.type == kind})
    of_type = [name for name in of_type if name.startswith(topics.prefix)]
    if len(of_type) > 1:
        raise RecordingError(
            f'{_CALLED[role]} were recorded on {" and ".join(of_type)}: say which by '
            f'--topic {role}={of_type[0]}, or --topic {role}= for none; a --namespace '
            'leaves those in it'
        )
    return of_type[0] if of_type else ''


def _topics_of_scenes(
    topics: Topics, recorded: Sequence[RecordedTopic], roles: dict[str, str]
) -> list[str]:
    """Return the scene topic of the node whose poses are used, or those of the namespace."""
    names = [topic.name for topic in recorded if topic.type == SCENE]
    names = [name for name in names if name.startswith(topics.prefix)]
    nodes = [name.rpartition('/')[0] for name, role in roles.items() if role == 'frame_poses']
    beside = [name for name in names if name.rpartition('/')[0] in nodes]
    return beside or names


def _usual(role: str, topics: Topics, names: Sequence[str]) -> str:
    """Return the default topic of a node in the namespace; TF may be global or its own."""
    shared, own = f'/{role}', topics.full(role)
    if role == 'clock' or (role.startswith('tf') and own not in names):
        return shared
    if role.startswith('tf') and own != shared and shared in names:
        raise RecordingError(
            f'both {shared} and {own} were recorded: say which by --topic {role}={own}'
        )
    return own


def _check(topic: str, role: str, kind: str, recorded: Sequence[RecordedTopic]) -> None:
    """Raise RecordingError for a topic of another type."""
    types = [each.type for each in recorded if each.name == topic and each.type != kind]
    if types:
        others = sorted({each.name for each in recorded if each.type == kind})
        like = f'; of this type there are {few_of(others)}' if others else ''
        advice = (
            f': name another topic by --topic {role}=TOPIC, or none by --topic {role}='
            if role in KINDS
            else ''
        )
        raise RecordingError(
            f'{topic} is of the type {types[0]}, and {role} is {kind}{advice}{like}'
        )


def topics_remark(recorded: Sequence[RecordedTopic], roles: dict[str, str]) -> str:
    """Return a remark about the used topics, and about others that could be used."""
    return f'topics used: {few_of(sorted(roles)) if roles else "none"}{_others(recorded, roles)}'


def no_robot_reason(recorded: Sequence[RecordedTopic]) -> str:
    """Return the error text for a missing robot description, with possible topics."""
    texts = [topic.name for topic in recorded if topic.type == TEXT]
    words = 'no scene was given, and no robot_description was recorded: give a scene file'
    if not texts:
        return f'{words}; no topic of the type {TEXT} was recorded'
    named = [name for name in texts if name.endswith('/robot_description')]
    first = (named or texts)[0]
    space = first.removesuffix('/robot_description').strip('/')
    by = f', or all of a namespace by --namespace {space}' if named and space else ''
    return (
        f'{words}, or say which topic it is by --topic robot_description={first}{by}; of its type '
        f'there are {few_of(texts)}'
    )


def _others(recorded: Sequence[RecordedTopic], roles: dict[str, str]) -> str:
    """Return a remark about unused topics that could be used."""
    like = {
        topic.name: role
        for topic in recorded
        for role, kind in KINDS.items()
        if topic.type == kind and topic.name not in roles and kind != TEXT
    }
    hints = [f'--topic {role}={name}' for name, role in sorted(like.items())]
    spaces = sorted({name.split('/')[1] for name in like if name.count('/') > 1})
    hints += [f'--namespace {space}' for space in spaces]
    return f'; others could be: {few_of(hints)}' if hints else ''


def few_of(names: Sequence[str]) -> str:
    """Return names separated by commas, only the first ones if they are many."""
    more = f' and {len(names) - _MOST_SHOWN} more' if len(names) > _MOST_SHOWN else ''
    return (', '.join(names[:_MOST_SHOWN]) or 'none') + more
