"""Proximity rules while everything happens, and a referee: a short round of `./run soak --rules`.

That a referee notices what is wrong is tested in ``test/bench/ros/test_rule_storm.py``.
"""

import re

import pytest
from ros.harness import Process

pytestmark = [pytest.mark.processes, pytest.mark.everything]

SECONDS, PATIENCE = 24.0, 900.0  # the node may compile its kernels first


def test_no_decision_is_missing_late_or_unfounded(tmp_path):
    options = ('--rules', '--minutes', str(SECONDS / 60.0), '--seed', '5')
    storm = Process(tmp_path / 'storm', 'bench.ros.soak', *options)
    assert storm.popen.wait(PATIENCE) == 0, storm.output()
    told = storm.output()
    cycles, decisions = map(int, re.search(r'(\d+) cycles, (\d+) decisions', told).groups())
    silences, undecided = map(int, re.search(r'(\d+) times.*\n?.*?(\d+) of them', told).groups())
    assert cycles > 50, told
    assert decisions > 5, told
    assert undecided < silences / 2, told
    assert '\n0 decisions missing' in told
