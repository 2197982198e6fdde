"""Simulated time that never comes: no cycle runs, and the node says why."""

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from drake_geom_msgs import msg
from ros.harness import start_node
from rosgraph_msgs.msg import Clock

pytestmark = pytest.mark.topics

NAME = '/timeless/scene_graph'


@pytest.fixture
def node(tmp_path):
    process = start_node(tmp_path / 'log', namespace='/timeless', use_sim_time=True, rate=50.0)
    yield process
    assert process.end() == 0, process.output()


def test_a_missing_clock_is_told_until_it_comes(node, lone_client):
    client = lone_client
    client.server = NAME
    diagnostics = client.listen(DiagnosticArray, '/diagnostics')
    reports = client.listen(msg.CycleReport, 'cycle_report')

    def latest():
        own = [s for m in diagnostics for s in m.status if s.name == NAME]
        return own[-1] if own else DiagnosticStatus()

    def value(key):
        return next((pair.value for pair in latest().values if pair.key == key), '')

    client.wait_for(lambda: '/clock' in latest().message, 'the warning in diagnostics')
    assert latest().level == DiagnosticStatus.WARN
    client.wait_for(lambda: 'no message of /clock' in node.output(), 'the line in the log')
    assert node.output().count('no message of /clock') == 1
    assert not reports
    clock = client.node.create_publisher(Clock, '/clock', 10)
    ticks = Clock()

    def ticking():
        ticks.clock.sec += 1
        clock.publish(ticks)
        return reports and latest().message and '/clock' not in latest().message

    client.wait_for(ticking, 'cycles')
    assert latest().level == DiagnosticStatus.OK
    before = len(reports)
    clock.publish(Clock(clock=Time(sec=-5)))  # no time of ROS: it begins at 0
    client.wait_for(lambda: '/clock: ' in value('latest refusal'), 'the refusal')
    assert 'must not be negative; the node keeps the time that it had' in value('latest refusal')
    assert 'internal error' not in node.output()
    client.wait_for(lambda: ticking() and len(reports) > before, 'cycles after it')
