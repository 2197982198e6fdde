"""Many callers of a service at once: all get their answer, and what gets none is counted."""

import contextlib
import re

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from drake_geom_msgs import srv
from rclpy.qos import QoSProfile
from ros.harness import PATIENCE, Client, start_node

from drake_geom_ros.client import Services

pytestmark = pytest.mark.topics

CLIENTS, CALLS = 20, 200
NOT_ANSWERED = re.compile(r'(\d+) service calls? w(?:as|ere) not answered since the last report')


def callers(client, count):
    """Return clients of has_collisions that have had an answer each."""
    name = f'{client.server}/has_collisions'
    # Each answer goes to all clients of a service; each keeps the last ones until it looks.
    profile = QoSProfile(depth=2 * CALLS)
    found = [
        client.node.create_client(srv.HasCollisions, name, qos_profile=profile)
        for _ in range(count)
    ]
    for caller in found:
        client.wait_for(caller.service_is_ready, name)
    # Before the node has found a new client its answers are lost: discovery takes a moment.
    client.wait_for(lambda: call_at_once(client, found, 2.0) == count, 'answers to all')
    return found


def call_at_once(client, found, patience):
    """Call by all, and return how many were answered within ``patience`` [s]."""
    return number_answered(calls_at_once(client, found, patience))


def calls_at_once(client, found, patience):
    futures = [caller.call_async(srv.HasCollisions.Request()) for caller in found]
    with contextlib.suppress(AssertionError):
        client.wait_for(lambda: all(f.done() for f in futures), 'answers', patience)
    return futures


def number_answered(futures):
    return sum(f.done() and f.result().success for f in futures)


def test_two_hundred_calls_at_once_are_answered(client):
    found = callers(client, CLIENTS)
    assert call_at_once(client, found * (CALLS // CLIENTS), PATIENCE) == CALLS


@pytest.fixture
def idler(client):
    """Return a client that spins only when the test says so, beside one that does."""
    client = Client(client.server)
    yield client
    client.close()


def test_an_answer_is_displaced_by_those_to_others_where_a_client_keeps_few(client, idler):
    few = idler.node.create_client(srv.HasCollisions, f'{client.server}/has_collisions')
    many = Services(idler.node, client.server)
    idler.wait_for(lambda: few.service_is_ready() and not many.missing('has_collisions'), 'both')

    def call():
        return few.call_async(srv.HasCollisions.Request()), many.send('has_collisions')

    # Until the node has found both, their answers are lost.
    idler.wait_for(lambda: all(answered(idler, future) for future in call()), 'an answer to both')
    displaced, kept = call()
    found = callers(client, 1)
    assert call_at_once(client, found * (CALLS // 2), PATIENCE) == CALLS // 2
    idler.wait_for(kept.done, 'the answer among many')
    assert not answered(idler, displaced)
    idler.wait_for(few.call_async(srv.HasCollisions.Request()).done, 'an answer to it')


def answered(client, future):
    """Return whether a call is answered within 2 s."""
    with contextlib.suppress(AssertionError):
        client.wait_for(future.done, 'an answer', 2.0)
    return future.done()


@pytest.fixture
def narrow(tmp_path):
    """Return a node with room for two calls of a service."""
    process = start_node(tmp_path / 'log', namespace='/narrow', service_depth=2)
    yield process
    assert process.end() == 0, process.output()


def test_what_is_not_answered_is_counted(narrow, lone_client):
    client = lone_client
    client.server = '/narrow/scene_graph'
    messages = client.listen(DiagnosticArray, '/diagnostics')

    def mine():
        return [s for m in messages for s in m.status if s.name == client.server]

    def counted(name):
        return int({v.key: v.value for v in mine()[-1].values}[name]) if mine() else 0

    def warned_of():
        return [int(m[1]) for s in mine() if (m := NOT_ANSWERED.search(s.message))]

    (caller,) = callers(client, 1)
    futures = calls_at_once(client, [caller] * CALLS, 1.0)
    # The number of the next request shows how many are missing before it. Its answer is the last.
    assert call_at_once(client, [caller], PATIENCE) == 1
    answered = number_answered(futures)
    assert answered < CALLS
    lost = CALLS - answered
    client.wait_for(lambda: counted('service calls not answered') == lost, f'{lost} calls counted')
    client.wait_for(lambda: counted('service calls answered') > answered, 'those answered')
    # Each message warns of those since the one before, so that a warning ends; the total stays.
    assert sum(warned_of()) == lost
    levels = {bool(NOT_ANSWERED.search(s.message)): s.level for s in mine()}
    assert levels[True] == DiagnosticStatus.WARN
    client.wait_for(lambda: mine()[-1].level == DiagnosticStatus.OK, 'the warning to end')
    assert counted('service calls not answered') == lost
    assert sum(warned_of()) == lost
