"""The map of an arm's reach: what it counts adds up, and the picture is there."""

import re

import pytest

from examples.test_examples import EXAMPLES, output

pytestmark = pytest.mark.processes

STATES = 3000


def test_it_maps_the_reach(tmp_path):
    picture = tmp_path / 'reach.png'
    said = output(EXAMPLES / 'reach_of_an_arm.py', '--states', str(STATES), '--out', picture)
    inside, states, reached, free = map(int, re.findall(r'\d+', said.split('wrote')[0]))
    assert states == STATES
    assert 0 < free < reached < inside < states
    assert picture.read_bytes().startswith(b'\x89PNG')
