"""What arrives: each kind with the scene that it comes to, and how it is sent and taken back."""

from __future__ import annotations

import array
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from drake_geom_msgs import msg
from geometry_msgs.msg import TransformStamped
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_msgs.msg import Header, String
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from drake_geom_ros.client import RefusedError, SceneGraphClient

LINKS, GEOMETRIES, ROWS, TRIANGLES, FRAMES = 4000, 16_000, 100_000, 200_000, 3000
POINTS, CELLS, IMAGE = 1_000_000, 2_000_000, (1280, 960)
AGAIN = 20.0  # [s] after which a message of a sensor, which may be lost, is sent once more
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
HAND = """
frames:
- {name: hand, source: mover}
geometries:
- {name: ball, source: mover, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: post, shape: {type: box, size: [0.2, 0.2, 1]}, pose: {position: [0.22, 0, 0]}}
"""
RULE = """
proximity_rules:
- {name: near, set_a: mover, level: stop, enter: 0.05, leave: 0.1}
"""
BALL = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.05])
PROXIMITY = msg.Role(role=1)

Act = Callable[[], object]


@dataclass(frozen=True)
class Kind:
    """Something that arrives, in a scene, with the node's parameters.

    ``ways(client)`` returns how it is sent, until it has come into effect, and how it is taken
    back for the next turn.
    """

    name: str
    ways: Callable[[SceneGraphClient], tuple[Act, Act]]
    scene: Callable[[], str] = lambda: scene_of()
    parameters: dict[str, object] = field(default_factory=dict)


