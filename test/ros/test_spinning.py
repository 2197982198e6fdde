"""Callback groups in threads of their own: none waits for another, and none fails unseen."""

import os
import signal
import subprocess
import sys
import threading
from collections import Counter
from functools import partial

import pytest
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.event_handler import EventHandler
from rclpy.executors import SingleThreadedExecutor
from rclpy.waitable import Waitable
from ros.harness import environment, run_python
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from drake_geom_ros.ros import group_waiting, spinning
from drake_geom_ros.ros.spinning import StopSignals, spin_until_stopped

pytestmark = pytest.mark.topics


@pytest.fixture(params=['a wait set that is kept', "rclpy's way"])
def node(monkeypatch, request):
    if request.param == "rclpy's way":
        monkeypatch.setattr(spinning, 'can_keep_wait_sets', lambda: False)
    else:
        assert spinning.can_keep_wait_sets(), 'rclpy has changed: today groups cost more'
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


def test_threads_in_the_background_give_way(node):
    stream, states = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
    done, found = rclpy.Future(), {}

    def called(name):
        found[name] = os.getpriority(os.PRIO_PROCESS, 0)  # of this thread
        if len(found) == 3:
            done.set_result(None)

    for name, group in (('states', states), ('stream', stream), ('main', None)):
        node.create_timer(0.01, lambda name=name: called(name), callback_group=group)
    spin_until_stopped(node, StopSignals(), done, (stream, states), background=(states,))
    assert found['stream'] == found['main'] < found['states'] or found['main'] == 19


def test_what_fails_in_a_thread_is_raised(node):
    group = MutuallyExclusiveCallbackGroup()
    _, run = spin(node, (group,))

    def fail():
        raise ValueError('on purpose')

    node.create_timer(0.01, fail, callback_group=group)
    with pytest.raises(ValueError, match='on purpose'):
        run()


def test_what_fails_ends_nothing_where_somebody_is_told(node, monkeypatch):
    """Not even what fails before its callback, while the message is taken."""
    group = MutuallyExclusiveCallbackGroup()
    done, told, calls = rclpy.Future(), [], Counter()
    take = SingleThreadedExecutor._take_timer

    def taken(executor, timer):
        calls['taken'] += 1
        if calls['taken'] == 1:
            raise ValueError('not taken')
        return take(executor, timer)

    def fail():
        calls['made'] += 1
        if calls['made'] == 3:
            done.set_result(None)
        raise ValueError('on purpose')

    monkeypatch.setattr(SingleThreadedExecutor, '_take_timer', taken)
    node.create_timer(0.01, fail, callback_group=group)
    patience = threading.Timer(20.0, done.set_result, (None,))
    patience.start()
    spin_until_stopped(
        node, StopSignals(), done, (group,), lambda error, _: told.append(str(error))
    )
    patience.cancel()
    assert calls['made'] >= 3
    assert told[:3] == ['not taken', 'on purpose', 'on purpose']


def test_what_is_made_later_is_served_too(node):
    group = MutuallyExclusiveCallbackGroup()
    done, run = spin(node, (group,))

    def make():
        node.destroy_timer(first)
        node.create_timer(0.01, lambda: done.set_result(None), callback_group=group)

    first = node.create_timer(0.01, make)
    run()
    assert done.done()


def test_what_was_closed_is_passed_over_though_somebody_has_it_still(node):
    group = MutuallyExclusiveCallbackGroup()
    done, run = spin(node, (group,))
    closed = node.create_subscription(Empty, 'closed', lambda _: None, 1, callback_group=group)
    calls = Counter()

    def close():
        calls['made'] += 1
        if calls['made'] == 1:
            node.destroy_subscription(closed)
        elif calls['made'] == 4:
            done.set_result(None)

    node.create_timer(0.01, close, callback_group=group)
    run()
    assert calls['made'] >= 4
    assert closed is not None


