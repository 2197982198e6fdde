"""TF on the real middleware: what real publishers of /tf and /tf_static do to a real node."""

import itertools
import signal
import subprocess
import sys
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import environment, start_node
from ros.scene_calls import accepted, place_of, poses

pytestmark = pytest.mark.topics

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='`./run test` builds it where it is missing')

STATIC = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Each test has a source of its own: the node remembers what an earlier one sent.
SCENE = """
sources: [{0}]
frames:
- {{name: base, source: {0}}}
- {{name: hand, source: {0}, parent: base}}
- {{name: cart, source: {0}}}
geometries:
- {{name: ball, source: {0}, frame: hand, shape: {{type: sphere, radius: 0.1}}}}
- {{name: box, source: {0}, frame: cart, shape: {{type: box, size: [1, 1, 1]}}}}
"""
STALE_AFTER = 0.5  # [s]
MANY = 10_000
LATER = 1000  # [s] a stamp behind those of a test's first messages
# Latches world -> map and streams map -> cart, with the time of day as the stamp.
PUBLISHER = """
import sys
import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage
rclpy.init()
node = rclpy.create_node('publisher')
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
static = node.create_publisher(TFMessage, '/tf_static', latched)
moving = node.create_publisher(TFMessage, '/tf', 10)
def send(publisher, parent, child, x):
    entry = TransformStamped(child_frame_id=child)
    entry.header.frame_id = parent
    entry.header.stamp = node.get_clock().now().to_msg()
    entry.transform.translation.x = x
    publisher.publish(TFMessage(transforms=[entry]))
send(static, 'world', 'map', 10.0)
node.create_timer(0.02, lambda: send(moving, 'map', sys.argv[1], 3.0))
rclpy.spin(node)
"""


def transform(parent, child, x, stamp=1, yaw=(0.0, 1.0)):
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.header.stamp.sec = stamp
    message.transform.translation.x = float(x)
    message.transform.rotation.z, message.transform.rotation.w = yaw
    return message


class Observer:
    """What a test does to a node by TF, and sees of it; a dot before a frame is for the source."""

    def __init__(self, client, source):
        self.client, self.source = client, source
        self._diagnostics = client.listen(DiagnosticArray, '/diagnostics')
        self._static = client.node.create_publisher(tf2_msgs.TFMessage, '/tf_static', STATIC)
        self._moving = client.node.create_publisher(tf2_msgs.TFMessage, '/tf', 100)
        client.wait_for(
            lambda: (
                self._static.get_subscription_count() and self._moving.get_subscription_count()
            ),
            'a listener to /tf and /tf_static',
        )

    def send(self, *transforms, static=False):
        """Publish a message of transforms whose frames may be of the test's source."""
        for entry in transforms:
            for holder, field in (entry, 'child_frame_id'), (entry.header, 'frame_id'):
                name = getattr(holder, field)
                if name.startswith('.'):
                    setattr(holder, field, f'{self.source}/{name[1:]}')
        message = tf2_msgs.TFMessage(transforms=transforms)
        (self._static if static else self._moving).publish(message)

    def where(self, frame):
        place = place_of(self.client, f'{self.source}::{frame}')
        return place and [round(v, 12) for v in place]

    def wait_until_at(self, frame, *position):
        self.client.wait_for(lambda: self.where(frame) == list(position), f'{frame} at {position}')

    def status(self):
        """Return the values that the node tells next."""
        return {v.key: v.value for v in self._next_status().values}

    def message(self):
        """Return what the node warns of next."""
        return self._next_status().message

    def _next_status(self):
        self._diagnostics.clear()

        def told():
            return [d for d in self._diagnostics if d.status[0].name == self.client.server]

        return self.client.wait_for(told, 'diagnostics')[-1].status[0]

    def stale(self):
        """Return which frames of the test are stale."""
        names = self.status()['names of stale frames'].split(', ')
        return {n.split('::')[1] for n in names if n.startswith(f'{self.source}::')}

    def refused(self):
        """Return how many messages of /tf and of /tf_static were refused so far."""
        status = self.status()
        return [int(status.get(f'refused from {name}', 0)) for name in ('/tf', '/tf_static')]


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    process = start_node(
        tmp_path_factory.mktemp('tf') / 'log',
        max_distance=50.0,
        stale_after=STALE_AFTER,
        use_tf=True,
    )
    yield process
    assert process.end() == 0, process.output()
    assert 'Traceback' not in process.output()


