"""Eight clients register, filter and ask at once beside a stream: every answer is as expected."""

import time

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import LATCHED, ROOT, Process, start_node
from ros.scene_calls import accepted

from bench.ros.mix import MixedClient, Tally, open_services

pytestmark = [pytest.mark.topics, pytest.mark.everything]

SCENE = ROOT / 'scenes/minimal.yaml'
SECONDS = 8.0
CYCLES = 400
# No report is lost while a busy machine does not let the client read.
DEEP = {'qos_overrides./scene_graph/cycle_report.publisher.depth': 10_000}


@pytest.fixture
def node(tmp_path):
    node = start_node(tmp_path / 'node', scene_file=SCENE, max_distance=1.0, **DEEP)
    player = Process(
        tmp_path / 'player',
        ROOT / 'scripts/pose_player',
        *('--ros-args', '-p', f'scene_file:={SCENE}', '-p', 'rate:=100.0'),
    )
    yield node
    player.end()
    assert node.end() == 0, node.output()


def test_nothing_is_lost_or_half_applied(node, lone_client):
    scenes = lone_client.listen(msg.Scene, 'scene', LATCHED)
    reports = lone_client.listen(msg.CycleReport, 'cycle_report', 10_000)
    lone_client.wait_for(lambda: scenes and reports, 'the node')
    services, tally = open_services(lone_client.node, lone_client.server), Tally()
    clients = [MixedClient(services, f'client_{k}', seed=k, tally=tally) for k in range(8)]

    def ticked():
        for client in clients:
            client.tick()
        return True

    end = time.monotonic() + SECONDS

    def enough():
        """Whether all was done often enough, however long a busy machine takes."""
        return (
            time.monotonic() > end
            and all(client.ready for client in clients)
            and tally.calls.total() > 200
            and len(tally.calls) > 20
            and tally.refusals.total() > 10
            and len(reports) > CYCLES
        )

    lone_client.wait_for(lambda: ticked() and enough(), 'enough of all')
    for client in clients:
        client.stop()
    lone_client.wait_for(
        lambda: ticked() and all(client.finished for client in clients), 'the last answers'
    )
    assert tally.problems == []
    # What the clients registered is gone but their sources and frames; cycles went on, none twice.
    lone_client.wait_for(
        lambda: [g.name for g in scenes[-1].geometries] == ['floor', 'post', 'ball'],
        'the scene of the beginning',
    )
    state = lone_client.wait_for(
        lambda: (
            (s := accepted(lone_client.call(srv.GetFilters, 'get_filters')))
            and not s.active_filter_ids
            and s
        ),
        'the last lease to run out',
    )
    assert state.filtered_pairs == 0
    cycles = [report.cycle for report in reports]
    assert cycles == list(range(cycles[0], cycles[0] + len(cycles)))
    assert 'Traceback' not in node.output()
    assert 'internal error' not in node.output()
