"""A recorded run of a real node: each figure is its own, and an audit finds what is false."""

import time
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from drake_geom_msgs import msg
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import LATCHED, start_node
from sensor_msgs.msg import JointState

rosbags = pytest.importorskip('rosbags.rosbag2')

from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: E402

from drake_geom_ros.command_line.program import main  # noqa: E402
from drake_geom_ros.recordings import Outcome, RecordingError, audit, clearance  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / 'test' / 'batch' / 'cell.yaml'
NAMES = ['turn', 'bend', 'roll', 'slide']
RULE = """
proximity_rules:
- {name: hand to tray, set_a: arm, set_b: tray, enter: 0.25, leave: 0.3, level: slow,
   when_stale: keep}
"""
DEEP = QoSProfile(depth=200)
NODE = '/recorded_node'
LONG = 600.0  # [s] a busy machine compiles and computes so long
pytestmark = [
    pytest.mark.topics,
    pytest.mark.timeout(2 * LONG),  # of a test with what it drives first
]
STALE_AFTER = 60.0  # [s] so poses are fresh however long a busy machine takes
APART = 0.03  # [s] poses of two topics within 20 ms are of an order that an audit does not know
INPUTS = '/joint_states', '/frame_poses'
ANSWERS = '/signed_distances', '/penetrations'


@pytest.fixture(scope='module')
def server():
    return NODE


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp('recordings')
    (folder / 'cell.yaml').write_text(CELL.read_text() + RULE)
    (folder / 'arm.urdf').write_text(CELL.with_name('arm.urdf').read_text())
    return folder


@pytest.fixture(scope='module')
def node(folder):
    process = start_node(
        *(folder / 'log',),
        name=NODE[1:],
        scene_file=folder / 'cell.yaml',
        use_joint_states=True,
        max_distance=10.0,
        stale_after=STALE_AFTER,
    )
    yield process
    assert process.end() == 0, process.output()


