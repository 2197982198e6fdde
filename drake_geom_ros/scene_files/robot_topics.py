"""Robots that come by topics of their own: names, topics, prefixes and bases, in YAML."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import RobotOptions, SceneDescription
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.schema import check_schema, scene_schema
from drake_geom_ros.scene_files.urdf_tree import fixed_poses, root_links
from drake_geom_ros.scene_files.yaml_text import Document, read_yaml
from drake_geom_ros.scene_files.yaml_values import paddings_of_robot, pose_of

# Keys that mean what they mean for a robot of a scene file.
_OF_ROBOTS = (
    *('pose', 'joint_states', 'frame_prefix', 'solid_meshes', 'padding', 'self_collisions'),
    *('adjacent_links',),
)
_OWN = ('namespace', 'topic', 'semantic_topic')


@dataclass(frozen=True)
class RobotTopics:
    """A robot that a topic describes.

    - ``name``: that of the robot and of its source here, whatever its URDF says.
    - ``topic``, ``semantic_topic``: of its URDF and of its SRDF; the latter may be empty.
    - ``joint_states``: the topic of its joints alone; empty: that of all robots.
    - ``X_WB``: where its root link stands until it is posed; None: it waits.
    """

    name: str
    topic: str
    semantic_topic: str = ''
    joint_states: str = ''
    options: RobotOptions = field(default_factory=RobotOptions)
    X_WB: RigidTransform | None = None
    where: Location = field(default=Location('<text>'), compare=False)

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics that describe it."""
        return tuple(filter(None, (self.topic, self.semantic_topic)))


def robot_topics_of_text(text: str, called: str) -> tuple[RobotTopics, ...]:
    """Return the robots of a YAML text: keys by name; ``called`` is its name in errors.

    With a ``namespace`` the topics are ``robot_description``, ``robot_description_semantic`` and
    ``joint_states`` in it, unless they are given.

    >>> left, right = robot_topics_of_text(
    ...     '{left: {namespace: /left}, right: {topic: /right/robot_description}}', 'example'
    ... )
    >>> left.topic, left.joint_states, right.joint_states
    ('/left/robot_description', '/left/joint_states', '')

    Raises SceneFileError for an invalid text, a robot without a topic, and two of one topic.
    """
    document = read_yaml(text, called)
    check_schema(document, _schema())
    robots = [_robot(document, name, plain) for name, plain in document.value.items()]
    taken: dict[str, str] = {}
    for robot in robots:
        for topic in robot.topics:
            if topic in taken:
                raise robot.where.error(
                    f'{topic!r} describes {taken[topic]!r}, too; each robot has a topic of its own'
                )
            taken[topic] = robot.name
    return tuple(robots)


def placed_robot(description: SceneDescription, X_WB: RigidTransform) -> SceneDescription:
    """Return a description of one robot whose root link stands somewhere.

    Links that fixed joints hold to it stand there, too. Raises ValueError for several root links.
    """
    (robot,) = description.robots
    assert robot.tree is not None, 'a description has links'
    roots = root_links(robot.tree.joints, robot.tree.links)
    if len(roots) != 1:
        raise ValueError(
            f'the pose is that of the root link, but the links {", ".join(map(repr, roots))} have '
            'no parent each'
        )
    poses = fixed_poses(robot.tree.joints, roots[0], X_WB)
    frames = (replace(f, X_PF=poses.get(f.name, f.X_PF)) for f in description.frames)
    return replace(description, frames=tuple(frames), robots=(replace(robot, X_WB=X_WB),))


def _schema() -> dict[str, Any]:
    """Return the JSON schema of the text."""
    scene = scene_schema()
    of_robots = scene['definitions']['robot']['properties']
    name = {'$ref': '#/definitions/name'}
    robot = {
        'type': 'object',
        'additionalProperties': False,
        'properties': {**dict.fromkeys(_OWN, name), **{k: of_robots[k] for k in _OF_ROBOTS}},
    }
    return {
        'definitions': scene['definitions'],
        'type': 'object',
        'minProperties': 1,
        'propertyNames': name,
        'additionalProperties': robot,
    }


def _robot(document: Document, name: str, plain: Mapping[str, Any]) -> RobotTopics:
    where = document.at(name)
    namespace = plain.get('namespace', '').rstrip('/')

    def topic(key: str, last: str) -> str:
        return str(plain.get(key, f'{namespace}/{last}' if 'namespace' in plain else ''))

    described = topic('topic', 'robot_description')
    if not described:
        raise where.error(f'{name!r} has no topic; give it a namespace or a topic')
    try:
        X_WB = pose_of(plain['pose']) if 'pose' in plain else None
    except RuntimeError as error:
        raise document.at(name, 'pose').error(str(error)) from error
    return RobotTopics(
        name,
        described,
        topic('semantic_topic', 'robot_description_semantic'),
        topic('joint_states', 'joint_states'),
        RobotOptions(
            plain.get('adjacent_links') != 'kept',
            plain.get('self_collisions') == 'filtered',
            tuple(plain.get('solid_meshes', ())),
            paddings_of_robot(plain.get('padding', {})),
            plain.get('frame_prefix', ''),
            source=name,
        ),
        X_WB,
        where,
    )
