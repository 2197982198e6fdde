"""Access by topic and service: a policy of SROS 2 for this node and for who talks to it.

    python -m drake_geom_ros.ros.policy [--namespace /cell] [--name scene_graph] > policy.xml
    ros2 security generate_artifacts -k KEYSTORE -p policy.xml

The enclave of the node bears its full name; its process of sensors is in it, too. Below it are
those of its clients: `observer` reads results and asks queries, `mover` publishes poses, points
and what sensors see, and `operator` may call everything.
The format is that of https://design.ros2.org/articles/ros2_access_control_policies.html.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

from drake_geom_ros.ros import topics
from drake_geom_ros.ros.planning_scenes import GET_PLANNING_SCENE
from drake_geom_ros.ros.sensing.protocol import SENSORS
from drake_geom_ros.ros.services.table import (
    BESIDE,
    IMAGES,
    MOTIONS,
    PLANNING,
    SERVICES,
    STATE_VALIDITY,
)
from drake_geom_ros.ros.topics import OUTPUTS

VERSION = '0.2.0'  # of the format
# Topics and services of the node; ~ is its private namespace.
# Topics of cameras and rules come and go: the star stands for any of them.
RESULTS = (*OUTPUTS, '~/transition_event', '~/cameras/*', '~/proximity_rules/*')
SHARED_RESULTS = ('/tf', '/tf_static')  # of cameras
INPUTS = tuple(row.topic for row in topics.INPUTS if '{' not in row.topic)
# Topics of the process that takes sensor messages, a node of its own.
SENSED = (
    '~/obstacles/points',
    *('~/obstacles/depth/image_rect_raw', '~/obstacles/depth/camera_info'),
)
ROBOT_TOPICS = ('robot_description', 'robot_description_semantic')
CLOCK = ('/clock',)
# Topics and services of every rclpy node, and those of life cycle nodes.
LOGS = ('/parameter_events', '/rosout')
OWN_SERVICES = tuple(
    f'~/{name}'
    for name in (
        *('describe_parameters', 'get_parameter_types', 'get_parameters', 'list_parameters'),
        *('set_parameters', 'set_parameters_atomically', 'get_type_description'),
    )
)
LIFE_CYCLE = tuple(
    f'~/{name}'
    for name in (
        *('change_state', 'get_available_states', 'get_available_transitions', 'get_state'),
        'get_transition_graph',
    )
)
_ASKED = (*(name for name, _, _ in (*BESIDE, *IMAGES, *PLANNING, *MOTIONS)), STATE_VALIDITY)
QUERIES = tuple(f'~/{name}' for name in _ASKED)
_SERVED = (*(name for name, _, _ in SERVICES), STATE_VALIDITY)
OFFERED = (*(f'~/{name}' for name in _SERVED), *LIFE_CYCLE, *OWN_SERVICES)


def policy(
    namespace: str = '/',
    name: str = 'scene_graph',
    robot_topics: Sequence[str] = ROBOT_TOPICS,
    sensor_topics: Sequence[str] = (),
    tracked_topics: Sequence[str] = (),
    gates: Sequence[tuple[str, str]] = (),
) -> str:
    """Return the policy of a node as XML.

    ``robot_topics`` are the values of the parameters, ``sensor_topics`` those of the scene's
    obstacle sources, with the camera_info of depth images, ``tracked_topics`` the values of the
    parameters tracked_markers and tracked_detections, ``gates`` the two topics of each gate.
    """
    root = f'{namespace.rstrip("/")}/'
    node = f'{root}{name}'

    def full(names: Iterable[str]) -> list[str]:
        """Return fully qualified names of the node's topics and services."""
        absolute = (f'{node}{each[1:]}' if each[0] == '~' else each for each in names)
        return sorted(each if each[0] == '/' else f'{root}{each}' for each in absolute)

    commands, passed = ([gate[end] for gate in gates] for end in (0, 1))
    inputs = full([*INPUTS, *filter(None, robot_topics), *tracked_topics, *commands])
    sensed = full([*SENSED, *sensor_topics])
    results = full((*RESULTS, *SHARED_RESULTS))
    element = ElementTree.Element('policy', version=VERSION)
    enclaves = ElementTree.SubElement(element, 'enclaves')
    server_enclave = _enclave(enclaves, node)
    server = _beside(server_enclave, namespace, name)
    _allow(server, 'topics', 'publish', [*results, *full(passed), *LOGS])
    _allow(server, 'topics', 'subscribe', [*inputs, *CLOCK])
    _allow(server, 'services', 'reply', full(OFFERED))
    _allow(server, 'services', 'request', [GET_PLANNING_SCENE])
    sensing = f'{name}{SENSORS}'
    sensors = _beside(server_enclave, namespace, sensing)
    _allow(sensors, 'topics', 'publish', ['/parameter_events'])
    _allow(sensors, 'topics', 'subscribe', sensed)
    _allow(sensors, 'services', 'reply', [f'{root}{sensing}/get_type_description'])
    for client, publishes, asks in (
        ('observer', [], full(QUERIES)),
        ('mover', [*inputs, *sensed], []),
        ('operator', [*inputs, *sensed], full(OFFERED)),
    ):
        profile = _beside(_enclave(enclaves, f'{node}/{client}'), namespace, client)
        _allow(profile, 'topics', 'publish', [*publishes, *LOGS])
        _allow(profile, 'topics', 'subscribe', [*results, *CLOCK])
        _allow(profile, 'services', 'reply', OWN_SERVICES)
        _allow(profile, 'services', 'request', asks)
    ElementTree.indent(element)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(element, "unicode")}\n'


