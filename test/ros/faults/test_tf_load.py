"""More transforms than a node can take at once: what waits is merged, and told to be late."""

import signal
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from drake_geom_msgs import msg
from geometry_msgs.msg import TransformStamped
from ros.harness import start_node

pytestmark = pytest.mark.topics

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='`./run test` builds it where it is missing')

MANY = 80  # messages, less than the queue holds
PAUSE = 1.0  # [s] for which the node is stopped
SCENE = """
sources: [s]
frames: [{name: tool, source: s}, {name: cart, source: s}]
geometries:
- {name: ball, source: s, frame: tool, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: s, frame: cart, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture
def node(tmp_path):
    scene = tmp_path / 'scene.yaml'
    scene.write_text(SCENE)
    process = start_node(tmp_path / 'log', scene_file=scene, use_tf=True, max_distance=1e3)
    yield process
    assert process.end() == 0, process.output()


def transforms(x, behind=0.0):
    """Return a message that puts the tool at x, by stamps of so long [s] ago."""
    nanoseconds = time.time_ns() - round(behind * 1e9)
    entries = []
    for name, position in ('tool', x), ('cart', -1.0):
        entry = TransformStamped(child_frame_id=name)
        entry.header.frame_id = 'world'
        entry.header.stamp.sec, entry.header.stamp.nanosec = divmod(nanoseconds, 10**9)
        entry.transform.translation.x = float(position)
        entries.append(entry)
    return tf2_msgs.TFMessage(transforms=entries)


def test_what_waits_is_merged_and_its_lag_told(node, client):
    results = client.listen(msg.SignedDistancePairs, 'signed_distances', 200)
    diagnostics = client.listen(DiagnosticArray, '/diagnostics', 100)
    publisher = client.node.create_publisher(tf2_msgs.TFMessage, '/tf', 100)
    client.wait_for(publisher.get_subscription_count, 'a listener to /tf')

    def at(x):
        """Whether the newest result is for the tool at x."""
        return results and abs(results[-1].distance[0] - (x + 0.8)) < 1e-9

    def posed():
        publisher.publish(transforms(0.0, behind=7.0))
        return at(0.0)

    client.wait_for(posed, 'a result')
    # By stamps of 7 s ago poses are 7 s old, however soon they are taken.
    assert results[-1].oldest_pose_age >= 7.0

    node.popen.send_signal(signal.SIGSTOP)
    before = len(results)
    for k in range(MANY):
        publisher.publish(transforms(2.0 + k))
    client.spin_until(time.monotonic() + PAUSE)
    diagnostics.clear()
    node.popen.send_signal(signal.SIGCONT)
    client.wait_for(lambda: at(1.0 + MANY), 'the last of the poses')
    # The messages that had come were one cycle, or few, and late.
    assert len(results) - before < MANY / 2
    assert results[-1].oldest_pose_age >= PAUSE / 2

    def merged():
        """Return the status of the second in which messages were taken together."""
        for status in (s for m in diagnostics for s in m.status if s.name == client.server):
            told = {v.key: v.value for v in status.values}
            if int(told['largest batch of pose messages']) > 1:
                return status, float(told['lag worst [ms]'])
        return None

    status, lag = client.wait_for(merged, 'messages that were taken together')
    assert status.level == DiagnosticStatus.WARN
    assert 'half of the results were published more than' in status.message
    assert lag >= 1e3 * PAUSE / 2