@pytest.fixture
def tf(client, request):
    source = request.node.name.removeprefix('test_')
    accepted(client.call(srv.LoadScene, 'load_scene', text=SCENE.format(source)))
    return Observer(client, source)


def test_a_chain_over_several_frames_poses_nested_frames(tf):
    results = tf.client.listen(msg.SignedDistancePairs, 'signed_distances')
    stamps = itertools.count(1)

    def heard():  # at first the node may not have found who listens
        tf.send(transform('world', '.cart', 1, next(stamps)))
        return results

    tf.client.wait_for(heard, 'a result')
    quarter = (0.5**0.5, 0.5**0.5)
    tf.send(transform('.map', '.odom', 1, LATER, quarter), transform('.odom', '.base', 2, LATER))
    tf.send(transform('.base_link', '.hand', 1, LATER), transform('.base', '.base_link', 1, LATER))
    tf.send(transform('world', '.map', 10, 0), static=True)
    # 1 along x, then a turn to the left, then 2, 1 and 1 along what was x.
    tf.wait_until_at('hand', 11, 4, 0)
    assert tf.where('base') == [11, 2, 0]
    tf.send(transform('.base_link', '.hand', 2, LATER + 1))
    tf.wait_until_at('hand', 11, 5, 0)
    # Results are stamped as TF is; a static transform does not make them look older.
    tf.client.wait_for(lambda: [m for m in results if m.header.stamp.sec == LATER + 1], 'a result')
    seen = len(results)
    tf.send(transform('world', '.map', 20, 0), static=True)
    tf.wait_until_at('hand', 21, 5, 0)
    tf.client.wait_for(lambda: len(results) > seen, 'a result for the new map')
    assert results[-1].header.stamp.sec == LATER + 1
    assert int(tf.status()['pose messages taken']) >= 3


def test_frames_that_nobody_knows_change_nothing(tf):
    before, refused = (tf.where('cart'), tf.where('hand')), tf.refused()
    tf.send(transform('world', '.stranger', 1), transform('.stranger', '.other', 1))
    tf.send(transform('.nowhere', '.cart', 1))  # no chain leads to the world
    tf.send(transform('.a', '.b', 1), transform('.b', '.a', 1))
    tf.send(transform('.a', '.base', 1), transform('.base', '.a', 1))  # nor a loop
    assert (tf.where('cart'), tf.where('hand')) == before
    assert tf.refused() == refused
    # What was sent is known all the same, once a chain does lead there.
    tf.send(transform('.stranger', '.nowhere', 1))
    tf.wait_until_at('cart', 3, 0, 0)


def test_bad_transforms_are_left_out_named_and_counted(tf, node):
    before = tf.refused()
    tf.send(transform('world', '.cart', 1))
    tf.wait_until_at('cart', 1, 0, 0)
    bad = [
        transform('world', '.base', float('nan')),
        transform('world', '.base', float('inf')),
        transform('world', '.base', 1e308),
        transform('world', '.base', 1, yaw=(0.0, 0.0)),
        transform('world', '.base', 1, yaw=(0.0, float('nan'))),
        transform('world', '.base', 1, yaw=(1.0, 1.0)),
        transform('world', '', 1),
        transform('', '.base', 1),
        transform('.base', '.base', 1),
    ]
    for k, entry in enumerate(bad * 3, 2):
        tf.send(entry, transform('world', '.cart', k, k))
        tf.wait_until_at('cart', k, 0, 0)  # of those that wait some are passed over
    for entry in bad:
        tf.send(entry, static=True)
    expected = [before[0] + 3 * len(bad), before[1] + len(bad)]
    tf.client.wait_for(lambda: tf.refused() == expected, f'{expected} refusals')
    assert tf.where('base') is None
    # Throttled by reason: of each of a topic once or twice, however often it comes.
    assert 1 <= node.output().count('transforms were left out') < 2 * len(bad)
    assert f"1 of 2 transforms were left out: '{tf.source}/base' in 'world': " in node.output()
    tf.send(transform('.base', '.base', 1), transform('world', '.base', 7), static=True)
    tf.wait_until_at('base', 7, 0, 0)  # what is latched would not come again


def test_tf_and_frame_poses_by_turns_are_told(tf, node):
    publisher = tf.client.publisher(msg.FramePoses, 'frame_poses')

    def quarrel():
        publisher.publish(poses(['cart'], [(1, 0, 0)], source=tf.source))
        tf.send(transform('world', '.cart', 2, 5))
        return f'in turn, and the last one counts: {tf.source}::cart' in tf.message()

    tf.client.wait_for(quarrel, 'a warning')
    told = f'in turn, and the last one counts: {tf.source}::cart'
    assert node.output().count(told) == 1


