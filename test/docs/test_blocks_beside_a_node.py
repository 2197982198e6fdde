"""Code blocks of Python that need a running node run beside one.

exceptions.yaml lists such a block with the reason ``beside a node: SCENE``, its scene file.
"""

import re
from collections import defaultdict

import numpy as np
import pytest
import yaml
from conventions.source_tree import ROOT
from docs.pages import EXCEPTIONS, blocks
from docs.running import PageRunner

pytestmark = pytest.mark.topics

BESIDE = re.compile(r'beside a node: (\S+\.yaml)')
# Blocks by page and scene: those of one page continue one another.
TABLE = defaultdict(list)
for name, lines in yaml.safe_load(EXCEPTIONS.read_text()).items():
    for first_line, reason in lines.items():
        if scene := BESIDE.search(reason):
            TABLE[name, scene[1]].append(first_line)


def scene_text(page, scene):
    """Return a scene file, or the YAML block of the page that stands for it."""
    if (ROOT / scene).is_file():
        return (ROOT / scene).read_text()
    (text,) = [block.text for block in blocks(page) if block.kind == 'yaml']
    return text


@pytest.mark.parametrize(('page', 'scene'), sorted(TABLE))
def test_blocks_of_a_page_run_beside_a_node(page, scene, shared_node, tmp_path, monkeypatch):
    from drake_geom_ros.client import SceneGraphClient

    monkeypatch.chdir(tmp_path)
    shared_node.load(scene_text(page, scene))
    runner = PageRunner(tmp_path)
    with SceneGraphClient() as client:
        runner.names.update(client=client, np=np, SceneGraphClient=SceneGraphClient)
        chosen = [each for each in blocks(page) if each.first_line in TABLE[page, scene]]
        assert len(chosen) == len(TABLE[page, scene])
        for block in chosen:
            runner.run(block)


def test_the_table_has_blocks():
    assert len(TABLE) >= 5
