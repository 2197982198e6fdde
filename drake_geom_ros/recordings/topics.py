"""Which topics of a recording are used, and as what."""

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
)
from drake_geom_ros.recordings.raw_messages import Topic

_MOST_SHOWN = 20


@dataclass(frozen=True)
class Topics:
    """The topic of each kind of input; empty: none, None: the usual one if it was recorded.

    The usual ones are ``/tf``, ``/joint_states`` and so on, of poses the only topic of
    ``drake_geom_msgs/msg/FramePoses``. Descriptions of robots are taken beside a scene, too, as a
    node takes them. ``scene`` is the ``~/scene`` of the node, which the scene is compared with:
    None: that beside the poses, or all of them. In a ``namespace``, such as ``cell_1``, are all of
    these but ``/clock``, and ``/tf`` and ``/tf_static`` where they were recorded there; so are
    names that do not begin with a slash, also those that robots of the scene have, and what the
    node said.

    ``obstacles`` are the topics of which a node made maps, with commas between; None: all clouds
    and OctoMaps, and images with ``depth`` in their topic's name, for any of these may be.
    """

    tf: str | None = None
    tf_static: str | None = None
    joint_states: str | None = None
    frame_poses: str | None = None
    robot_description: str | None = None
    robot_description_semantic: str | None = None
    clock: str | None = None
    scene: str | None = None
    obstacles: str | None = None
    namespace: str = ''

    @classmethod
    def of(cls, texts: Iterable[str], namespace: str = '') -> Topics:
        """Return what ``NAME=TOPIC`` says; raises RecordingError for other names, or one twice."""
        given = {'namespace': namespace}
        for text in texts:
            name, equals, topic = text.partition('=')
            if name not in NAMES or not equals:
                raise RecordingError(
                    f'a topic is given as NAME=TOPIC, and not {text!r}; NAME is one of '
                    f'{", ".join(NAMES)}'
                )
            if name in given:
                raise RecordingError(
                    f'{name} is given twice, as {given[name]!r} and {topic!r}; obstacles may be '
                    'several topics with commas between, all others are one'
                )
            given[name] = topic
        return replace(cls(), **given)

    def full(self, name: str) -> str:
        """Return the full name of a topic, as a node in the namespace resolves it."""
        return name if name.startswith('/') else f'{self.prefix}{name}'

    @property
    def prefix(self) -> str:
        """What names in the namespace begin with."""
        space = self.namespace.strip('/')
        return f'/{space}/' if space else '/'


KINDS = {  # of messages, by what they are used as
    'tf': TF,
    'tf_static': TF,
    'joint_states': JOINTS,
    'frame_poses': POSES,
    'robot_description': TEXT,
    'robot_description_semantic': TEXT,
    'clock': CLOCK,
    'scene': SCENE,
}

NAMES = (*KINDS, 'obstacles')  # of what Topics knows


def roles_of(
    recorded: Sequence[Topic],
    asked: Topics,
    robots_topics: Collection[str] = (),
) -> dict[str, str]:
    """Return {topic: what it is used as} of those that were recorded.

    Topics of joint values that robots of the scene name have the role ``joint_states:TOPIC``.
    Raises RecordingError for one that is named and was not recorded, that is of another type, or
    where several could be meant.
    """
    _check_namespace(asked, recorded)
    found: dict[str, str] = {}
    for role, kind in KINDS.items():
        if role == 'scene' and asked.scene is None:
            continue
        if topic := _topic_of(role, kind, asked, recorded):
            found[topic] = role
    if asked.scene is None:
        found |= dict.fromkeys(_topics_of_scenes(asked, recorded, found), 'scene')
    for name in robots_topics:
        topic = asked.full(name)
        _check(topic, 'the topic of joint values of a robot in the scene', JOINTS, recorded)
        if any(each.name == topic for each in recorded):
            found[topic] = f'joint_states:{name}'
    return found


def _check_namespace(asked: Topics, recorded: Sequence[Topic]) -> None:
    """Raise RecordingError for a namespace in which nothing was recorded."""
    names = [topic.name for topic in recorded]
    if names and not any(name.startswith(asked.prefix) for name in names):
        raise RecordingError(
            f'namespace {asked.namespace!r}: no topic in it was recorded; there are '
            f'{few_of(names)}'
        )


def _topic_of(role: str, kind: str, asked: Topics, recorded: Sequence[Topic]) -> str:
    """Return the topic of a role; empty for none."""
    names, named = [topic.name for topic in recorded], getattr(asked, role)
    if named == '':
        return ''
    if named is None and role == 'frame_poses':
        return _topic_of_poses(asked, recorded)
    topic = _usual(role, asked, names) if named is None else asked.full(named)
    if topic not in names:
        if named is None:
            return ''
        raise RecordingError(
            f'{role}: no topic {topic!r} was recorded{nearest(topic, names)}; there are '
            f'{few_of(names)}'
        )
    _check(topic, role, kind, recorded)
    return topic


def _topic_of_poses(asked: Topics, recorded: Sequence[Topic]) -> str:
    """Return the only topic of poses, whatever the node was called."""
    of_type = sorted({topic.name for topic in recorded if topic.type == POSES})
    of_type = [name for name in of_type if name.startswith(asked.prefix)]
    if len(of_type) > 1:
        raise RecordingError(
            f'poses were recorded on {" and ".join(of_type)}: say which by '
            f'--topic frame_poses={of_type[0]}, or --topic frame_poses= for none; a --namespace '
            'leaves those in it'
        )
    return of_type[0] if of_type else ''


def _topics_of_scenes(
    asked: Topics, recorded: Sequence[Topic], roles: dict[str, str]
) -> list[str]:
    """Return the scene of the node whose poses are used, or of all nodes of the namespace."""
    names = [topic.name for topic in recorded if topic.type == SCENE]
    names = [name for name in names if name.startswith(asked.prefix)]
    nodes = [name.rpartition('/')[0] for name, role in roles.items() if role == 'frame_poses']
    beside = [name for name in names if name.rpartition('/')[0] in nodes]
    return beside or names


def _usual(role: str, asked: Topics, names: Sequence[str]) -> str:
    """Return the topic that a node of the namespace hears; TF is everybody's or its own."""
    everybodys, own = f'/{role}', asked.full(role)
    if role == 'clock' or (role.startswith('tf') and own not in names):
        return everybodys
    if role.startswith('tf') and own != everybodys and everybodys in names:
        raise RecordingError(
            f'both {everybodys} and {own} were recorded: say which by --topic {role}={own}'
        )
    return own


def _check(topic: str, role: str, kind: str, recorded: Sequence[Topic]) -> None:
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


def told_nothing(recorded: Sequence[Topic], roles: dict[str, str]) -> str:
    """Return in words which topics were used, and which others could be."""
    return f'topics used: {few_of(sorted(roles)) if roles else "none"}{_others(recorded, roles)}'


def told_no_robot(recorded: Sequence[Topic]) -> str:
    """Return in words that there is no robot, and where one could be."""
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


def _others(recorded: Sequence[Topic], roles: dict[str, str]) -> str:
    """Return in words which topics could be used that are not."""
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
    """Return names with commas between, the first of them where they are many."""
    more = f' and {len(names) - _MOST_SHOWN} more' if len(names) > _MOST_SHOWN else ''
    return (', '.join(names[:_MOST_SHOWN]) or 'none') + more
