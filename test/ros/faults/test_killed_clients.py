"""Clients killed in the middle of large answers: the node goes on, and its scene is what it was.

A short round of what ``bench.ros.killed_clients`` does for long.
"""

import itertools

import pytest
from drake_geom_msgs import srv
from ros.harness import Process, start_node, without_shared_memory
from ros.scene_calls import accepted

from bench.ros.killed_clients import scene_file

pytestmark = [pytest.mark.topics, pytest.mark.everything]

BODIES = 300
PAIRS = BODIES * (BODIES - 1) // 2  # an answer of 4.8 MB
ROUNDS = 3  # in which most of the clients found the node
CLIENTS, LIFE = 4, 0.5  # [s] of a client from its request on, at most


@pytest.fixture
def node(tmp_path, monkeypatch):
    without_shared_memory(monkeypatch)
    process = start_node(tmp_path / 'log', scene_file=scene_file(tmp_path, BODIES))
    yield process
    assert process.end() == 0, process.output()


def test_the_node_answers_and_keeps_its_scene(node, lone_client, tmp_path):
    client = lone_client

    def saved():
        return accepted(client.call(srv.SaveScene, 'save_scene')).text

    before = saved()
    rounds = 0
    for seed in itertools.count():
        arguments = ('--clients', str(CLIENTS), '--seed', str(seed), '--life', str(LIFE))
        dying = Process(tmp_path / f'dying_{seed}', 'bench.ros.dying', *arguments)
        client.wait_for(lambda d=dying: d.popen.poll() is not None, 'the clients to die')
        assert dying.end() == 0, dying.output()
        accepted(client.call(srv.HasCollisions, 'has_collisions'))
        # One that has not found the node by then was killed all the same, beside those that ask.
        rounds += int(dying.output().split()[0]) > CLIENTS // 2
        if rounds == ROUNDS:
            break
        assert seed < 3 * ROUNDS, dying.output()
    assert saved() == before
    asked = srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise'
    assert len(accepted(client.call(*asked)).result.distance) == PAIRS
    assert 'Traceback' not in node.output()
