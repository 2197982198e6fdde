"""The example of Ruckig: a way that is clear before it runs, and a box that comes into it."""

import re

import pytest

from examples.test_examples import EXAMPLES, output

pytestmark = pytest.mark.processes

pytest.importorskip('ruckig', reason='the extra `examples` of the package is not installed')


def test_the_rest_of_a_way_is_not_clear_before_the_box_is_in_it():
    said = output(EXAMPLES / 'check_before_execute.py')
    assert 'before it runs: clear' in said
    seen = float(re.search(r'at ([\d.]+) s the rest is not clear', said).group(1))
    near = float(re.search(r'at ([\d.]+) s it is nearer', said).group(1))
    assert 0.0 < seen < near
    assert 'things::box/box' in said


@pytest.mark.topics
def test_a_node_watches_it_as_well(tmp_path):
    harness = pytest.importorskip('ros.harness')
    node = harness.start_node(
        tmp_path / 'log', name='watching_example', use_joint_states=True, stale_after=5.0
    )
    try:
        said = output(EXAMPLES / 'check_before_execute.py', '--server', '/watching_example')
    finally:
        assert node.end() == 0, node.output()
    assert 'before it runs: clear' in said
    seen = float(re.search(r'at ([\d.]+) s the rest is not clear: contact of', said).group(1))
    near = float(re.search(r'at ([\d.]+) s it is nearer', said).group(1))
    assert 0.0 < seen < near
    assert 'things::box/box' in said
