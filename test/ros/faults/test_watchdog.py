"""A node that is stuck says where, and ends when it may; one that takes its time is left alone."""

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from drake_geom_msgs import srv
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from ros.harness import Process
from ros.scene_calls import accepted

pytestmark = pytest.mark.topics

# Longer than a busy machine keeps a thread from running that is not stuck.
LIMIT = 5.0  # [s]
SAID = 'Timeout (0:00:05)!'
# A call is lost where the node does not know its client yet, which the client cannot know.
AGAIN = 4 * LIMIT  # [s]


@pytest.fixture
def start(tmp_path, monkeypatch, lone_client):
    """Return a function that starts the node with parameters."""
    paths = [str(Path(__file__).parent), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    lone_client.server = '/stuck/scene_graph'
    started = []

    def begin(*parameters):
        arguments = ['--ros-args', '-r', '__ns:=/stuck', '-p', f'watchdog:={LIMIT}']
        for parameter in parameters:
            arguments += ['-p', parameter]
        started.append(Process(tmp_path / 'log', 'stuck_node', *arguments))
        return started[0]

    yield begin
    started[0].end(signal.SIGKILL)


def register(client, name):
    """Register a source, which shows that the node answers; it is watched only once it is active.

    Until then it may take as long as it likes, and services answer a little before.
    """
    accepted(client.call(srv.RegisterSource, 'register_source', name=name))
    client.wait_for(
        lambda: client.call(GetState, 'get_state').current_state.id == State.PRIMARY_STATE_ACTIVE,
        'an active node',
    )


def ask_until(fact, client, kind, name):
    """Ask what will not be answered, again where the call seems to be lost, until a fact."""
    caller = client.node.create_client(kind, f'{client.server}/{name}')
    client.wait_for(caller.service_is_ready, name)
    asked = -math.inf

    def it_is_so():
        nonlocal asked
        if time.monotonic() - asked > AGAIN:
            asked = time.monotonic()
            caller.call_async(kind.Request())
        return fact()

    client.wait_for(it_is_so, f'what follows a call of {name}')


def test_a_thread_that_waits_is_told_of_and_the_others_go_on(start, lone_client):
    node = start()
    register(lone_client, 'before')
    ask_until(lambda: SAID in node.output(), lone_client, srv.HasCollisions, 'has_collisions')
    assert 'has_collisions' in node.output() or 'stuck_node.py' in node.output()
    accepted(lone_client.call(srv.RegisterSource, 'register_source', name='after'))
    assert node.popen.poll() is None


@pytest.mark.parametrize(
    ('kind', 'name'),
    [(srv.HasCollisions, 'has_collisions'), (srv.GetFilters, 'get_filters')],
    ids=['one thread', 'all threads'],
)
def test_the_process_ends_where_it_may(start, lone_client, kind, name):
    node = start('watchdog_exits:=true')
    register(lone_client, 'before')
    ask_until(lambda: node.popen.poll() is not None, lone_client, kind, name)
    assert node.popen.returncode == 1
    assert SAID in node.output()
    assert 'stuck_node.py' in node.output()


BUSY = """
import os, sys, threading
from drake_geom_ros.live.watchdog import Watchdog

def descend(depth):
    return sum(x for x in range(depth % 7)) + (descend(depth - 1) if depth else 0)

def work():
    while True:
        descend(50)

sys.setswitchinterval(1e-4)
for _ in range(3):
    threading.Thread(target=work, daemon=True).start()
Watchdog(0.05, exits=False).feed()
sys.stdin.read()
os._exit(0)
"""


def test_threads_that_run_are_told_of_without_harm():
    pipes = dict.fromkeys(('stdin', 'stderr'), subprocess.PIPE)
    with subprocess.Popen([sys.executable, '-c', BUSY], **pipes) as busy:
        reports = (line for line in busy.stderr if b'Timeout (0:00:00.05' in line)
        assert [bool(next(reports, None)) for _ in range(2)] == [True, True]
        busy.communicate()
    assert busy.returncode == 0
