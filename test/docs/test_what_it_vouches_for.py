"""docs/what_it_vouches_for.md: the tests that it names are there, and its rule stops."""

import math
import re
from types import SimpleNamespace as Some

import numpy as np
import pytest
from conventions.source_tree import ROOT
from every import report

TEXT = (ROOT / 'docs/what_it_vouches_for.md').read_text()
NAMED = re.findall(r'`(test/[\w/]+\.py)(?:::(\w+))?`', TEXT)
CLAIMS = TEXT.partition('## What it vouches for')[2].partition('## What it cannot')[0]


def is_there(file, name):
    """Return whether a test file is there, and in it the test of a name, or any."""
    path = ROOT / file
    return path.exists() and f'def {name}' in path.read_text()


def test_a_test_that_is_named_is_there():
    assert len(NAMED) > 20
    report(f'{file}::{name}' for file, name in NAMED if not is_there(file, name))


def test_each_claim_names_its_test():
    rows = re.findall(r'^\| (?!claim|---).+\|$', CLAIMS, re.M)
    assert len(rows) >= 8
    assert [row for row in rows if '`test/' not in row] == []


@pytest.mark.parametrize(
    ('age', 'heard', 'lower_bounds', 'stops'),
    [
        (0.1, 9.9, [0.06, 1.0], False),
        (0.1, 9.9, [], False),
        (0.1, 9.9, [1.0, 0.04], True),
        (0.1, 9.5, [1.0], True),
        (0.5, 9.9, [1.0], True),
        (math.inf, 9.9, [1.0], True),
        (math.nan, 9.9, [1.0], True),
    ],
)
def test_the_rule_that_is_shown_stops_when_it_must(age, heard, lower_bounds, stops):
    (code,) = re.findall(r'^```python\n(.*?)^```$', TEXT, re.S | re.M)
    names = {}
    exec(compile(code, 'what_it_vouches_for.md', 'exec'), names)
    distances = Some(oldest_pose_age=age, lower_bound=np.array(lower_bounds))
    assert names['must_stop'](distances, heard, 10.0) is stops
