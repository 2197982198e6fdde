"""Pose messages that are refused whole and counted, and odd ones that are taken."""

import array
import re
from collections import Counter
from random import Random

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from rclpy.serialization import serialize_message
from ros.harness import LATCHED, start_node
from ros.scene_calls import accepted, add_pair, place_of, poses, refused
from std_msgs.msg import String

from bench.ros.hostile import MANY, pose_messages, ten_million

pytestmark = pytest.mark.topics

FRAMES = ['a', 'b']
# Every message arrives: a stream of poses is best effort otherwise, and 1 MB is many packets.
POSES = 'qos_overrides./sure/scene_graph/frame_poses.subscription'
SURE = {f'{POSES}.reliability': 'reliable', f'{POSES}.depth': 100}
MOST_LOG_LINES = 3  # of one kind in 5 s, however many messages are refused


def where(client, frame):
    place = place_of(client, frame)
    return place and place[0]


def refusals(diagnostics, node):
    """Return how many pose messages a node says it refused; None before it said so."""
    for status in (message.status[0] for message in reversed(diagnostics)):
        if status.name == node:
            return int({v.key: v.value for v in status.values}['pose messages refused'])
    return None


def test_a_what_if_is_refused_for_the_same_reasons(client):
    add_pair(client, 'what_if')
    for _, message, word in pose_messages(['what_if::a', 'what_if::b'], 'what_if'):
        refused(client.call(srv.HasCollisions, 'has_collisions', poses=message), word)
    accepted(client.call(srv.HasCollisions, 'has_collisions'))


def test_hostile_messages_are_counted_and_change_nothing(tmp_path, lone_client):
    client, node = lone_client, start_node(tmp_path / 'log', namespace='/sure', **SURE)
    client.server = '/sure/scene_graph'
    try:
        add_pair(client, 'stream')
        diagnostics = client.listen(DiagnosticArray, '/diagnostics')
        publisher = client.publisher(msg.FramePoses, 'frame_poses', 100)

        def posed():
            # Again and again: a server that has not found the publisher yet takes nothing of it.
            publisher.publish(poses(FRAMES, [(1, 0, 0), (2, 0, 0)], 'stream'))
            return where(client, 'stream::a') == 1.0

        client.wait_for(posed, 'the good poses')
        messages = [m for _, m, _ in pose_messages(['stream::a', 'stream::b'], 'stream')]
        for message in messages * 4:
            publisher.publish(message)
        client.wait_for(
            lambda: refusals(diagnostics, client.server) == 4 * len(messages), 'all refusals'
        )
        assert (where(client, 'stream::a'), where(client, 'stream::b')) == (1.0, 2.0)
        # 80 MB in one message of the stream.
        publisher.publish(ten_million(['stream::a', 'stream::b']))
        client.wait_for(
            lambda: refusals(diagnostics, client.server) == 4 * len(messages) + 1, 'its refusal'
        )
        # One input that is refused without end does not silence another.
        robots = client.node.create_publisher(String, '/sure/robot_description', LATCHED)
        robots.publish(String(data='<robot'))
        client.wait_for(
            lambda: 'a message of robot_description was refused' in node.output(), 'the reason'
        )
        # The log is throttled.
        lines = re.findall('a message of frame_poses was refused(.{40})', node.output())
        assert 1 <= len(lines) < len(messages)
        assert max(Counter(lines).values()) <= MOST_LOG_LINES
        assert len(node.output()) < 10_000
    finally:
        assert node.end() == 0, node.output()


def test_ten_million_numbers_are_refused(client):
    add_pair(client, 'many')
    message = ten_million(['many::a', 'many::b'])
    answer = client.call(srv.HasCollisions, 'has_collisions', poses=message)
    refused(answer, f'poses holds {MANY} numbers for 2 frames')
    # Each point has a distance from each geometry: no answer could hold that.
    points = array.array('d', bytes(8 * 3 * (MANY // 3)))
    request = {'points': points, 'poses': poses(FRAMES, [(0, 0, 0), (1, 0, 0)], 'many')}
    answer = client.call(
        srv.ComputeSignedDistanceToPoint, 'compute_signed_distance_to_point', **request
    )
    refused(answer, 'rows takes', 'max_answer_size', 'fewer points')
    accepted(client.call(srv.HasCollisions, 'has_collisions'))


def test_garbled_bytes_end_nothing(client, node):
    """What a publisher with another definition of the message, or a broken one, would send."""
    add_pair(client, 'garbled')
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 200)
    good = bytes(serialize_message(poses(FRAMES, [(1, 0, 0), (2, 0, 0)], 'garbled')))
    random = Random(1)
    for _ in range(200):
        garbled = bytearray(good)
        for _ in range(random.randint(1, 6)):
            garbled[random.randrange(4, len(good))] = random.randrange(256)
        publisher.publish(bytes(garbled[: random.choice([len(good), len(good), 5, 21, 60])]))

    def taken():
        publisher.publish(poses(FRAMES, [(3, 0, 0), (4, 0, 0)], 'garbled'))
        return (where(client, 'garbled::a'), where(client, 'garbled::b')) == (3.0, 4.0)

    client.wait_for(taken, 'a good message to be taken')
    assert 'internal error' not in node.output()


def test_a_frame_named_as_the_id_of_another(client):
    """Posing the one by its name, then the other by its id, moves each of them."""
    accepted(client.call(srv.RegisterSource, 'register_source', name='numbered'))
    first = {'source': 'numbered', 'name': 'first'}
    number = accepted(client.call(srv.RegisterFrame, 'register_frame', **first)).frame_id
    second = {'source': 'numbered', 'name': str(number)}
    accepted(client.call(srv.RegisterFrame, 'register_frame', **second))
    publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def posed(name, message, x):
        publisher.publish(message)
        return where(client, f'numbered::{name}') == x

    by_name = poses([str(number)], [(1, 0, 0)], 'numbered')
    client.wait_for(lambda: posed(number, by_name, 1.0), 'the pose by name')
    by_id = poses([], [(2, 0, 0)], 'numbered')
    by_id.frame_ids = [number]
    client.wait_for(lambda: posed('first', by_id, 2.0), 'the pose by id')
    assert where(client, f'numbered::{number}') == 1.0


def test_odd_messages_that_are_legal_are_taken(client):
    add_pair(client, 'odd')
    distances = client.listen(msg.SignedDistancePairs, 'signed_distances')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def stamped(seconds, x):
        """Send poses with a stamp until they are answered with it."""

        def answer():
            publisher.publish(poses(FRAMES, [(0, 0, 0), (x, 0, 0)], 'odd', seconds))
            return any(m.header.stamp.sec == seconds for m in distances)

        distances.clear()
        client.wait_for(answer, f'the answer for {seconds} s')
        assert where(client, 'odd::b') == x

    stamped(100, 0.4)
    stamped(50, 0.5)  # time goes back: what comes last counts
    stamped(0, 0.6)  # a stamp that nobody set
    publisher.publish(msg.FramePoses())  # no frame at all: nothing changes
    assert where(client, 'odd::b') == 0.6
