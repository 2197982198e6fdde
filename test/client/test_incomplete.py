"""A robot that was never posed is not free: what the client and the topics say of it."""

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import PATIENCE

from drake_geom_ros.client import IncompleteError, SceneGraphClient
from drake_geom_ros.client import SignedDistances as Distances

pytestmark = pytest.mark.topics

# The lost robot's geometry would be inside the box if it stood at the origin.
SCENE = """
sources: [cell, lost]
frames:
- {name: cart, source: cell, pose: {position: [5, 0, 0]}}
- {name: base, source: lost}
- {name: hand, source: lost, parent: base, pose: {position: [0, 0, 0.1]}}
geometries:
- {name: block, source: cell, shape: {type: box, size: [1, 1, 1]}}
- {name: load, source: cell, frame: cart, shape: {type: box, size: [1, 1, 1]}}
- {name: ball, source: lost, frame: hand, shape: {type: sphere, radius: 0.1}}
"""
TOLD = '2 pairs are left out because 1 frame never had a pose: lost::base'
HERE = {'lost::base': [9, 0, 0, 0, 0, 0, 1]}


@pytest.fixture(scope='module')
def client(node):
    with SceneGraphClient(patience=PATIENCE) as client:
        client.call('load_scene', text=SCENE, replace=True)
        yield client


@pytest.mark.parametrize(
    ('name', 'arguments', 'told'),
    [
        ('has_collisions', (), TOLD),
        ('signed_distances', (), TOLD),
        ('penetrations', (), TOLD),
        ('point_distances', ([[0, 0, 0]],), TOLD.replace('2 pairs are', '1 geometry is')),
    ],
)
def test_an_answer_that_leaves_something_out_is_raised(client, name, arguments, told):
    with pytest.raises(IncompleteError, match=f'{name}: {told}') as caught:
        getattr(client, name)(*arguments)
    assert 'allow_incomplete=True' in str(caught.value)
    assert getattr(client, name)(*arguments, allow_incomplete=True) is not None
    # What the question itself poses is known.
    assert getattr(client, name)(*arguments, poses=HERE) is not None


def test_a_collision_that_is_found_is_true_whatever_is_left_out(client):
    assert client.has_collisions({'cell::cart': [0.5, 0, 0, 0, 0, 0, 1]})
    assert client.has_collisions(allow_incomplete=True) is False
    assert client.has_collisions(HERE) is False


def test_results_say_what_they_leave_out(client):
    found = client.signed_distances(allow_incomplete=True)
    assert (found.is_complete, found.waiting_pairs) == (False, 2)
    assert found.waiting_frames == ('lost::base',)
    # Of what has poses all is there.
    pair = found.between('cart', 'block')
    assert pair.is_complete
    assert pair.closest().distance == pytest.approx(4.0)
    for less in (found, found.between('lost'), found.between('block'), found[:1]):
        assert not less.is_complete
        with pytest.raises(IncompleteError, match=TOLD):
            less.closest()
    assert found.closest(allow_incomplete=True).distance == pair.closest().distance
    with pytest.raises(IncompleteError, match='no row'):
        bool(found.between('lost'))
    whole = client.signed_distances(poses=HERE)
    assert (whole.is_complete, whole.waiting_pairs, whole.waiting_frames) == (True, 0, ())
    assert whole.between('lost', 'block').closest().distance == pytest.approx(8.4)
    points = client.point_distances([[0, 0, 0]], allow_incomplete=True)
    assert (points.is_complete, points.waiting_geometries) == (False, 1)
    assert points.to('cell').is_complete
    assert not points.to('lost').is_complete


def test_one_pair_that_would_need_it_is_refused_and_another_is_whole(client):
    with pytest.raises(RuntimeError, match='never had a pose'):
        client.signed_distance('hand/ball', 'world/block')
    assert client.signed_distance('cart/load', 'world/block').distance == pytest.approx(4.0)


@pytest.mark.parametrize(
    ('service', 'name'),
    [
        (srv.HasCollisions, 'has_collisions'),
        (srv.FindCollisionCandidates, 'find_collision_candidates'),
    ],
)
def test_raw_answers_have_it_as_a_field(client, service, name):
    answer = client.ask(name)
    assert (list(answer.waiting_frames), answer.waiting_pairs) == (['lost::base'], 2)
    assert answer.scene_version == client.scene().version
    assert answer.oldest_pose_age == float('inf')
    pair = {'geometry_a': 'cart/load', 'geometry_b': 'world/block'}
    one = client.ask('compute_signed_distance_pair', **pair)
    assert (list(one.result.waiting_frames), one.result.waiting_pairs) == ([], 0)


def test_images_tell_whom_they_do_not_show(client):
    camera = msg.Camera(width=8, height=8, fov_y=0.8, shows='proximity')
    answer = client.ask('render_image', given=camera, images=['depth'])
    assert list(answer.waiting_frames) == ['lost::base']


def test_a_listener_to_the_topics_sees_it(client):
    distances, depths = [], []
    client.listener.on_signed_distances(distances.append)
    client.listener.on_penetrations(depths.append)

    def come():
        client.publish_poses({'cart': [0.5, 0, 0, 0, 0, 0, 1]}, source='cell')
        return distances and depths

    client.wait_for(come, 'results')
    for found in (distances[-1], depths[-1]):
        assert (found.waiting_frames, found.waiting_pairs) == (('lost::base',), 2)
        assert not found.is_complete
    assert isinstance(distances[-1], Distances)
    with pytest.raises(IncompleteError):
        distances[-1].closest()
    client.publish_poses({'base': [9, 0, 0, 0, 0, 0, 1]}, source='lost')
    client.wait_for(lambda: distances[-1].is_complete and depths[-1].is_complete, 'whole results')
    assert distances[-1].closest().distance < 0.0
