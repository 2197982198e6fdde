"""Markers, points, diagnostics, QoS and namespaces on the real middleware."""

import array

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros.harness import LATCHED, ROOT, Client, start_node
from ros.scene_calls import accepted, add_sphere, poses
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

from drake_geom_ros.live.services import saved_file

pytestmark = pytest.mark.topics

SCENE = ROOT / 'scenes' / 'minimal.yaml'
URDF = """<robot name="arm">
  <link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    """Return a node named otherwise, in a namespace, with QoS overrides."""
    overrides = {
        'qos_overrides./cell/geometry/signed_distances.publisher.depth': 3,
        'qos_overrides./cell/geometry/frame_poses.subscription.reliability': 'reliable',
    }
    process = start_node(
        tmp_path_factory.mktemp('outputs') / 'log',
        namespace='/cell',
        name='geometry',
        scene_file=SCENE,
        world_frame='map',
        max_distance=1.0,
        publish_markers=True,
        marker_rate=20.0,
        stale_after=0.5,
        robot_description_topic='description',
        **overrides,
    )
    yield process
    process.end()


@pytest.fixture(scope='module')
def server():
    return '/cell/geometry'


def set_parameter(client, name, **value):
    kind = {bool: 1, int: 2, float: 3, str: 4, list: 9}[type(next(iter(value.values())))]
    parameter = Parameter(name=name, value=ParameterValue(type=kind, **value))
    answer = client.call(SetParameters, 'set_parameters', parameters=[parameter])
    return answer.results[0]


def move_ball(client, x):
    publisher = client.publisher(msg.FramePoses, 'frame_poses', QoSProfile(depth=10))
    message = poses(['ball'], [(x, 0, 1)], stamp=1)
    message.header.frame_id = 'map'

    def there():
        publisher.publish(message)
        pose = accepted(client.call(srv.GetPose, 'get_pose', frame='ball')).pose
        return pose.pose.position.x == x and pose.header

    return client.wait_for(there, 'the ball to move')


def test_everything_is_said_in_the_world_frame_of_the_parameter(client):
    results = client.listen(msg.SignedDistancePairs, 'signed_distances')
    scenes = client.listen(msg.Scene, 'scene', LATCHED)
    header = move_ball(client, 0.125)
    assert (header.frame_id, header.stamp.sec) == ('map', 1)
    publisher = client.publisher(msg.FramePoses, 'frame_poses', QoSProfile(depth=10))

    def answered():
        # The node may have found this listener only after the pose had come.
        publisher.publish(poses(['ball'], [(0.125, 0, 1)], stamp=1))
        return results

    result = client.wait_for(answered, 'results')[0]
    assert result.header.frame_id == 'map'
    assert client.wait_for(lambda: scenes, 'the scene')[0].header.frame_id == 'map'
    answer = client.call(srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise')
    assert accepted(answer).result.header.frame_id == 'map'


def test_poses_in_another_frame_are_refused(client):
    move_ball(client, 0.25)
    diagnostics = client.listen(DiagnosticArray, '/diagnostics')
    publisher = client.publisher(msg.FramePoses, 'frame_poses', QoSProfile(depth=10))
    message = poses(['ball'], [(9, 9, 9)])
    message.header.frame_id = 'camera'

    def refused():
        publisher.publish(message)
        return any("'camera'" in v.key for d in diagnostics for v in d.status[0].values)

    client.wait_for(refused, 'the refusal on /diagnostics')
    pose = accepted(client.call(srv.GetPose, 'get_pose', frame='ball')).pose
    assert pose.pose.position.x == 0.25


def test_diagnostics_say_how_the_node_is(client):
    diagnostics = client.listen(DiagnosticArray, '/diagnostics')
    move_ball(client, 0.5)

    def values(warn):
        for message in diagnostics:
            status = message.status[0]
            if (status.level != b'\x00') == warn:
                found = {v.key: v.value for v in status.values}
                if (found['delay p50 [ms]'] == 'none') == warn:
                    return found
        return None

    publisher = client.publisher(msg.FramePoses, 'frame_poses', QoSProfile(depth=10))

    def fresh():
        publisher.publish(poses(['ball'], [(0.5, 0, 1)]))
        return values(warn=False)

    found = client.wait_for(fresh, 'a good status')
    assert float(found['delay p50 [ms]']) <= float(found['delay worst [ms]'])
    assert float(found['worst error bound [m]']) < 1e-9
    assert float(found['memory [MB]']) > 10
    diagnostics.clear()
    stale = client.wait_for(lambda: values(warn=True), 'a stale frame')
    assert 'ball' in stale['names of stale frames']
    assert 'ball' in diagnostics[-1].status[0].message


def test_markers_come_go_and_are_remembered_for_late_comers(client):
    seen = client.listen(MarkerArray, 'markers')
    move_ball(client, 0.5)

    def shown():
        markers = {}
        for message in seen:
            for marker in message.markers:
                if marker.action == Marker.DELETEALL:
                    markers.clear()
                elif marker.action == Marker.DELETE:
                    markers.pop((marker.ns, marker.id), None)
                else:
                    markers[marker.ns, marker.id] = marker
        return [m for m in markers.values() if m.ns == 'proximity']

    client.wait_for(lambda: len(shown()) == 3, 'floor, post and ball')
    assert {m.header.frame_id for m in shown()} == {'map'}
    client.wait_for(lambda: any(m.pose.position.x == 0.5 for m in shown()), 'the ball where it is')
    late = Client('/cell/geometry')
    try:
        arrived = late.listen(MarkerArray, 'markers')
        late.wait_for(
            lambda: any(m.ns == 'proximity' for a in arrived for m in a.markers), 'all of it'
        )
    finally:
        late.close()
    assert set_parameter(client, 'publish_markers', bool_value=False).successful
    client.wait_for(lambda: not shown(), 'the markers to vanish')
    assert set_parameter(client, 'publish_markers', bool_value=True).successful
    client.wait_for(lambda: len(shown()) == 3, 'the markers again')


def test_points_are_answered(client):
    move_ball(client, 0.5)
    answers = client.listen(msg.PointDistances, 'point_distances')
    publisher = client.publisher(PointCloud2, 'query_points')
    points = np.array([[0.5, 0, 1.25], [np.nan, 0, 0], [0.5, 0, 0.5]], dtype=np.float32)
    cloud = PointCloud2(
        height=1, width=3, point_step=12, row_step=36, data=array.array('B', points.tobytes())
    )
    cloud.fields = [
        PointField(name=axis, offset=4 * k, datatype=PointField.FLOAT32, count=1)
        for k, axis in enumerate('xyz')
    ]
    cloud.header.stamp.sec, cloud.header.stamp.nanosec = 17, 4
    assert set_parameter(client, 'point_threshold', double_value=0.2).successful

    def answered():
        publisher.publish(cloud)
        return [a for a in answers if a.threshold == 0.2]

    answer = client.wait_for(answered, 'an answer')[-1]
    assert list(answer.point_index) == [0]
    assert answer.query_stamp == cloud.header.stamp
    assert answer.distance[0] == pytest.approx(0.15, abs=1e-7)
    assert list(answer.grad_w) == pytest.approx([0, 0, 1], abs=1e-7)


def test_a_robot_description_becomes_a_source_and_another_takes_its_place(client):
    scenes = client.listen(msg.Scene, 'scene', LATCHED)
    publisher = client.node.create_publisher(String, '/cell/description', LATCHED)

    def robots():
        sources = [s.name for s in scenes[-1].sources] if scenes else []
        return sorted(set(sources) & {'arm', 'leg'})

    publisher.publish(String(data=URDF))
    client.wait_for(lambda: robots() == ['arm'], 'the robot')
    pair = {'geometry_a': 'base/collision_0', 'geometry_b': 'hand/collision_0'}
    answer = accepted(client.call(srv.ExplainFilter, 'explain_filter', **pair))
    assert answer.filtered
    publisher.publish(String(data=URDF.replace('"arm"', '"leg"')))
    client.wait_for(lambda: robots() == ['leg'], 'the other robot')
    version = scenes[-1].scene_version
    publisher.publish(String(data='<robot'))
    diagnostics = client.listen(DiagnosticArray, '/diagnostics')
    client.wait_for(
        lambda: any(
            v.key == 'refused from description' for d in diagnostics for v in d.status[0].values
        ),
        'the refusal',
    )
    assert scenes[-1].scene_version == version


def test_qos_is_as_the_contract_says_unless_overridden(client):
    move_ball(client, 0.5)

    def profile(topic, of):
        (info,) = getattr(client.node, f'get_{of}_info_by_topic')(f'/cell/geometry/{topic}')
        return info.qos_profile

    assert profile('frame_poses', 'subscriptions').reliability == ReliabilityPolicy.RELIABLE
    assert profile('query_points', 'subscriptions').reliability == ReliabilityPolicy.BEST_EFFORT
    for topic in ('signed_distances', 'penetrations', 'cycle_report', 'point_distances'):
        assert profile(topic, 'publishers').reliability == ReliabilityPolicy.RELIABLE
        assert profile(topic, 'publishers').durability == DurabilityPolicy.VOLATILE
    assert profile('scene', 'publishers').durability == DurabilityPolicy.TRANSIENT_LOCAL
    depths = {
        'signed_distances.publisher': 3,
        'penetrations.publisher': 10,
        'frame_poses.subscription': 5,
        'query_points.subscription': 5,
        'scene.publisher': 1,
    }
    names = [f'qos_overrides./cell/geometry/{topic}.depth' for topic in depths]
    answer = client.call(GetParameters, 'get_parameters', names=names)
    assert [value.integer_value for value in answer.values] == list(depths.values())


def accepted_names(client):
    return client.call(ListParameters, 'list_parameters').result.names


def test_every_parameter_tells_what_it_is(client):
    names = [n for n in accepted_names(client) if '.' not in n and n != 'use_sim_time']
    expected = {
        *('scene_file', 'world_frame', 'rate', 'max_distance', 'accuracy', 'stale_after'),
        *('use_tf', 'publish_markers', 'autostart', 'point_threshold', 'marker_rate'),
        *('robot_description_topic', 'mesh_roots', 'time_budget', 'replay_dir', 'replay_limit'),
    }
    assert expected <= set(names)
    described = client.call(DescribeParameters, 'describe_parameters', names=sorted(expected))
    for descriptor in described.descriptors:
        assert len(descriptor.description) > 20
        changes = 'May change while the node runs' in descriptor.description
        assert changes != descriptor.read_only
        if descriptor.type == ParameterType.PARAMETER_DOUBLE:
            assert descriptor.floating_point_range
        if descriptor.type == ParameterType.PARAMETER_INTEGER:
            assert descriptor.integer_range


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('world_frame', {'string_value': 'odom'}),
        ('use_tf', {'bool_value': True}),
        ('rate', {'double_value': -1.0}),
        ('rate', {'string_value': 'fast'}),
        ('marker_rate', {'double_value': 5.0}),
        ('point_threshold', {'double_value': float('nan')}),
        ('accuracy', {'string_value': 'superb'}),
        ('time_budget', {'double_value': -0.1}),
        ('time_budget', {'double_value': float('nan')}),
        ('replay_limit', {'integer_value': -1}),
    ],
)
def test_a_parameter_that_cannot_be_is_refused(client, name, value):
    result = set_parameter(client, name, **value)
    assert not result.successful
    assert result.reason


def test_mesh_roots_bound_what_services_open(client, tmp_path):
    scene = tmp_path / 'other.yaml'
    scene.write_text('sources: [files]\nframes:\n- {name: from_file, source: files}')
    assert not client.call(srv.LoadScene, 'load_scene', path=str(scene)).success
    refusal = client.call(srv.SaveScene, 'save_scene', path=str(tmp_path / 'saved.yaml'))
    assert 'mesh_roots' in refusal.message
    assert set_parameter(client, 'mesh_roots', string_array_value=[str(tmp_path)]).successful
    accepted(client.call(srv.LoadScene, 'load_scene', path=str(scene)))
    saved = accepted(client.call(srv.SaveScene, 'save_scene', path=str(tmp_path / 'saved.yaml')))
    assert (tmp_path / 'saved.yaml').read_text() == saved_file.MARK + saved.text


def test_the_rate_can_be_changed(client):
    reports = client.listen(msg.CycleReport, 'cycle_report')
    assert set_parameter(client, 'rate', double_value=50.0).successful
    client.wait_for(lambda: len(reports) > 10, 'cycles without poses')
    effects = dict(zip(reports[-1].effects, reports[-1].effect_reasons, strict=True))
    assert 'no pose message' in effects['poses']
    assert set_parameter(client, 'rate', double_value=0.0).successful


def test_two_nodes_live_in_one_graph(node, client, tmp_path):
    other = start_node(tmp_path / 'log', namespace='/other', max_distance=0.5)
    second = Client('/other/scene_graph')
    try:
        accepted(second.call(srv.RegisterSource, 'register_source', name='mine'))
        add_sphere(second, 'mine', 'f', 0.1)
        scenes = [c.listen(msg.Scene, 'scene', LATCHED) for c in (client, second)]

        def sources(k):
            return {source.name for source in scenes[k][-1].sources} if scenes[k] else set()

        second.wait_for(lambda: 'mine' in sources(1), 'the scene with the source')
        client.wait_for(lambda: scenes[0], 'a scene')
        assert 'mine' not in sources(0)
        assert move_ball(client, 0.75).frame_id == 'map'
    finally:
        second.close()
        assert other.end() == 0
