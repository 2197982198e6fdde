"""Two nodes of one full name: both say so, in the log and in /diagnostics, until one is gone."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from drake_geom_msgs import srv
from ros.harness import start_node
from ros.scene_calls import accepted

pytestmark = pytest.mark.topics

NAME = '/cell/scene_graph'
TOLD = f'this node is not the only one called {NAME}: 1 more in the graph'


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a node of one name and of a namespace."""
    started = []

    def start(namespace):
        log = tmp_path / f'log_{len(started)}'
        started.append(start_node(log, namespace=namespace, max_distance=0.5))
        return started[-1]

    yield start
    for process in started:
        assert process.end() == 0, process.output()


def test_both_tell_until_one_is_gone(start, lone_client):
    client = lone_client
    messages = client.listen(DiagnosticArray, '/diagnostics')

    def latest():
        found = [s for m in messages for s in m.status if s.name == NAME]
        return found[-1] if found else None

    first = start('/cell')
    client.wait_for(latest, 'diagnostics')
    assert latest().level == DiagnosticStatus.OK
    assert TOLD not in first.output()
    second = start('/cell')
    client.wait_for(lambda: TOLD in first.output(), 'the first one to tell')
    client.wait_for(lambda: TOLD in second.output(), 'the second one to tell')
    for process in (first, second):
        assert '[ERROR]' in next(line for line in process.output().splitlines() if TOLD in line)
        assert process.output().count(TOLD) == 1
    client.wait_for(lambda: TOLD in latest().message, 'the diagnostics to tell')
    assert latest().level == DiagnosticStatus.WARN
    assert '__ns:=' in latest().message
    # Both serve: whose answer is the right one no node can know.
    client.server = NAME
    accepted(client.call(srv.HasCollisions, 'has_collisions'))
    assert second.end() == 0, second.output()
    client.wait_for(
        lambda: 'is the only one called' in first.output(), 'the first one to be alone'
    )
    client.wait_for(lambda: latest().level == DiagnosticStatus.OK, 'the warning to end')


def test_a_node_of_that_name_in_another_namespace_is_none(start, lone_client):
    messages = lone_client.listen(DiagnosticArray, '/diagnostics')
    nodes = [start('/cell'), start('/cell/inner')]

    def told():
        return {s.name for m in messages for s in m.status}

    lone_client.wait_for(lambda: {NAME, '/cell/inner/scene_graph'} <= told(), 'both')
    messages.clear()
    lone_client.wait_for(lambda: {NAME, '/cell/inner/scene_graph'} <= told(), 'both again')
    assert all(s.level == DiagnosticStatus.OK for m in messages for s in m.status)
    assert all('not the only one' not in node.output() for node in nodes)