def scene_of(*, bodies: int = 0, frames: int = 0, robot: int = 0, rules: str = '') -> str:
    """Return a scene of the hand, bodies that are anchored, frames with a body, and a robot."""
    sources = 'sources: [mover, much]\n'
    lines = [HAND.replace('geometries:', _frames(frames) + 'geometries:')]
    for k in range(bodies):
        place = [3.0 + k % 100, k // 100, 0.0]
        lines.append(
            f'- {{name: b{k}, source: much, shape: {{type: sphere, radius: 0.05}}, '
            f'pose: {{position: {place}}}}}'
        )
    for k in range(frames):
        lines.append(
            f'- {{name: g, source: much, frame: f{k}, shape: {{type: sphere, radius: 0.05}}}}'
        )
    return sources + '\n'.join(lines) + '\n' + rules


def _frames(count: int) -> str:
    return ''.join(f'- {{name: f{k}, source: much}}\n' for k in range(count))


def urdf(links: int, radius: float = 0.05) -> str:
    """Return a robot of links that each have a ball, four on each."""
    ball = f'<collision><geometry><sphere radius="{radius}"/></geometry></collision>'
    lines = ['<robot name="much_robot">']
    lines += [f'<link name="l{k}">{ball}</link>' for k in range(links)]
    for k in range(1, links):
        lines.append(
            f'<joint name="j{k}" type="revolute"><parent link="l{(k - 1) // 4}"/>'
            f'<child link="l{k}"/><origin xyz="0.2 0 {0.1 * (k % 4)}"/><axis xyz="0 0 1"/>'
            '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        )
    return '\n'.join([*lines, '</robot>'])


def _nothing() -> None:
    """There is nothing to take back."""


def _robot(client: SceneGraphClient) -> tuple[Act, Act]:
    publisher = client.node.create_publisher(String, '/robot_description', LATCHED)
    message = String(data=urdf(LINKS))

    def send() -> None:
        publisher.publish(message)
        client.wait_for(lambda: _is_there(client, 'much_robot'), 'the robot')

    return send, lambda: client.call('remove_source', source='much_robot')


def _is_there(client: SceneGraphClient, source: str) -> bool:
    table = client.listener.table
    return table is not None and any(g.source == source for g in table.geometries.values())


def _remove_robot(client: SceneGraphClient) -> tuple[Act, Act]:
    send, take_back = _robot(client)
    send()
    return take_back, send


def _served(name: str, undo: Act = _nothing, **fields: Any) -> Callable[..., tuple[Act, Act]]:
    return lambda client: (lambda: client.call(name, **fields), undo)


def _load(client: SceneGraphClient) -> tuple[Act, Act]:
    text = scene_of(bodies=GEOMETRIES).replace('mover', 'loaded').replace('much', 'loaded_too')
    text = text.replace('- {name: post', '- {name: other_post, source: loaded')

    def undo() -> None:
        for source in ('loaded', 'loaded_too'):
            client.call('remove_source', source=source)

    return lambda: client.call('load_scene', text=text), undo


def _geometry(k: int, shape: msg.Shape = BALL) -> msg.NewGeometry:
    geometry = msg.NewGeometry(frame='world', name=f'new{k}', shape=shape, roles=[PROXIMITY])
    geometry.pose.position.x, geometry.pose.position.y = 3.0 + k % 100, -1.0 - k // 100
    return geometry


def _register(geometries: Sequence[msg.NewGeometry]) -> Callable[..., tuple[Act, Act]]:
    def ways(client: SceneGraphClient) -> tuple[Act, Act]:
        client.call('register_source', name='new')

        def undo() -> None:
            client.call('remove_source', source='new')
            client.call('register_source', name='new')

        fields = {'source': 'new', 'geometries': geometries}
        return lambda: client.call('register_geometries', **fields), undo

    return ways


def _one_geometry(client: SceneGraphClient) -> tuple[Act, Act]:
    client.call('register_source', name='new')
    ball = _geometry(0)
    told = {name: getattr(ball, name) for name in ('frame', 'name', 'pose', 'shape', 'roles')}
    return (
        lambda: client.call('register_geometry', source='new', **told),
        lambda: client.call('remove_geometry', geometry='new::world/new0'),
    )


def _mesh() -> msg.Shape:
    """Return a sheet of hills."""
    side = int(np.sqrt(TRIANGLES / 2))
    x, y = np.meshgrid(*(np.linspace(0.0, 1.0, side + 1),) * 2, indexing='ij')
    vertices = np.stack((x, y, 0.05 * np.sin(9 * x) * np.cos(7 * y)), axis=-1)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    one = np.stack((corner, corner + side + 1, corner + 1), axis=1)
    other = np.stack((corner + 1, corner + side + 1, corner + side + 2), axis=1)
    triangles = np.concatenate((one, other)).ravel().astype(np.uint32)
    return msg.Shape(
        type=msg.Shape.MESH,
        vertices=array.array('d', vertices.tobytes()),
        triangles=array.array('I', triangles.tobytes()),
    )


def _states(client: SceneGraphClient) -> tuple[Act, Act]:
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, (ROWS, 2))
    told = array.array('d', rows.tobytes())
    fields = {'joint_names': ['j1', 'j2'], 'positions': told, 'want': 'collision'}
    return lambda: client.call('evaluate_states', **fields), _nothing


def _motion(client: SceneGraphClient) -> tuple[Act, Act]:
    rows = np.linspace([0.0, 0.0], [1.0, 1.0], ROWS).tolist()
    points = [JointTrajectoryPoint(positions=row) for row in rows]
    path = JointTrajectory(joint_names=['j1', 'j2'], points=points)
    return lambda: client.call('check_motion', path=path), _nothing


def _rule(client: SceneGraphClient) -> tuple[Act, Act]:
    rule = msg.ProximityRule(
        name='many', set_a=['much'], set_b=['mover'], level=3, enter=0.05, leave=0.1
    )
    return (
        lambda: client.call('add_proximity_rule', rule=rule),
        lambda: client.call('remove_proximity_rule', name='many'),
    )


def _filters(client: SceneGraphClient) -> tuple[Act, Act]:
    names = list(client.scene().geometries)
    operation = msg.CollisionFilterStatement.EXCLUDE_WITHIN
    everything = msg.GeometrySet(geometry_ids=names)
    statement = msg.CollisionFilterStatement(operation=operation, set_a=everything)
    declaration = msg.CollisionFilterDeclaration(statements=[statement])
    last: list[int] = []

    def send() -> None:
        last.append(client.call('apply_transient_filter', declaration=declaration).filter_id)

    return send, lambda: client.call('remove_filter', filter_id=last[-1])


def _sensed(name: str, topic: str) -> dict[str, object]:
    """Return parameters for an obstacle input whose large messages come whole.

    Best effort, the default, loses a message of megabytes where the system's buffers are small.
    """
    reliability = f'qos_overrides./scene_graph/obstacles/{topic}.subscription.reliability'
    return {'obstacles': f'[{name}]', reliability: 'reliable'}


def _until(client: SceneGraphClient, name: str, count: int) -> Callable[[], bool]:
    """Return a fact: a map has so many cells or more, as reports of cycles say."""
    reports: list[msg.CycleReport] = []
    client.node.create_subscription(
        msg.CycleReport, '/scene_graph/cycle_report', lambda r: reports.append(r), 10
    )

    def fact() -> bool:
        told = dict(zip(reports[-1].maps, reports[-1].map_cells, strict=True)) if reports else {}
        return told.get(name, 0) >= count

    return fact


def _sent(
    client: SceneGraphClient, messages: Iterable[tuple[Any, str]], name: str, count: int
) -> tuple[Act, Act]:
    node = client.node
    publishers = [
        (node.create_publisher(type(message), f'/scene_graph/{topic}', SENSOR), message)
        for message, topic in messages
    ]
    fact = _until(client, name, count)

    def send() -> None:
        sent = -math.inf

        def has_come() -> bool:
            nonlocal sent
            if time.monotonic() - sent > AGAIN:
                sent = time.monotonic()
                stamp = node.get_clock().now().to_msg()
                for publisher, message in publishers:
                    message.header.stamp = stamp
                    publisher.publish(message)
            return fact()

        client.wait_for(has_come, f'the map {name}')

    def undo() -> None:
        client.call('clear_obstacles', map=name)

    return send, undo


def _octomap(client: SceneGraphClient) -> tuple[Act, Act]:
    from octomap_msgs.msg import Octomap

    from drake_geom_ros.sensed_maps.cells import Cells
    from drake_geom_ros.sensed_maps.octree import binary_of_cells

    side = round(CELLS ** (1 / 3)) + 1
    keys = np.stack(np.unravel_index(np.arange(CELLS), (side,) * 3), axis=1).astype(np.int64)
    keys = 2 * keys + [60, -side, -side]  # apart, so that none can be merged
    tree = binary_of_cells(Cells.of_keys(keys, 0.05)).data
    message = Octomap(
        header=Header(frame_id='world'), binary=True, id='OcTree', resolution=0.05,
        data=array.array('b', tree),
    )  # fmt: skip
    return _sent(client, [(message, 'obstacles/octomap')], 'octomap', CELLS)


def _cloud(client: SceneGraphClient) -> tuple[Act, Act]:
    rows = np.random.default_rng(0).uniform([2, -2, -1], [2.9, 2, 1], (POINTS, 3)).astype('<f4')
    fields = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in enumerate('xyz')]
    message = PointCloud2(
        header=Header(frame_id='world'), width=POINTS, height=1, point_step=12,
        row_step=12 * POINTS, fields=fields, data=array.array('B', rows.tobytes()),
    )  # fmt: skip
    return _sent(client, [(message, 'obstacles/points')], 'points', 1000)


