"""The node offers what the contract of the ROS surface lists: names, types, parameters."""

import pytest
from conventions.interface import SERVICES
from rcl_interfaces.srv import DescribeParameters, GetParameters

pytestmark = pytest.mark.topics

PREFIX = '/scene_graph'
TOPICS_OUT = {
    f'{PREFIX}/penetrations': 'drake_geom_msgs/msg/PenetrationPairs',
    f'{PREFIX}/signed_distances': 'drake_geom_msgs/msg/SignedDistancePairs',
    f'{PREFIX}/point_distances': 'drake_geom_msgs/msg/PointDistances',
    f'{PREFIX}/cycle_report': 'drake_geom_msgs/msg/CycleReport',
    f'{PREFIX}/scene': 'drake_geom_msgs/msg/Scene',
    f'{PREFIX}/geometry_poses': 'drake_geom_msgs/msg/GeometryPoses',
    f'{PREFIX}/markers': 'visualization_msgs/msg/MarkerArray',
    '/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray',
}
TOPICS_IN = {
    f'{PREFIX}/frame_poses': 'drake_geom_msgs/msg/FramePoses',
    f'{PREFIX}/query_points': 'sensor_msgs/msg/PointCloud2',
    '/robot_description': 'std_msgs/msg/String',
}
# Default and whether it may change while the node runs.
PARAMETERS = {
    'scene_file': ('', False),
    'world_frame': ('world', False),
    'rate': (0.0, True),
    'max_distance': (0.1, True),
    'accuracy': ('exact', True),
    'stale_after': (1.0, True),
    'use_tf': (False, False),
    'use_planning_scene': (False, False),
    'publish_markers': (False, True),
    'autostart': (True, False),
    'robot_description_topic': ('robot_description', False),
    'robot_descriptions': ('', False),
    'point_threshold': (0.1, True),
    'marker_rate': (10.0, False),
    'mesh_roots': (['package://', '.'], True),
    'allow_writes': (True, False),
    'time_budget': (0.0, True),
    'replay_dir': ('', True),
    'replay_limit': (20, True),
    'lcm_url': ('', False),
    'contact_polygons': (False, True),
    'service_depth': (1000, False),
    'max_answer_size': (64.0, True),
    'watchdog': (60.0, False),
    'watchdog_exits': (False, False),
}
FIELDS = {
    1: 'bool_value',
    2: 'integer_value',
    3: 'double_value',
    4: 'string_value',
    9: 'string_array_value',
}


@pytest.fixture(scope='module')
def node_settings():
    """Have a node with nothing set."""
    return {}


def offered(client, kind):
    """Return {name: types} of what the node offers; nothing before it is known."""
    if 'scene_graph' not in client.node.get_node_names():
        return {}
    return dict(getattr(client.node, f'get_{kind}_names_and_types_by_node')('scene_graph', '/'))


def wait_for(client, kind, expected):
    def missing():
        found = offered(client, kind)
        return {name: kind for name, kind in expected.items() if found.get(name) != [kind]}

    client.wait_for(lambda: not missing(), f'all of {sorted(expected)}')


def snake(name):
    return ''.join(f'_{c.lower()}' if c.isupper() else c for c in name).lstrip('_')


def test_every_service_is_there(client):
    expected = {f'{PREFIX}/{snake(name)}': f'drake_geom_msgs/srv/{name}' for name in SERVICES}
    expected[f'{PREFIX}/flatten_filters'] = 'std_srvs/srv/Trigger'
    assert len(expected) == 28
    wait_for(client, 'service', expected)


@pytest.mark.parametrize(
    ('direction', 'topics'), [('publisher', TOPICS_OUT), ('subscriber', TOPICS_IN)]
)
def test_every_topic_is_there(client, direction, topics):
    wait_for(client, direction, topics)


def test_every_parameter_is_there_with_its_default(client):
    names = sorted(PARAMETERS)
    values = client.call(GetParameters, 'get_parameters', names=names).values
    found = {n: getattr(v, FIELDS[v.type]) for n, v in zip(names, values, strict=True)}
    assert found == {name: default for name, (default, _) in PARAMETERS.items()}
    described = client.call(DescribeParameters, 'describe_parameters', names=names).descriptors
    assert {d.name: not d.read_only for d in described} == {
        name: changes for name, (_, changes) in PARAMETERS.items()
    }
