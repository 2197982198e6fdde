"""The example of OMPL: proofs find ways without a contact, and samples find ways."""

import re

import pytest

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
