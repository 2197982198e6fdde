"""The examples of OMPL: a way is found through a node, and proofs find ways without a contact."""

import re

import pytest
from ros.harness import run_python, start_node

from drake_geom_ros.client import SceneGraphClient
from examples.test_examples import EXAMPLES, output

pytest.importorskip('ompl', reason='the extra `examples` of the package is not installed')


def test_a_way_is_planned_through_a_node(tmp_path):
    scene = EXAMPLES.parent / 'scenes/two_pandas.yaml'
    process = start_node(tmp_path / 'log', scene_file=scene, use_joint_states=True)
    try:
        with SceneGraphClient(patience=250.0) as client:
            client.scene()  # what was never compiled takes a node minutes
        done = run_python(EXAMPLES / 'plan_an_arm.py')
    finally:
        code = process.end()
    assert (code, done.returncode) == (0, 0), process.output() + done.stderr
    said = done.stdout
    calls, states, waypoints = map(int, re.findall(r'\d+', said)[:3])
    assert 0 < calls < states
    assert waypoints >= 2
    assert ' free at a tenth of the step' in said
    assert 'NOT' not in said


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