def _depth(client: SceneGraphClient) -> tuple[Act, Act]:
    width, height = IMAGE
    depths = np.random.default_rng(0).uniform(1.0, 2.5, (height, width)).astype('<f4')
    image = Image(
        header=Header(frame_id='world'), width=width, height=height, encoding='32FC1',
        step=4 * width, data=array.array('B', depths.tobytes()),
    )  # fmt: skip
    info = CameraInfo(header=Header(frame_id='world'), width=width, height=height)
    info.k = [900.0, 0.0, width / 2, 0.0, 900.0, height / 2, 0.0, 0.0, 1.0]
    info.p = [900.0, 0.0, width / 2, 0.0, 0.0, 900.0, height / 2, 0.0, 0.0, 0.0, 1.0, 0.0]
    messages = (info, 'obstacles/depth/camera_info'), (image, 'obstacles/depth/image_rect_raw')
    return _sent(client, messages, 'depth', 1000)


def _transforms(client: SceneGraphClient) -> tuple[Act, Act]:
    publisher = client.node.create_publisher(TFMessage, '/tf', 10)
    each = [TransformStamped(child_frame_id=f'f{k}') for k in range(FRAMES)]
    height = 0.0

    def send() -> None:
        nonlocal height
        height += 1.0
        stamp = client.node.get_clock().now().to_msg()
        for k, transform in enumerate(each):
            transform.header.frame_id, transform.header.stamp = 'world', stamp
            place = transform.transform.translation
            place.x, place.y, place.z = 5.0 + k % 100, float(k // 100), height
        publisher.publish(TFMessage(transforms=each))
        client.wait_for(has_come, 'the last frame')

    def has_come() -> bool:
        try:
            pose = client.call('get_pose', frame=f'much::f{FRAMES - 1}').pose
        except RefusedError:  # it never had one
            return False
        return bool(pose.pose.position.z == height)

    return send, _nothing


def _parameter(name: str, *values: ParameterValue) -> Callable[..., tuple[Act, Act]]:
    def ways(client: SceneGraphClient) -> tuple[Act, Act]:
        service = client.node.create_client(SetParameters, '/scene_graph/set_parameters')
        client.wait_for(service.service_is_ready, 'set_parameters')

        def become(value: ParameterValue) -> None:
            request = SetParameters.Request(parameters=[Parameter(name=name, value=value)])
            future = service.call_async(request)
            client.wait_for(future.done, f'the answer for {name}')

        return lambda: become(values[0]), lambda: become(values[1])

    return ways


def _text(value: str) -> ParameterValue:
    return ParameterValue(type=4, string_value=value)


def _number(value: float) -> ParameterValue:
    return ParameterValue(type=3, double_value=value)


def _many() -> str:
    return scene_of(bodies=GEOMETRIES)


def _many_with_rule() -> str:
    return scene_of(bodies=GEOMETRIES, rules=RULE)


def _arm() -> str:
    robot = (
        '{name: arm, urdf: arm.urdf, pose: {position: [5, 0, 0]}, configuration: {j1: 0, j2: 0}}'
    )
    return scene_of().replace('sources: [', 'sources: [arm, ') + f'robots:\n- {robot}\n'


KINDS = (
    Kind('nothing', lambda client: (_nothing, _nothing)),
    Kind('robot_description', _robot),
    Kind('robot_description beside a rule', _robot, lambda: scene_of(rules=RULE)),
    Kind('robot_description, padded', _robot, parameters={'paddings': "['*=0.01']"}),
    Kind('removal of the robot', _remove_robot, lambda: scene_of(rules=RULE)),
    Kind('load_scene', _load, lambda: scene_of(rules=RULE)),
    Kind('evaluate_states', _states, _arm),
    Kind('check_motion', _motion, _arm),
    Kind('OctoMap', _octomap, parameters=_sensed('octomap', 'octomap')),
    Kind('PointCloud2', _cloud, parameters=_sensed('points', 'points')),
    Kind('depth image', _depth, parameters=_sensed('depth', 'depth/image_rect_raw')),
    Kind('register_geometry', _one_geometry, _many),
    Kind('register_geometry beside a rule', _one_geometry, _many_with_rule),
    Kind('register_geometries', _register([_geometry(k) for k in range(GEOMETRIES)])),
    Kind('mesh', _register([_geometry(0, _mesh())])),
    Kind('apply_transient_filter', _filters, _many),
    Kind('add_proximity_rule', _rule, lambda: scene_of(bodies=LINKS)),
    Kind('save_scene', _served('save_scene'), _many),
    Kind('get_filters', _served('get_filters'), _many),
    Kind('get_pose_ages', _served('get_pose_ages'), lambda: scene_of(frames=FRAMES)),
    Kind('cross_check', _parameter('cross_check', _number(10.0), _number(0.0)), _many),
    Kind('accuracy', _parameter('accuracy', _text('fast'), _text('exact')), _many_with_rule),
    Kind('/tf', _transforms, lambda: scene_of(frames=FRAMES), {'use_tf': 'true'}),
)


def write(kind: Kind, folder: Path) -> Path:
    """Write the scene of a kind into a folder, and return its path."""
    (folder / 'arm.urdf').write_text(urdf(3))
    path = folder / 'scene.yaml'
    path.write_text(kind.scene())
    return path
