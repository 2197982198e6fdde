"""Callback groups in threads of their own: none waits for another, and none fails unseen."""

import threading

import pytest
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from ros.harness import environment

from drake_geom_ros.ros.spinning import StopSignals, spin_until_stopped


@pytest.fixture
def node(monkeypatch):
    for name in ('ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_DOMAIN_ID'):
        monkeypatch.setenv(name, environment()[name])
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node('spinning', context=context)
    yield node
    node.destroy_node()
    context.try_shutdown()


def spin(node, groups):
    """Spin until the future that is returned beside the spinner is done."""
    done = rclpy.Future()
    return done, lambda: spin_until_stopped(node, StopSignals(), done, groups)


def test_a_group_has_a_thread_of_its_own_and_blocks_nobody(node):
    stream, slow = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
    done, run = spin(node, (stream, slow))
    threads = {}
    released = threading.Event()

    def called(name):
        threads[name] = threading.current_thread()
        # The slow one waits for the other two: in one thread none would come.
        if name == 'slow':
            released.wait(20.0)
        elif {'stream', 'main'} <= set(threads):
            released.set()
        if released.is_set() and len(threads) == 3:
            done.set_result(None)

    for name, group in (('slow', slow), ('stream', stream), ('main', None)):
        node.create_timer(0.01, lambda name=name: called(name), callback_group=group)
    run()
    assert released.is_set()
    assert threads['main'] is threading.main_thread()
    assert len(set(threads.values())) == 3


def test_what_fails_in_a_thread_is_raised(node):
    group = MutuallyExclusiveCallbackGroup()
    _, run = spin(node, (group,))

    def fail():
        raise ValueError('on purpose')

    node.create_timer(0.01, fail, callback_group=group)
    with pytest.raises(ValueError, match='on purpose'):
        run()


def test_what_is_made_later_is_served_too(node):
    group = MutuallyExclusiveCallbackGroup()
    done, run = spin(node, (group,))

    def make():
        node.destroy_timer(first)
        node.create_timer(0.01, lambda: done.set_result(None), callback_group=group)

    first = node.create_timer(0.01, make)
    run()
    assert done.done()
