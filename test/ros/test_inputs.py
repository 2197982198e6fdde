"""Simulated time on the real middleware, and TF where its messages are missing."""

import itertools
import subprocess
import sys

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from ros.harness import environment, start_node
from ros.scene_calls import accepted, add_pair, exclude, poses
from rosgraph_msgs.msg import Clock


def values(diagnostics):
    return {v.key: v.value for v in diagnostics[-1].status[0].values} if diagnostics else {}


def test_tf_without_its_messages_is_refused_at_the_start(tmp_path):
    """What a set-up without tf2_msgs says; with it the module is hidden."""
    code = (
        'import importlib.util as u, sys; find = u.find_spec; '
        "u.find_spec = lambda name, *a: None if name == 'tf2_msgs' else find(name, *a); "
        'from drake_geom_ros.ros.scene_graph_node import main; '
        "sys.exit(main(['--ros-args', '-p', 'use_tf:=true']))"
    )
    done = subprocess.run(
        [sys.executable, '-c', code],
        env=environment(),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert 'tf2_msgs' in done.stderr


def test_simulated_time_rules_ages_and_leases(tmp_path, lone_client):
    node = start_node(tmp_path / 'log', max_distance=1.0, stale_after=5.0, use_sim_time=True)
    client = lone_client
    try:
        clock = client.node.create_publisher(Clock, '/clock', 10)
        small, _ = add_pair(client, 'simulated')
        results = client.listen(msg.SignedDistancePairs, 'signed_distances')
        diagnostics = client.listen(DiagnosticArray, '/diagnostics')
        publisher = client.publisher(msg.FramePoses, 'frame_poses')

        def told(seconds):
            """Whether the node knows the time: only its diagnostics show the clock itself."""
            clock.publish(Clock(clock=Time(sec=seconds)))
            return diagnostics and diagnostics[-1].header.stamp.sec == seconds

        def result():
            kind = srv.ComputeSignedDistancePairwise
            return accepted(client.call(kind, 'compute_signed_distance_pairwise')).result

        def posed():
            """Whether the node holds the very poses sent last, so that none is on its way."""
            stamp = next(stamps)
            publisher.publish(poses(['a', 'b'], [(0, 0, 0), (0.5, 0, 0)], stamp=stamp))
            return result().header.stamp.sec == stamp

        stamps = itertools.count(1)
        client.wait_for(lambda: told(100), 'a node that knows that it is 100 s')
        client.wait_for(posed, 'poses')
        assert result().oldest_pose_age == 0.0
        client.wait_for(lambda: told(103), 'a node that knows that it is 103 s')
        assert result().oldest_pose_age == 3.0
        assert results[0].id_a[0] == small
        lease = {'declaration': exclude('a/ball', 'b/ball'), 'lease': 10.0}
        filter_id = accepted(
            client.call(srv.ApplyTransientFilter, 'apply_transient_filter', **lease)
        ).filter_id

        def active(seconds):
            clock.publish(Clock(clock=Time(sec=seconds)))
            state = accepted(client.call(srv.GetFilters, 'get_filters'))
            return filter_id in state.active_filter_ids

        for _ in range(5):
            assert active(112)
        client.wait_for(lambda: not active(114), 'the lease to end in simulated time')
        stale = 'simulated::a, simulated::b'
        client.wait_for(
            lambda: values(diagnostics).get('names of stale frames') == stale, 'stale frames'
        )
        # Time goes back, as in a simulation that is reset: ages do not become negative.
        client.wait_for(lambda: told(50), 'a node that knows that it is 50 s')
        assert result().oldest_pose_age == 0.0
    finally:
        assert node.end() == 0, node.output()