def test_a_timer_that_another_one_closes_while_both_are_ready_is_no_error(node):
    group = MutuallyExclusiveCallbackGroup()
    done, told, timers = rclpy.Future(), [], {}

    def close(name):
        if told or len(timers) == 1:
            done.set_result(None)
        for other in set(timers) - {name}:
            node.destroy_timer(timers.pop(other))

    for name in ('a', 'b'):  # both are ready at once
        timers[name] = node.create_timer(0.0, partial(close, name), callback_group=group)
    spin_until_stopped(node, StopSignals(), done, (group,), lambda e, _: told.append(str(e)))
    assert told == []


def test_messages_guard_conditions_and_requests_are_served_in_a_group(node):
    group = MutuallyExclusiveCallbackGroup()
    done, run = spin(node, (group,))
    served = []

    def called(name, answer=None):
        served.append(name)
        if {'message', 'guard', 'request', 'answer'} <= set(served):
            done.set_result(None)
        return answer

    publisher = node.create_publisher(Empty, 'messages', 1)
    node.create_subscription(
        Empty, 'messages', lambda _: called('message'), 1, callback_group=group
    )
    guard = node.create_guard_condition(lambda: called('guard'), callback_group=group)
    node.create_service(
        Trigger, 'asked', lambda _, answer: called('request', answer), callback_group=group
    )
    client = node.create_client(Trigger, 'asked', callback_group=group)

    def send():
        publisher.publish(Empty())
        guard.trigger()
        if client.service_is_ready():
            client.call_async(Trigger.Request()).add_done_callback(lambda _: called('answer'))

    node.create_timer(0.01, send)
    run()
    assert done.done()


def test_a_callback_that_waits_is_an_error_in_a_thread_that_nobody_else_serves(node):
    group = MutuallyExclusiveCallbackGroup()
    done, told = rclpy.Future(), []

    async def wait():
        await rclpy.Future()

    if not spinning.can_keep_wait_sets():
        pytest.skip('rclpy goes on with it')
    node.create_timer(0.01, wait, callback_group=group)

    def failed(error, _):
        told.append(str(error))
        done.set_result(None)

    spin_until_stopped(node, StopSignals(), done, (group,), failed)
    assert 'must not await' in told[0]


def test_a_publisher_that_another_thread_closes_between_two_looks_ends_nothing(node, monkeypatch):
    """rclpy adds the events of a publisher to its wait without looking whether it is open yet."""
    done, run = spin(node, ())
    publisher = node.create_publisher(Empty, 'closed', 1)
    event = publisher.event_handlers[0]
    add, closed = EventHandler.add_to_wait_set, []

    def added(handler, wait_set):
        if handler is event:
            closed.append(node.destroy_publisher(publisher))
        add(handler, wait_set)

    monkeypatch.setattr(EventHandler, 'add_to_wait_set', added)
    node.create_timer(0.01, lambda: done.set_result(None))
    run()
    assert closed == [True]
    assert done.done()


def test_where_events_have_another_inside_no_wait_set_is_kept(monkeypatch):
    """Otherwise each event would count as one that is still being made, and nobody hear of it."""
    monkeypatch.setattr(EventHandler, '__init__', lambda self, *arguments: None)
    assert not group_waiting.can_keep_wait_sets()


def test_an_event_that_another_thread_is_making_ends_nothing(node):
    """rclpy has it in its group before it has the handle of the event."""
    group = MutuallyExclusiveCallbackGroup()
    done, run = spin(node, (group,))
    begun = EventHandler.__new__(EventHandler)
    Waitable.__init__(begun, group)
    node.create_timer(0.01, lambda: done.set_result(None), callback_group=group)
    run()
    assert done.done()


