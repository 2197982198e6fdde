"""Simulated time on the real middleware, and TF where its messages are missing."""

import itertools
import math

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from ros.harness import LATCHED, run_python, start_node
from ros.scene_calls import accepted, add_pair, exclude, poses
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

pytestmark = pytest.mark.topics


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
    done = run_python('-c', code)
    assert done.returncode == 2
    assert 'tf2_msgs' in done.stderr


def test_simulated_time_rules_stamps_and_steady_time_leases(tmp_path, lone_client):
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

        def answer():
            kind = srv.ComputeSignedDistancePairwise
            return accepted(client.call(kind, 'compute_signed_distance_pairwise'))

        def age():
            return answer().result.oldest_pose_age

        def posed():
            """Whether the node holds the very poses sent last, so that none is on its way."""
            message = poses(['a', 'b'], [(0, 0, 0), (0.5, 0, 0)])
            message.header.stamp = Time(sec=seconds_now[-1], nanosec=next(counted))
            publisher.publish(message)
            return answer().result.header.stamp == message.header.stamp

        counted, seconds_now = itertools.count(1), [100]
        client.wait_for(lambda: told(100), 'a node that knows that it is 100 s')
        client.wait_for(posed, 'poses')
        assert age() < 50.0
        client.wait_for(lambda: results and list(results[-1].id_a) == [small], 'the pair')
        client.wait_for(lambda: told(150), 'a node that knows that it is 150 s')
        assert 49.9 <= age() < 100.0
        seconds_now.append(150)
        stale = 'simulated::a, simulated::b'
        client.wait_for(
            lambda: values(diagnostics).get('names of stale frames') == stale, 'stale frames'
        )
        # Simulated time rests, and the lease ends all the same.
        lease = {'declaration': exclude('a/ball', 'b/ball'), 'lease': 1.0}
        accepted(client.call(srv.ApplyTransientFilter, 'apply_transient_filter', **lease))

        def active():
            return list(accepted(client.call(srv.GetFilters, 'get_filters')).active_filter_ids)

        client.wait_for(lambda: not active(), 'the lease to end in steady time')
        # Poses fall silent while it rests, and are stale all the same.
        client.wait_for(
            lambda: posed() and values(diagnostics).get('stale frames') == '0', 'fresh poses'
        )
        client.wait_for(
            lambda: values(diagnostics).get('names of stale frames') == stale, 'stale frames'
        )
        # Time goes back, as in a simulation that is reset: poses of before have no age.
        client.wait_for(lambda: told(50), 'a node that knows that it is 50 s')
        assert age() == math.inf
        unknown = 'the poses of 2 frames are of unknown age'
        assert unknown in answer().message
        client.wait_for(lambda: unknown in diagnostics[-1].status[0].message, 'a warning')
        assert values(diagnostics)['jumps of the clock'] == '1'
        jumped = "the node's time jumped by -100.000 s: ages of poses are unknown"
        assert node.output().count(jumped) == 1
        seconds_now.append(50)
        client.wait_for(posed, 'poses of the new time')
        assert age() < 50.0
        assert answer().message == ''
    finally:
        assert node.end() == 0, node.output()


ARM = (
    '<robot name="arm">'
    + ''.join(
        f'<link name="{name}"><collision><geometry><sphere radius="1"/></geometry></collision>'
        '</link>'
        for name in ('base', 'hand')
    )
    + '</robot>'
)
SRDF = '<robot name="arm"><disable_collisions link1="base" link2="hand" reason="Never"/></robot>'


def test_the_srdf_of_a_robot_comes_by_topic(tmp_path, lone_client):
    node = start_node(tmp_path / 'log')
    client = lone_client
    try:
        for topic, text in (('robot_description_semantic', SRDF), ('robot_description', ARM)):
            client.node.create_publisher(String, f'/{topic}', LATCHED).publish(String(data=text))
        done = "robot 'arm' added: 2 links, 2 shapes"
        client.wait_for(lambda: done in node.output(), 'the robot')
        pair = {'geometry_a': 'base/collision_0', 'geometry_b': 'hand/collision_0'}

        def left_out():
            return client.call(srv.ExplainFilter, 'explain_filter', **pair).filtered

        client.wait_for(left_out, 'the filter of the SRDF')
    finally:
        assert node.end() == 0, node.output()