def _enclave(enclaves: ElementTree.Element, path: str) -> ElementTree.Element:
    """Add an enclave and return its profiles."""
    enclave = ElementTree.SubElement(enclaves, 'enclave', path=path)
    return ElementTree.SubElement(enclave, 'profiles')


def _beside(profiles: ElementTree.Element, namespace: str, node: str) -> ElementTree.Element:
    """Add the profile of a node to those of an enclave and return it."""
    return ElementTree.SubElement(profiles, 'profile', ns=namespace, node=node)


def _allow(profile: ElementTree.Element, kind: str, action: str, names: Iterable[str]) -> None:
    """Grant a profile access to topics or services, if there are any."""
    if names := sorted(names):
        listed = ElementTree.SubElement(profile, kind, {action: 'ALLOW'})
        for each in names:
            ElementTree.SubElement(listed, kind.removesuffix('s')).text = each


def main() -> int:
    """Print the policy of a node."""
    parser = argparse.ArgumentParser(prog='policy', description=__doc__.splitlines()[0])
    parser.add_argument('--namespace', default='/', help='of the node, such as /cell')
    parser.add_argument('--name', default='scene_graph', help='of the node')
    for default in ROBOT_TOPICS:
        parser.add_argument(
            f'--{default.replace("_", "-")}',
            default=default,
            metavar='TOPIC',
            help=f'value of the parameter {default}_topic; empty: none',
        )
    parser.add_argument(
        '--robot-topic',
        action='append',
        default=[],
        metavar='TOPIC',
        help='of a robot of the parameter robot_descriptions, or of its joints; repeat it for '
        'several',
    )
    parser.add_argument(
        '--sensor-topic',
        action='append',
        default=[],
        metavar='TOPIC',
        help='of an obstacle source of the scene file; repeat it for several, and for camera_info',
    )
    parser.add_argument(
        '--tracked-topic',
        action='append',
        default=[],
        metavar='TOPIC',
        help='value of the parameter tracked_markers or tracked_detections; repeat it for both',
    )
    parser.add_argument(
        '--gate',
        action='append',
        default=[],
        nargs=2,
        metavar=('IN', 'OUT'),
        help='topics of a gate; repeat it for several',
    )
    options = parser.parse_args()
    if not options.namespace.startswith('/'):
        parser.error(f'--namespace is {options.namespace!r}; it must begin with /')
    text = policy(
        options.namespace,
        options.name,
        robot_topics=(
            options.robot_description,
            options.robot_description_semantic,
            *options.robot_topic,
        ),
        sensor_topics=options.sensor_topic,
        tracked_topics=options.tracked_topic,
        gates=[tuple(gate) for gate in options.gate],
    )
    print(text, end='')
    return 0


if __name__ == '__main__':
    sys.exit(main())