def test_a_chain_that_ends_elsewhere_is_told_in_the_log(tf, node):
    tf.send(transform('base_link', '.cart', 2))
    told = f"cannot be posed: '{tf.source}/cart'; the chain ends in 'base_link'"
    tf.client.wait_for(lambda: told in tf.message(), 'a warning')
    assert node.output().count(told) == 1
    tf.send(transform('world', 'base_link', 2), static=True)
    tf.wait_until_at('cart', 4, 0, 0)
    assert told not in tf.message()


def test_two_sources_that_bear_a_tf_name_are_told_at_once(tf, node):
    for copy in 'one', 'two':
        source = f'{tf.source}_{copy}'
        accepted(tf.client.call(srv.RegisterSource, 'register_source', name=source))
        accepted(tf.client.call(srv.RegisterFrame, 'register_frame', source=source, name='twin'))
    tf.send(transform('world', 'twin', 1))
    told = (
        f"1 TF frame is not followed: 'twin'; frames of the sources '{tf.source}_one' and "
        f"'{tf.source}_two' have these names"
    )
    tf.client.wait_for(lambda: told in tf.message(), 'a warning')
    assert node.output().count(told) == 1


def test_the_link_called_as_the_world_frame_is_the_world(tmp_path, lone_client):
    scene = tmp_path / 'scene.yaml'
    scene.write_text(SCENE.format('s'))
    settings = {'scene_file': scene, 'use_tf': True, 'world_frame': 'cart'}
    process = start_node(tmp_path / 'log', namespace='/elsewhere', **settings)
    lone_client.server = '/elsewhere/scene_graph'
    try:
        tf = Observer(lone_client, 's')
        assert tf.where('cart') == [0, 0, 0]
        tf.send(transform('cart', 'base', 3))
        tf.wait_until_at('base', 3, 0, 0)
        assert 'cart' not in tf.stale()
    finally:
        assert process.end() == 0, process.output()


def test_ten_thousand_transforms_in_a_message(tf):
    """A chain of all of them, from its end: the world comes last."""
    chain = [transform(f'.link{k}', f'.link{k + 1}', 0.001) for k in range(MANY - 2)]
    chain = [transform(f'.link{MANY - 2}', '.cart', 1.0), *reversed(chain)]
    tf.send(*chain, transform('world', '.link0', 1.0))
    length = 2.0 + 0.001 * (MANY - 2)
    tf.client.wait_for(
        lambda: tf.where('cart') == [pytest.approx(length, abs=1e-9), 0, 0], 'the end of the chain'
    )
    # The node is as quick as before to whoever sends little.
    tf.send(transform('world', '.cart', 5, 2))
    tf.wait_until_at('cart', 5, 0, 0)


def test_a_gap_makes_poses_stale_and_leaves_them_right(tf):
    tf.send(transform('world', '.base', 1, 0), transform('.base', '.hand', 1, 0))
    # Its only message; in a queue that others fill while the node waits it may be passed over.
    tf.wait_until_at('hand', 2, 0, 0)

    def others_go_on():
        tf.send(transform('world', '.base', 1, 0))  # without a stamp: as new as they come
        tf.send(transform('world', '.cart', 4, 0))

    timer = tf.client.node.create_timer(STALE_AFTER / 10, others_go_on)
    # The hand's own link is silent, and its base is not.
    tf.client.wait_for(lambda: tf.stale() == {'hand'}, 'the hand alone to be stale')
    assert tf.where('hand') == [2, 0, 0]
    tf.client.node.destroy_timer(timer)
    tf.client.wait_for(lambda: tf.stale() == {'hand', 'base', 'cart'}, 'all to be stale')
    assert [tf.where(name)[0] for name in ('hand', 'base', 'cart')] == [2, 1, 4]
    pair = {'geometry_a': f'{tf.source}::hand/ball', 'geometry_b': f'{tf.source}::cart/box'}
    answer = tf.client.call(srv.ComputeSignedDistancePair, 'compute_signed_distance_pair', **pair)
    result = accepted(answer).result
    assert result.oldest_pose_age > STALE_AFTER
    assert list(result.distance) == [pytest.approx(1.4)]