@cache
def typestore():
    """Return the types of our messages, by their definitions."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for file in sorted((ROOT / 'msg_defs' / 'msg').glob('*.msg')):
        store.register(get_types_from_msg(file.read_text(), f'drake_geom_msgs/msg/{file.stem}'))
    return store


class Recorder:
    """Subscribes to topics, and keeps the bytes that come, as ``ros2 bag record`` does."""

    TOPICS = (
        ('/joint_states', JointState, DEEP),
        (f'{NODE}/frame_poses', msg.FramePoses, DEEP),
        (f'{NODE}/scene', msg.Scene, LATCHED),
        (f'{NODE}/signed_distances', msg.SignedDistancePairs, DEEP),
        (f'{NODE}/penetrations', msg.PenetrationPairs, DEEP),
        (
            f'{NODE}/proximity_events',
            msg.ProximityEvents,
            QoSProfile(depth=200, durability=DurabilityPolicy.VOLATILE),
        ),
    )

    def __init__(self, client):
        self.came = []
        self._looked, self._stamps = 0, {}  # messages that were looked at; topics by stamp
        for topic, kind, qos in self.TOPICS:
            name = f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}'
            client.node.create_subscription(kind, topic, self._keep(topic, name), qos, raw=True)

    def _keep(self, topic, kind):
        return lambda data: self.came.append((time.time_ns(), topic, kind, bytes(data)))

    def has_answers(self, stamp):
        """Return whether a message of this stamp came, and what the node says of its state."""
        store, wanted = typestore(), (stamp.sec, stamp.nanosec)
        while self._looked < len(self.came):
            _, topic, kind, data = self.came[self._looked]
            self._looked += 1
            if topic.endswith(INPUTS + ANSWERS):
                found = store.deserialize_cdr(data, kind).header.stamp
                self._stamps.setdefault((found.sec, found.nanosec), set()).add(topic)
        topics = self._stamps.get(wanted, set())
        return all(any(t.endswith(each) for t in topics) for each in (INPUTS, *ANSWERS))

    def count(self, topic):
        return sum(each[1].endswith(topic) for each in self.came)

    def write(self, folder, change=lambda topic, kind, data: data):
        store, connections = typestore(), {}
        with rosbags.Writer(
            folder, version=9, storage_plugin=rosbags.StoragePlugin.MCAP
        ) as writer:
            for stamp, topic, kind, data in self.came:
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=store)
                writer.write(connections[topic], stamp, change(topic, kind, data))
        return folder


@pytest.fixture(scope='module')
def run(node, module_client):
    """Drive the node for a while; return what was recorded."""
    client = module_client
    recorder = Recorder(client)
    clock = client.node.get_clock()
    joints = client.node.create_publisher(JointState, '/joint_states', DEEP)
    poses = client.publisher(msg.FramePoses, 'frame_poses', DEEP)
    client.wait_for(joints.get_subscription_count, 'a listener to joint states')
    # A node compiles first what no process has compiled before.
    client.wait_for(
        lambda: recorder.count('scene') or node.popen.poll() is not None, 'the scene', LONG
    )
    assert node.popen.poll() is None, node.output()

    def tell(publisher, message):
        """Publish a message; wait until it and what the node says of it are recorded.

        So each result is that of one state, and states come in one order, however busy or
        fast the machine is.
        """
        stamp = message.header.stamp = clock.now().to_msg()
        publisher.publish(message)
        client.wait_for(lambda: recorder.has_answers(stamp), f'answers of {stamp}', LONG)
        client.spin_until(time.monotonic() + APART)

    for k in range(80):
        phase = 0.1 * k
        q = [0.8 + 0.8 * np.sin(phase), 0.5 * np.sin(2 * phase), 0.3, 0.05]
        tell(joints, JointState(name=NAMES, position=q))
        row = [0.5 + 0.1 * np.cos(phase), 0.1, 0.4, 0.0, 0.0, 0.0, 1.0]
        tell(poses, msg.FramePoses(frame_names=['things::tray'], poses=row))
    client.wait_for(lambda: recorder.count('proximity_events') >= 2, 'events', LONG)
    return recorder


@pytest.fixture(scope='module')
def recording(run, folder):
    return run.write(folder / 'run')


def test_each_figure_is_the_nodes_own(run, recording, folder):
    asked = {'max_distance': 10.0, 'stale_after': STALE_AFTER}
    whole = clearance(recording, folder / 'cell.yaml', **asked)
    found = whole['all']
    assert whole.least('all', allow_incomplete=True).distance == np.nanmin(found.known_distance)
    store, compared = typestore(), 0
    stamps = states_by_stamp(run, store)
    assert len(stamps) == len(found.times)
    by_stamp = dict(zip(stamps, range(len(stamps)), strict=True))
    for _, topic, kind, data in run.came:
        if topic.endswith('/signed_distances'):
            message = store.deserialize_cdr(data, kind)
            state = by_stamp.get((message.header.stamp.sec, message.header.stamp.nanosec))
            if state is None:
                continue
            lower = message.distance - message.error_bound
            k = int(np.argmin(lower))
            assert found.known_distance[state] == message.distance[k]
            assert found.known_error_bound[state] == message.error_bound[k]
            assert found.left_out[state] == message.waiting_pairs
            compared += 1
    assert compared >= 160


def states_by_stamp(run, store):
    """Return the stamp of each message that poses something, in the order of recording."""
    stamps = []
    for _, topic, kind, data in run.came:
        if topic.endswith(INPUTS):
            stamp = store.deserialize_cdr(data, kind).header.stamp
            stamps.append((stamp.sec, stamp.nanosec))
    return stamps


def test_what_the_node_said_is_the_same_to_the_bit(recording, folder):
    found = audit(recording, folder / 'cell.yaml', stale_after=STALE_AFTER)
    counts = found.counts()
    assert counts[Outcome.REFUTED] == 0, found.by_reason()
    proved = Counter(e.topic for e in found.entries if e.outcome == Outcome.WITHIN)
    topics = Counter(e.topic for e in found.entries if e.outcome == Outcome.SAME)
    assert (topics + proved)[f'{NODE}/signed_distances'] >= 100
    # Others began with an earlier answer: their witness points, too, are of other last digits.
    assert topics[f'{NODE}/signed_distances'] >= 1
    assert topics[f'{NODE}/penetrations'] >= 100
    assert topics[f'{NODE}/proximity_events'] >= 2
    said = [e for e in found.entries if e.topic.endswith('events')]
    assert any('entered' in e.what for e in said)
    assert any('left' in e.what for e in said)


def test_what_is_false_is_refuted(run, folder, tmp_path):
    store, wrong, events_seen = typestore(), [], []

    def falsified(topic, kind, data):
        if topic.endswith('/signed_distances'):
            message = store.deserialize_cdr(data, kind)
            wrong.append(len(wrong))
            if len(wrong) == 30:
                message.distance = message.distance + 1e-6
            if len(wrong) == 40:
                message.error_bound = message.error_bound + 1e-6
            if len(wrong) == 50:  # as a pair that was filtered
                for name in ('id_a', 'id_b', 'distance', 'error_bound', 'method'):
                    setattr(message, name, getattr(message, name)[1:])
                message.is_nhat_ba_w_unique = message.is_nhat_ba_w_unique[1:]
                for name in ('p_aca', 'p_bcb', 'nhat_ba_w'):
                    setattr(message, name, getattr(message, name)[3:])
            if len(wrong) == 60:
                message.p_aca = message.p_aca + 1e-3
            data = bytes(store.serialize_cdr(message, kind))
        if topic.endswith('/proximity_events'):
            message = store.deserialize_cdr(data, kind)
            events_seen.append(message)
            if len(events_seen) % 2:
                message.distance = message.distance + 1e-3
            else:
                message.p_wcb = message.p_wcb + 1e-3
            data = bytes(store.serialize_cdr(message, kind))
        return data

    changed = run.write(tmp_path / 'changed', falsified)
    entries = audit(changed, folder / 'cell.yaml').entries
    said = [e for e in entries if e.topic.endswith('/signed_distances')]
    assert [said[k].outcome for k in (29, 39, 49, 59)] == [
        Outcome.REFUTED,
        Outcome.WITHIN,
        Outcome.REFUTED,
        Outcome.REFUTED,
    ]
    events = [e.outcome for e in entries if e.topic.endswith('events') and 'near' not in e.because]
    assert Outcome.REFUTED in events
    assert Outcome.SAME not in events
    # Who goes on with it later is told so again, and not that there is a report.
    asked = ['report', changed, '--scene', folder / 'cell.yaml', '--out', tmp_path / 'out']
    asked = [*map(str, asked), '--audit', '--pictures', '0']
    record = tmp_path / 'out' / 'report.json'
    assert main(asked) == 3
    made = record.stat().st_mtime_ns
    assert main([*asked, '--resume']) == 3
    assert record.stat().st_mtime_ns == made


def test_what_was_not_recorded_is_told(run, folder, tmp_path):
    whole = run.came
    try:
        run.came = [each for each in whole if not each[1].endswith('/scene')]
        found = audit(run.write(tmp_path / 'no_scene'), folder / 'cell.yaml')
        assert any('no ~/scene' in e.because for e in found.entries)
        run.came = [each for each in whole if not each[1].endswith('/frame_poses')]
        found = audit(run.write(tmp_path / 'no_poses'), folder / 'cell.yaml')
        reasons = {e.because for e in found.entries if e.outcome == Outcome.NOT_REPRODUCIBLE}
        assert 'no recorded poses bear its stamp' in reasons
        run.came = [each for each in whole if each[1].endswith(INPUTS)]
        with pytest.raises(RecordingError, match='nothing to be audited'):
            audit(run.write(tmp_path / 'nothing'), folder / 'cell.yaml')
    finally:
        run.came = whole
