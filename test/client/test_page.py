"""docs/client.md: its script prints what it says, and its names are there."""

import re

import pytest
from conventions.source_tree import ROOT
from ros.harness import run_python, start_node, wait_until_ready

from drake_geom_ros import client

pytestmark = pytest.mark.topics

TEXT = (ROOT / 'docs/client.md').read_text()


def test_the_script_prints_what_is_shown(tmp_path, lone_client):
    script, shown = re.search(r'```python\n(.*?)```\n\n```\n(.*?)```', TEXT, re.S).groups()
    node = start_node(tmp_path / 'log', scene_file='scenes/minimal.yaml')
    try:
        wait_until_ready(lone_client)
        done = run_python('-c', script)
    finally:
        node.end()
    assert done.returncode == 0, done.stderr
    assert done.stdout == shown


def test_the_calls_and_the_classes_of_the_page_are_there():
    calls = re.findall(r'^\| (`.*?`) \|', TEXT, re.M)
    names = re.findall(r'`(\w+)\(', ' '.join(calls))
    assert len(names) >= 8
    assert [name for name in names if not hasattr(client.SceneGraphClient, name)] == []
    classes = set(re.findall(r'`([A-Z]\w+[a-z]\w+)`', TEXT))
    assert classes <= set(client.__all__)
