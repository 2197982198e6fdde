"""The examples of OMPL: a way by a node's answers, and ways by proofs and by samples."""

import re

import pytest

from examples.test_examples import EXAMPLES, output
from ros.harness import run_python, start_node

pytest.importorskip('ompl', reason='the extra `examples` of the package is not installed')


def test_a_node_tells_which_edges_are_free(tmp_path):
    node = start_node(tmp_path / 'log', scene_file='scenes/two_pandas.yaml')
    try:
        done = run_python('examples/plan_an_arm.py', '--seconds', '60')
    finally:
        assert node.end() == 0, node.output()
    assert done.returncode == 0, done.stderr + done.stdout + node.output()
    counts = re.search(r'(\d+) calls about (\d+) states', done.stdout).groups()
    assert 0 < int(counts[0]) < int(counts[1])
    waypoints = re.search(r'(\d+) waypoints, free at a tenth of the step', done.stdout)
    assert int(waypoints.group(1)) >= 2


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
