"""Queries run beside the pose stream: in real processes, on a scene of a thousand bodies."""

import array
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from drake_geom_msgs import msg, srv
from ros.harness import PATIENCE, environment, start_node
from ros.scene_calls import accepted, add_sphere, exclude

from bench.ros.scenes import scene_text
from drake_geom_ros.common.children import end

pytestmark = pytest.mark.topics

COUNT = 1000
FRAMES = [f's::f{k}' for k in range(COUNT)]
SHAPES = ('{type: sphere, radius: 0.1}', '{type: box, size: [0.2, 0.2, 0.2]}')
# Queues for two seconds of stream: the answer to all pairs is 53 MB, and while rclpy turns it
# into a message (some 0.1 s) nothing else of the process runs; then it catches up.
TOPICS = ('frame_poses.subscription', 'signed_distances.publisher', 'cycle_report.publisher')
DEEP = {f'qos_overrides./scene_graph/{topic}.depth': 200 for topic in TOPICS}
# And all of it arrives: what the node loses is counted here, not what a busy socket does.
DEEP['qos_overrides./scene_graph/frame_poses.subscription.reliability'] = 'reliable'
RATE, MESSAGES = 100, 200
# Processes that go on asking until they are ended: the script, and where ``ros.harness`` is.
TESTS = str(Path(__file__).parents[1])
ASKER = """
import sys
sys.path.append(sys.argv[1])
from drake_geom_msgs import srv
from drake_geom_ros.ros.spinning import StopSignals
from ros.harness import Client
client = Client()
with StopSignals() as signals:
    while not signals.received:
        answer = client.call(srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise')
        print(len(answer.result.id_a), flush=True)
"""

# Asks for what it finds in the scene, and prints what was not answered.
BUSY = """
import sys
sys.path.append(sys.argv[1])
from drake_geom_msgs import srv
from drake_geom_ros.ros.spinning import StopSignals
from ros.harness import Client
client = Client()
asked = (
    ('has_collisions', srv.HasCollisions, {}),
    ('get_filters', srv.GetFilters, {}),
    ('compute_signed_distance_pairwise', srv.ComputeSignedDistancePairwise, {'max_distance': 0.1}),
    ('save_scene', srv.SaveScene, {}),
)
with StopSignals() as signals:
    while not signals.received:
        for name, kind, fields in asked:
            answer = client.call(kind, name, **fields)
            print('answered' if answer.success else answer.message, flush=True)
"""


@contextmanager
def asking(script, count=1):
    """Run processes that ask; ended by SIGINT: one killed may hold a mutex of shared memory.

    They finish a question first: an interrupt is lost where it hits a destructor of rclpy's.
    """
    processes = [
        subprocess.Popen(
            [sys.executable, '-c', script, TESTS],
            env=environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        for _ in range(count)
    ]
    try:
        yield processes
    finally:
        for process in processes:
            end(process, PATIENCE, signal.SIGINT)
            process.stdout.close()


def positions(step):
    """Return where the bodies are: a flat grid, all of it moving along."""
    grid = np.zeros((COUNT, 7))
    grid[:, 6] = 1.0
    grid[:, 0] = 0.25 * (np.arange(COUNT) % 32) + 0.001 * step
    grid[:, 1] = 0.25 * (np.arange(COUNT) // 32)
    return grid


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    folder = tmp_path_factory.mktemp('thousand')
    scene = folder / 'scene.yaml'
    scene.write_text(scene_text([f'f{k}' for k in range(COUNT)], SHAPES * (COUNT // 2)))
    process = start_node(folder / 'log', scene_file=scene, max_distance=0.1, **DEEP)
    yield process
    process.end()


def poses(step):
    message = msg.FramePoses(frame_names=FRAMES)
    message.header.stamp.sec = step
    message.poses = array.array('d', positions(step).tobytes())
    return message


def test_a_stream_loses_nothing_while_all_pairs_are_asked_for(client):
    results = client.listen(msg.SignedDistancePairs, 'signed_distances', 2 * MESSAGES)
    reports = client.listen(msg.CycleReport, 'cycle_report', 2 * MESSAGES)
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 2 * MESSAGES)

    def answered():
        publisher.publish(poses(0))
        return results and reports

    client.wait_for(answered, 'the first answer')
    with asking(ASKER) as (asker,):
        assert int(asker.stdout.readline()) == COUNT * (COUNT - 1) // 2
        start = time.monotonic()
        for step in range(1, MESSAGES + 1):
            publisher.publish(poses(step))
            client.spin_until(start + step / RATE)
        client.wait_for(lambda: results[-1].header.stamp.sec == MESSAGES, 'the last answer')
        # Queries went on all the while, beside the stream.
        assert int(asker.stdout.readline()) == COUNT * (COUNT - 1) // 2
    steps = [m.header.stamp.sec for m in results if m.header.stamp.sec > 0]
    assert steps == list(range(1, MESSAGES + 1))
    client.wait_for(lambda: reports[-1].header.stamp.sec == MESSAGES, 'the last report')
    cycles = [r.cycle for r in reports if r.header.stamp.sec > 0]
    assert cycles == list(range(cycles[0], cycles[0] + MESSAGES))


def test_what_if_leaves_the_live_scene_bit_for_bit(client):
    results = client.listen(msg.SignedDistancePairs, 'signed_distances')
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)
    live = poses(7777)

    def answer(count):
        publisher.publish(live)
        return [m for m in results if m.header.stamp.sec == 7777][count:]

    before = client.wait_for(lambda: answer(0), 'the live answer')[0]
    saved = accepted(client.call(srv.SaveScene, 'save_scene')).text
    seen = len([m for m in results if m.header.stamp.sec == 7777])
    what_if = client.call(
        srv.ComputeSignedDistancePairwise,
        'compute_signed_distance_pairwise',
        max_distance=0.1,
        poses=msg.FramePoses(
            frame_names=FRAMES[:500], poses=array.array('d', positions(-400)[:500].tobytes())
        ),
    )
    assert list(accepted(what_if).result.distance) != list(before.distance)
    assert accepted(client.call(srv.SaveScene, 'save_scene')).text == saved
    after = client.wait_for(lambda: answer(seen), 'the live answer again')[-1]
    for name in ('id_a', 'id_b', 'p_aca', 'p_bcb', 'nhat_ba_w', 'distance', 'error_bound'):
        assert getattr(after, name) == getattr(before, name)


def test_changes_and_queries_at_once(client):
    """The scene changes under the queries: each is answered for one moment of it."""
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)
    with asking(BUSY, 2) as busy:
        first = [process.stdout.readline() for process in busy]
        accepted(client.call(srv.RegisterSource, 'register_source', name='more'))
        for k in range(12):
            publisher.publish(poses(k))
            ball = add_sphere(client, 'more', f'f{k}', 0.1)
            apply = {'declaration': exclude(f'more::f{k}/ball', f's::f{k}/g'), 'lease': 60.0}
            answer = client.call(srv.ApplyTransientFilter, 'apply_transient_filter', **apply)
            removal = {'filter_id': accepted(answer).filter_id}
            if k % 2:
                accepted(client.call(srv.RemoveGeometry, 'remove_geometry', geometry=f'#{ball}'))
            assert accepted(client.call(srv.RemoveFilter, 'remove_filter', **removal)).removed
            if k % 2:  # however slow the machine is, each is answered between changes
                first += [process.stdout.readline() for process in busy]
        for process in busy:
            process.send_signal(signal.SIGINT)
        outputs = [process.stdout.read().splitlines() for process in busy]
    assert first == ['answered\n'] * len(first)
    assert {line for lines in outputs for line in lines} <= {'answered'}
