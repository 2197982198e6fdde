"""What a ported script asks is answered as pydrake does; the answers are recorded."""

import importlib.util
from pathlib import Path

import pytest
from ported.answers import answer, examples, of_pydrake

pytestmark = pytest.mark.processes

ALIKE = Path(__file__).with_name('alike.yaml')
EXAMPLES = examples(ALIKE, 'alike')


@pytest.mark.parametrize('example', EXAMPLES, ids=lambda e: e['code'].splitlines()[-1][:40])
def test_ours_answers_so(example):
    assert answer(example['code'], 'drake_geom_ros') == example['answer']


@pytest.mark.skipif(importlib.util.find_spec('pydrake') is None, reason='no pydrake')
def test_pydrake_answers_so():
    assert of_pydrake(ALIKE, 'alike') == {e['code']: e['answer'] for e in EXAMPLES}
