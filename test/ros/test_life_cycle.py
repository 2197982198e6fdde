"""The managed life cycle: what each transition keeps, over and over."""

import time

import pytest
from drake_geom_msgs import msg, srv
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from ros.harness import LATCHED, ROOT, start_node
from ros.scene_calls import accepted, poses
from sensor_msgs.msg import PointCloud2, PointField

pytestmark = pytest.mark.topics

SCENE = ROOT / 'scenes' / 'minimal.yaml'
LATE = 17  # [s] the stamp of what is asked where nothing is published


@pytest.fixture
def node(tmp_path):
    process = start_node(
        *(tmp_path / 'log',),
        anew=True,
        scene_file=SCENE,
        max_distance=1.0,
        autostart=False,
        rate=50.0,
    )
    yield process
    process.end()


def change(client, transition):
    request = Transition(id=transition)
    assert client.call(ChangeState, 'change_state', transition=request).success


def one_point():
    cloud = PointCloud2(height=1, width=1, point_step=12, row_step=12, data=bytes(12))
    cloud.fields = [
        PointField(name=axis, offset=4 * k, datatype=PointField.FLOAT32, count=1)
        for k, axis in enumerate('xyz')
    ]
    return cloud


def state(client):
    return client.call(GetState, 'get_state').current_state.id


def test_twice_through_the_life_of_a_node(client):
    results = client.listen(msg.SignedDistancePairs, 'signed_distances')
    assert state(client) == State.PRIMARY_STATE_UNCONFIGURED
    for _ in range(2):
        change(client, Transition.TRANSITION_CONFIGURE)
        publisher = client.publisher(msg.FramePoses, 'frame_poses')

        def posed(publisher=publisher):
            publisher.publish(poses(['ball'], [(0.25, 0, 1)]))
            pose = accepted(client.call(srv.GetPose, 'get_pose', frame='ball')).pose
            return pose.pose.position.x == 0.25

        # Inactive: poses are taken and questions answered, and nothing is published.
        client.wait_for(posed, 'the pose')
        results.clear()
        assert accepted(client.call(srv.HasCollisions, 'has_collisions'))
        assert results == []
        change(client, Transition.TRANSITION_ACTIVATE)
        client.wait_for(lambda: len(results) > 3, 'results')
        scenes = client.listen(msg.Scene, 'scene', LATCHED)
        client.wait_for(lambda scenes=scenes: scenes, 'the scene')
        answers = client.listen(msg.PointDistances, 'point_distances')
        cloud = one_point()
        points = client.publisher(PointCloud2, 'query_points')

        def answered(points=points, answers=answers, cloud=cloud):
            points.publish(cloud)
            return answers

        client.wait_for(answered, 'an answer to points')
        accepted(client.call(srv.RegisterSource, 'register_source', name='mine'))
        change(client, Transition.TRANSITION_DEACTIVATE)
        pose = accepted(client.call(srv.GetPose, 'get_pose', frame='ball')).pose
        assert pose.pose.position.x == 0.25
        cloud.header.stamp.sec = LATE  # what was under way may still come
        for _ in range(20):
            points.publish(cloud)
            client.spin_until(time.monotonic() + 0.05)
        assert not [a for a in answers if a.query_stamp.sec == LATE]
        change(client, Transition.TRANSITION_CLEANUP)
        assert state(client) == State.PRIMARY_STATE_UNCONFIGURED
        client.wait_for(
            lambda: client.node.count_publishers('/scene_graph/signed_distances') == 0,
            'the topics to close',
        )
    change(client, Transition.TRANSITION_UNCONFIGURED_SHUTDOWN)
    assert state(client) == State.PRIMARY_STATE_FINALIZED


@pytest.mark.parametrize(
    ('parameter', 'value'),
    [
        ('qos_overrides./scene_graph/frame_poses.subscription.reliability', 'sometimes'),
        ('robot_description_topic', 'sometimes-not'),
    ],
)
def test_what_cannot_be_opened_leaves_it_unconfigured(tmp_path, lone_client, parameter, value):
    bad = {parameter: value}
    node = start_node(tmp_path / 'bad', scene_file=SCENE, **bad)
    try:
        lone_client.wait_for(lambda: 'sometimes' in node.output(), 'the reason in the log')
        assert state(lone_client) == State.PRIMARY_STATE_UNCONFIGURED
    finally:
        assert node.end() == 0