def test_time_that_goes_back_begins_anew(tf):
    tf.send(transform('world', '.map', 1, 0), static=True)
    tf.send(transform('.map', '.odom', 1, 50), transform('.odom', '.cart', 1, 50))
    tf.wait_until_at('cart', 3, 0, 0)
    tf.send(transform('.odom', '.cart', 9, 49))  # late, not back: nothing
    # A bag begins anew: the old odometry must not carry the cart, the static map does.
    tf.send(transform('.odom', '.cart', 7, 3))
    assert tf.where('cart') == [3, 0, 0]
    tf.send(transform('.map', '.odom', 0, 3))
    tf.wait_until_at('cart', 8, 0, 0)


def test_of_tf_and_frame_poses_the_last_one_counts(tf):
    publisher = tf.client.publisher(msg.FramePoses, 'frame_poses')

    def posed(frame, x):
        publisher.publish(poses([frame], [(x, 0, 0)], source=tf.source))
        return tf.where(frame) == [x, 0, 0]

    for k in range(3):
        tf.client.wait_for(lambda x=k + 0.5: posed('cart', x), 'the cart where frame_poses says')
        tf.send(transform('world', '.cart', k, k + 1))
        tf.wait_until_at('cart', k, 0, 0)
    # TF knows the hand in the world, whatever else posed its base.
    tf.client.wait_for(lambda: posed('base', 1), 'the base where frame_poses says')
    tf.send(transform('world', '.hand', 5))
    tf.wait_until_at('hand', 5, 0, 0)


def test_a_frame_that_comes_later_is_where_tf_has_it(tf):
    tf.send(transform('world', '.late', 6))
    later = {'source': tf.source, 'name': 'late'}
    accepted(tf.client.call(srv.RegisterFrame, 'register_frame', **later))
    tf.wait_until_at('late', 6, 0, 0)


def start_publisher(frame):
    return subprocess.Popen([sys.executable, '-c', PUBLISHER, frame], env=environment())


def test_a_publisher_is_killed_and_comes_back(tf):
    frame = f'{tf.source}/cart'
    publisher = start_publisher(frame)
    try:
        tf.wait_until_at('cart', 13, 0, 0)
        tf.client.wait_for(lambda: 'cart' not in tf.stale(), 'fresh poses of the cart')
        publisher.send_signal(signal.SIGKILL)
        publisher.wait()
        tf.client.wait_for(lambda: 'cart' in tf.stale(), 'the cart to be stale')
        assert tf.where('cart') == [13, 0, 0]
        publisher = start_publisher(frame)
        tf.client.wait_for(lambda: 'cart' not in tf.stale(), 'fresh poses once more')
    finally:
        publisher.kill()
        publisher.wait()


def test_two_parents_and_loops_are_told(tf, node):
    def quarrel():
        tf.send(transform('world', '.cart', 1, 5), transform('.b', '.base', 1, 5))
        tf.send(transform('.a', '.cart', 1, 5), transform('.base', '.b', 1, 5))
        text = tf.message()
        return f"'{tf.source}/cart' has two parents in turn" in text and 'form a loop' in text

    tf.client.wait_for(quarrel, 'a warning of both')
    assert node.output().count(f"'{tf.source}/cart' has two parents in turn") == 1


def test_what_was_latched_before_the_node_came_is_taken(tmp_path, lone_client):
    publishers = [
        lone_client.node.create_publisher(tf2_msgs.TFMessage, '/tf_static', STATIC)
        for _ in range(2)
    ]
    links = transform('world', 'hall', 1, 0), transform('hall', 'cart', 2, 0)
    for publisher, link in zip(publishers, links, strict=True):
        publisher.publish(tf2_msgs.TFMessage(transforms=[link]))
    scene = tmp_path / 'scene.yaml'
    scene.write_text(SCENE.format('s'))
    settings = {'scene_file': scene, 'stale_after': STALE_AFTER, 'use_tf': True, 'rate': 20.0}
    process = start_node(tmp_path / 'log', namespace='/later', **settings)
    lone_client.server = '/later/scene_graph'
    try:
        tf = Observer(lone_client, 's')
        tf.wait_until_at('cart', 3, 0, 0)
        time.sleep(2 * STALE_AFTER)
        # What is static does not grow old; a word of before may still be in the queue.
        tf.client.wait_for(lambda: tf.stale() == {'base', 'hand'}, 'the cart to be fresh')
    finally:
        assert process.end() == 0, process.output()
