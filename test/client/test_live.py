"""The client against a real node."""

import math
import threading
import time

import pytest
from drake_geom_msgs import msg
from ros.harness import PATIENCE
from ros.scene_calls import exclude

from drake_geom_ros.client import (
    HeldFilter,
    NoAnswerError,
    RefusedError,
    SceneGraphClient,
)
from drake_geom_ros.math import RigidTransform

pytestmark = pytest.mark.topics

LEASE = 2.0  # [s] much longer than a busy machine needs to renew it
SCENE = """
sources: [left, right]
frames:
- {name: hand, source: left, pose: {position: [0, 0, 1]}}
- {name: hand, source: right, pose: {position: [0, 1, 1]}}
geometries:
- {name: floor, source: left, shape: {type: half_space}}
- {name: ball, source: left, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: right, frame: hand, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture(scope='module')
def client(node):
    with SceneGraphClient(patience=PATIENCE) as client:
        client.call('load_scene', text=SCENE, replace=True)
        yield client


def test_distances_have_names_of_both_sources(client):
    found = client.signed_distances()
    (pair,) = found.between('left::hand', 'right')
    assert (pair.source_a, pair.name_a, pair.source_b) == ('left', 'hand/ball', 'right')
    assert pair.distance == pytest.approx(0.8, abs=pair.error_bound)
    assert len(found) == 3
    assert client.signed_distances(0.85).between('world/floor').distance.tolist() == []


def test_what_if_poses_leave_the_live_scene_alone(client):
    poses = {'right::hand': RigidTransform([0, 0.15, 1]), 'left::hand': [0, 0, 1, 0, 0, 0, 1]}
    pair = client.signed_distance('left::hand/ball', 'right::hand/ball', poses)
    assert pair.distance == pytest.approx(-0.05)
    assert client.has_collisions(poses)
    assert not client.has_collisions()
    (overlap,) = client.penetrations(poses)
    assert overlap.depth == pytest.approx(0.05)
    assert (overlap.source_a, overlap.source_b) == ('left', 'right')
    assert len(client.signed_distances(0.0, poses)) == 1  # those that touch or overlap


def test_points_have_the_names_of_what_they_are_near(client):
    found = client.point_distances([[0, 0, 0.5], [0, 0, 2]], threshold=0.45)
    (point,) = found.to('left::hand')
    assert (point.point_index, point.name) == (0, 'hand/ball')
    assert point.distance == pytest.approx(0.4)


def test_a_refusal_is_raised_with_the_reason(client):
    with pytest.raises(RefusedError, match=r"explain_filter: .*'hand/bal'"):
        client.explain_filter('hand/bal', 'world/floor')
    assert client.explain_filter('left::hand/ball', 'world/floor') == []


def test_a_scene_that_has_changed_is_known_by_the_next_answer(client):
    before = client.scene().version
    request = {'name': 'post', 'source': 'left', 'frame': 'world'}
    shape = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.1])
    client.call('register_geometry', **request, shape=shape, roles=[msg.Role(role=1)])
    assert len(client.signed_distances().between('left::post')) == 2
    assert client.scene().version > before
    client.call('remove_geometry', geometry='world/post')
    assert len(client.signed_distances()) == 3


def test_results_of_the_stream_come_with_the_names_of_their_scene(client):
    taken = []
    client.listener.on_signed_distances(taken.append)
    client.wait_for(lambda: client.node.count_publishers('/scene_graph/signed_distances'), 'topic')

    def moved():
        client.publish_poses({'hand': [0, 0, 0.3, 0, 0, 0, 1]}, source='left')
        return taken

    client.wait_for(moved, 'a result')
    closest = taken[-1].closest()
    assert {closest.name_a, closest.name_b} == {'world/floor', 'hand/ball'}
    assert closest.distance == pytest.approx(0.2)


def test_a_filter_is_held_beyond_its_lease_until_it_is_let_go(client):
    lost = threading.Event()
    declaration = exclude('left::hand/ball', 'right::hand/ball')
    held = HeldFilter(client.node, client.services, declaration, lost.set, lease=LEASE)
    executor = client.node.executor
    client.wait_for(executor.create_task(held.hold()).done, 'the filter')
    asked, end = [], time.monotonic() + 3.0 * LEASE

    def renewed_often():
        asked.append(client.call('get_filters').active_filter_ids)
        return time.monotonic() > end

    client.wait_for(renewed_often, 'some leases')
    assert all(list(ids) == [held.filter_id] for ids in asked)
    client.wait_for(executor.create_task(held.let_go()).done, 'the filter to be let go')
    assert list(client.call('get_filters').active_filter_ids) == []
    assert not lost.is_set()
    # And one that vanishes is told.
    client.wait_for(executor.create_task(held.hold()).done, 'the filter')
    client.call('remove_filter', filter_id=held.filter_id)
    client.wait_for(lost.is_set, 'the loss to be told')


def test_who_waits_in_vain_is_told_for_what():
    with (
        SceneGraphClient('/nobody', patience=0.2) as alone,
        pytest.raises(NoAnswerError, match='the service has_collisions'),
    ):
        alone.has_collisions()


def test_no_limit_is_infinity(client):
    assert math.isinf(client.signed_distances().max_distance)


def test_a_part_follows_the_hand_that_holds_it_until_it_is_let_go(client):
    client.call('load_scene', text=SCENE, replace=True)
    assert client.attach('right::hand', 'left::hand').translation() == pytest.approx([0, 1, 0])

    def posed():
        client.publish_poses({'left::hand': [5, 0, 0, 0, 0, 0, 1]})
        return client.pose_ages()['left::hand'] > 0.0

    client.wait_for(posed, 'the pose')
    where = client.ask('get_pose', frame='right::hand').pose.pose.position
    assert (where.x, where.y, where.z) == (5.0, 1.0, 0.0)
    assert client.pose_ages()['right::hand'] == 0.0
    assert client.signed_distances().oldest_frame == 'left::hand'
    with pytest.raises(RefusedError, match='detach it first'):
        client.remove_source('left')
    assert client.detach('right::hand', [7, 0, 0, 0, 0, 0, 1]).translation()[0] == 7.0


def test_what_an_attached_part_may_touch_is_in_the_scene_until_detach(client):
    client.call('load_scene', text=SCENE, replace=True)
    client.attach('right::hand', 'left::hand', touch_links=['left'])
    for other in ('left::hand/ball', 'left::world/floor'):
        assert client.explain_filter(other, 'right::hand/ball')
    client.detach('right::hand')
    for other in ('left::hand/ball', 'left::world/floor'):
        assert client.explain_filter(other, 'right::hand/ball') == []


def test_geometries_come_together_and_sources_go_whole(client):
    client.call('load_scene', text=SCENE, replace=True)
    ball = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.1])
    roles = [msg.Role(role=msg.Role.PROXIMITY)]
    new = [msg.NewGeometry(frame='hand', name=n, shape=ball, roles=roles) for n in 'abc']
    for each in new:
        each.pose.orientation.w = 1.0
    ids = client.call('register_geometries', source='left', geometries=new).geometry_ids
    assert len(set(ids)) == 3
    with pytest.raises(RefusedError, match=r'geometries\[0\]: '):
        client.call('register_geometries', source='left', geometries=new[:1])
    hand = 'sources: [right]\nframes:\n- {name: hand, source: right}\n'
    assert client.call('load_scene', text=hand, replaced_sources=['right']).frames == 1
    where = client.ask('get_pose', frame='right::hand').pose.pose.position
    assert (where.x, where.y, where.z) == (0.0, 1.0, 1.0)
    assert client.remove_source('left') == (1, 5)
