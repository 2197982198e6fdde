"""The examples of OMPL: a way by a node's answers, and ways by proofs and by samples."""

import re

import pytest
from ros.harness import run_python, start_node

from examples.test_examples import EXAMPLES, output

pytest.importorskip('ompl', reason='the extra `examples` of the package is not installed')


@pytest.mark.parametrize('edges', ['proofs', 'samples'])
def test_a_node_tells_which_edges_are_free(tmp_path, edges):
    node = start_node(tmp_path / 'log', scene_file='examples/wires.yaml')
    try:
        done = run_python('examples/plan_an_arm.py', '--edges', edges)
    finally:
        assert node.end() == 0, node.output()
    assert done.returncode == 0, done.stderr + done.stdout + node.output()
    waypoints = re.search(r'(\d+) waypoints, (NOT )?free at a tenth of the step', done.stdout)
    touching, count = re.search(r'(\d+) of (\d+) edges are in contact', done.stdout).groups()
    assert int(waypoints.group(1)) - 1 == int(count) >= 1
    if edges == 'proofs':
        assert not waypoints.group(2)
        assert touching == '0'


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
