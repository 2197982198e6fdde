"""The examples of OMPL: ways that are proved touch nothing, and samples find ways."""

import re

import pytest
from ros.harness import environment, start_node, wait_until_ready

from examples.test_examples import EXAMPLES, output

pytestmark = pytest.mark.processes

pytest.importorskip('ompl', reason='the extra `examples` of the package is not installed')


def test_ways_that_are_proved_touch_nothing():
    said = output(EXAMPLES / 'plan_with_proof.py', '--runs', '3')
    counts = re.findall(
        r'(\w+): (\d+) of 3 found.*; (\d+) of (\d+) edges in contact, (\d+) nearer', said
    )
    assert [name for name, *_ in counts] == ['samples', 'proofs']
    for _, found, _, edges, _ in counts:
        assert int(found) > 0
        assert int(edges) > 0
    assert counts[1][2] == counts[1][4] == '0'


@pytest.mark.topics
def test_a_node_proves_a_way_past_wires(tmp_path, monkeypatch, lone_client):
    for name, value in environment().items():  # of the node's domain, and its messages
        monkeypatch.setenv(name, value)
    node = start_node(tmp_path / 'log', scene_file=EXAMPLES / 'wires.yaml')
    try:
        wait_until_ready(lone_client)
        for edges in ('proofs', 'samples', 'discrete'):
            said = output(EXAMPLES / 'plan_an_arm.py', '--edges', edges, '--seed', '2')
            waypoints, kind = re.search(r'(\d+) waypoints, (.*) at a tenth', said).groups()
            touching, count = re.search(r'(\d+) of (\d+) edges are in contact', said).groups()
            assert int(waypoints) == int(count) + 1 > 1
            if edges == 'proofs':
                assert (kind, touching) == ('free', '0')
    finally:
        assert node.end() == 0, node.output()
