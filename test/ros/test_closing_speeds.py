"""Closing speeds on the real middleware: by poses, by twists, and only where asked for."""

import math
import time

import numpy as np
import pytest
from drake_geom_msgs import msg, srv
from ros.harness import Client, start_node
from ros.scene_calls import add_pair, poses

pytestmark = pytest.mark.topics

# [s] Longer than a loaded machine takes for the steps of a test: older poses tell no speed.
STALE_AFTER = 50.0
TENTH = 10**8  # [ns]


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    log = tmp_path_factory.mktemp('closing') / 'log'
    values = {'closing_speeds': True, 'max_distance': 10.0, 'stale_after': STALE_AFTER}
    process = start_node(log, name='closing', **values)
    client = Client('/closing')
    add_pair(client, 'pair')
    client.close()
    yield process
    process.end()


@pytest.fixture
def client(node):
    client = Client('/closing')
    yield client
    client.close()
    assert node.popen.poll() is None, f'the node died:\n{node.output()}'


def send(publisher, x, stamp=0):
    """Pose b at x [m] and a at the origin, at a time [ns]; 0: without one."""
    message = poses(['a', 'b'], [(0, 0, 0), (x, 0, 0)], source='pair')
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    publisher.publish(message)


def twists(v, stamp):
    message = msg.FrameTwists(source='pair', frame_names=['a', 'b'])
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    message.twists = [0.0] * 9 + [v, 0.0, 0.0]
    return message


def answer_for(client, heard, x, known, again=lambda: None):
    """Return the answer for b at x that does, or does not, know the speed.

    ``again`` is called as long as there is none: what is sent before a publisher is known is lost.
    """

    def found():
        again()
        return next(
            (
                each
                for each in reversed(heard)
                if len(each.distance) == 1
                and math.isclose(each.distance[0], x - 0.3, abs_tol=1e-9)
                and list(each.has_closing_speed) == [known]
            ),
            None,
        )

    return client.wait_for(found, f'an answer for x = {x} where the speed is known: {known}')


def test_speeds_come_from_poses_and_from_twists_that_are_not_older(client):
    heard = client.listen(msg.SignedDistancePairs, 'signed_distances')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    teller = client.publisher(msg.FrameTwists, 'frame_twists')
    now = time.time_ns()

    first = answer_for(client, heard, 1.3, known=False, again=lambda: send(publisher, 1.3, now))
    assert np.isnan([first.closing_speed[0], first.time_to_contact[0]]).all()

    send(publisher, 1.25, now + TENTH)
    by_poses = answer_for(client, heard, 1.25, known=True)
    assert by_poses.closing_speed[0] == pytest.approx(0.5)
    assert by_poses.time_to_contact[0] == pytest.approx(0.95 / 0.5)

    # Without a stamp poses tell nothing, until somebody else does.
    send(publisher, 1.1)
    answer_for(client, heard, 1.1, known=False)

    def tell():
        teller.publish(twists(0.25, now + 2 * TENTH))
        send(publisher, 1.1, now + 2 * TENTH)

    told = answer_for(client, heard, 1.1, known=True, again=tell)
    assert told.closing_speed[0] == pytest.approx(-0.25)
    assert told.time_to_contact[0] == math.inf

    for name, request in (
        ('pairwise', {}),
        ('pair', {'geometry_a': 'a/ball', 'geometry_b': 'b/ball'}),
    ):
        kind = getattr(srv, f'ComputeSignedDistance{name.capitalize()}')
        service = f'compute_signed_distance_{name}'
        answer = client.call(kind, service, **request).result
        assert list(answer.closing_speed) == list(told.closing_speed)
        assert list(answer.time_to_contact) == [math.inf]
        asked = poses(['b'], [(0.7, 0, 0)], source='pair')
        what_if = client.call(kind, service, poses=asked, **request).result
        assert (len(what_if.distance), len(what_if.closing_speed)) == (1, 0)


def test_overlaps_have_them_too(client):
    overlaps = client.listen(msg.PenetrationPairs, 'penetrations')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    now = time.time_ns()

    def deeper():
        for k in range(2):
            send(publisher, 0.25 - 0.02 * k, now + k * TENTH)
        known = [each for each in overlaps if list(each.has_closing_speed) == [True]]
        return next((each for each in known if math.isclose(each.depth[0], 0.07)), None)

    def answered():  # again: poses on their way take the speed back and give it anew
        kind = srv.ComputePointPairPenetration
        answer = client.call(kind, 'compute_point_pair_penetration').result
        return answer if list(answer.has_closing_speed) == [True] else None

    found = client.wait_for(deeper, 'an overlap that grows')
    assert found.closing_speed[0] == pytest.approx(0.2)
    assert found.time_to_contact[0] == 0.0
    answer = client.wait_for(answered, 'an answer that knows the speed')
    assert answer.closing_speed[0] == pytest.approx(0.2)


def test_without_the_parameter_nobody_listens_and_nothing_is_said(tmp_path):
    process, client = start_node(tmp_path / 'log', name='still', max_distance=10.0), None
    try:
        client = Client('/still')
        heard = client.listen(msg.SignedDistancePairs, 'signed_distances')
        add_pair(client, 'pair')
        publisher = client.publisher(msg.FramePoses, 'frame_poses')

        def answered():
            send(publisher, 0.35)
            return heard and heard[-1]

        answer = client.wait_for(answered, 'an answer')
        asked = client.call(srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise')
        assert (len(asked.result.distance), len(asked.result.closing_speed)) == (1, 0)
        fields = (answer.has_closing_speed, answer.closing_speed, answer.time_to_contact)
        assert [len(field) for field in fields] == [0, 0, 0]
        assert '/still/frame_twists' not in dict(client.node.get_topic_names_and_types())
    finally:
        if client is not None:
            client.close()
        process.end()