SLOW = """
import signal, sys, time
from rclpy.node import Node
from drake_geom_ros.ros.spinning import run_node

class Slow(Node):
    def __init__(self):
        super().__init__('slow')
        self.create_timer(0.0, self.work)

    def work(self):
        print('working', flush=True)
        stop = signal.getsignal(signal.SIGINT).__self__
        while not stop.received:
            time.sleep(0.01)
        print('told to stop', flush=True)
        time.sleep(float(sys.argv.pop()))
        print('done', flush=True)

sys.exit(run_node(Slow, (), []))
"""


def start_slow(seconds):
    return subprocess.Popen(
        [sys.executable, '-c', SLOW, str(seconds)],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_what_runs_when_a_signal_comes_may_finish():
    process = start_slow(1.0)
    assert process.stdout.readline() == 'working\n'
    process.send_signal(signal.SIGINT)
    assert process.communicate() == ('told to stop\ndone\n', '')
    assert process.returncode == 0


@pytest.mark.parametrize('second', [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_ends_what_takes_too_long(second):
    """So `ros2 launch` ends it: SIGTERM follows the SIGINT of Ctrl-C after 5 s."""
    process = start_slow(1000.0)
    assert process.stdout.readline() == 'working\n'
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == 'told to stop\n'  # and goes on
    process.send_signal(second)
    assert process.wait() == -second
    assert process.communicate() == ('', '')


@pytest.mark.parametrize('name', ['scene_graph_node', 'viewer.scene_viewer', 'pose_player'])
def test_help_lists_the_parameters(name):
    done = run_python('-m', f'drake_geom_ros.ros.{name}', '--help')
    assert done.returncode == 0, done.stderr
    first, *others = done.stdout.splitlines()
    assert first.startswith(f'usage: {name.rpartition(".")[2]} --ros-args ')
    wanted = 'server' if 'viewer' in name else 'scene_file'
    assert any(line.startswith(f'  {wanted} ') for line in others)


def test_arguments_that_are_none_are_refused_in_a_line():
    done = run_python('-m', 'drake_geom_ros.ros.scene_graph_node', '--rate=5')
    assert done.returncode == 2
    assert "unknown arguments '--rate=5'; only ROS arguments are accepted" in done.stderr
    refused = {
        '--ros-args -p': ['-p', 'rate:=1'],
        "'-p rate'": ['--ros-args', '-p', 'rate'],
        '--log-level loud': ['--ros-args', '--log-level', 'loud'],
    }
    code = (
        'import sys\n'
        'from drake_geom_ros.ros.scene_graph_node import main\n'
        f'for given in {list(refused.values())}:\n'
        "    sys.argv = ['scene_graph_node', *given]\n"
        '    print(main())\n'
    )
    done = run_python('-c', code)
    assert done.stdout == '2\n' * len(refused), done.stderr
    lines = [line for line in done.stderr.splitlines() if line.startswith('drake_geom_ros: ')]
    assert all(words in line for words, line in zip(refused, lines, strict=True))
    assert 'Traceback' not in done.stderr


THREADS = """
import os, signal, threading
from pathlib import Path
from drake_geom_ros.client import SceneGraphClient
from drake_geom_ros.ros.scene_graph_node import main

def of_middleware():
    names = [path.read_text() for path in Path('/proc/self/task').glob('*/comm')]
    # One that watches shared memory, where that is used, is the library's own.
    return sum(name.startswith('dds.') and 'shm.wdog' not in name for name in names)

def ask():
    try:
        with SceneGraphClient(patience=100.0) as client:
            client.scene()
            counts.append(of_middleware())
    finally:
        os.kill(os.getpid(), signal.SIGINT)

counts = []
asking = threading.Thread(target=ask)
asking.start()
counts.append(main([]))
asking.join()
counts.append(of_middleware())
print(*counts)
"""


def test_nothing_of_the_middleware_outlives_a_node_or_a_client():
    """Its threads would run into what is gone at the end of the process, which then crashes."""
    done = run_python('-c', THREADS)
    during, code, after = map(int, done.stdout.split())
    assert (during > 0, code, after) == (True, 0, 0), done.stderr
