"""docs/parameters.md has every parameter of the node and of the programs around it."""

import re
import runpy

import pytest
import yaml
from conventions.source_tree import ROOT

GENERATOR = runpy.run_path(str(ROOT / 'docs/generate_parameters.py'))


def test_the_page_is_current():
    assert (ROOT / 'docs/parameters.md').read_text() == GENERATOR['page'](), (
        'run: python docs/generate_parameters.py'
    )


def test_it_has_each_parameter_of_the_node_once():
    text = GENERATOR['page']().partition('## The program')[0]
    settings = yaml.safe_load(GENERATOR['SETTINGS'].read_text())['/**/scene_graph']
    listed = re.findall(r'^\| `(\w+)` \|', text, re.M)
    assert sorted(listed) == sorted(settings['ros__parameters'])


def test_a_line_without_a_comment_is_seen(tmp_path, monkeypatch):
    settings = tmp_path / 'settings.yaml'
    settings.write_text('/**/scene_graph:\n  ros__parameters:\n    rate: 0.0\n')
    monkeypatch.setitem(GENERATOR['page'].__globals__, 'SETTINGS', settings)
    with pytest.raises(ValueError, match='rate'):
        GENERATOR['page']()
