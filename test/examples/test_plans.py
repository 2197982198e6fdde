"""The examples of OMPL: proofs find ways without a contact, and samples find ways."""

import re

import pytest
from ros.harness import environment, start_node

from examples.test_examples import EXAMPLES, output

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


@pytest.fixture
def node(tmp_path):
    node = start_node(tmp_path / 'log', scene_file=EXAMPLES / 'wires.yaml')
    yield node
    assert node.end() == 0, node.output()


@pytest.mark.usefixtures('node')
def test_a_node_proves_a_way_past_wires(monkeypatch):
    for name, value in environment().items():  # of the node's domain, and its messages
        monkeypatch.setenv(name, value)
    said = output(EXAMPLES / 'plan_an_arm.py', '--edges', 'proofs', '--seed', '2')
    touching, edges = re.search(r'(\d+) of (\d+) edges are in contact', said).groups()
    assert touching == '0'
    assert int(edges) > 0
