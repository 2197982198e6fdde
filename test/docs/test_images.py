"""docs/images.md: its commands print what it shows, its scene can be read, its program runs."""

import os
import re

import pytest
from conventions.source_tree import ROOT
from docs.console import blocks, run

from drake_geom_ros.scene_files import read_scene

PAGE = (ROOT / 'docs/images.md').read_text()


@pytest.mark.parametrize('block', blocks(PAGE), ids=lambda block: block[0][0])
def test_a_command_prints_what_is_shown(tmp_path, monkeypatch, block):
    pytest.importorskip('matplotlib')
    (tmp_path / 'scenes').symlink_to(ROOT / 'scenes')
    paths = [str(ROOT), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    for command, shown in block:
        assert run(command, tmp_path) == shown


def code(language):
    """Return the first block of a language."""
    return re.search(rf'^```{language}\n(.*?)^```$', PAGE, re.S | re.M)[1]


def test_the_camera_of_the_page_can_be_read():
    scene = 'sources: [left]\nframes: [{name: panda_hand, source: left}]\n'
    (camera,) = read_scene(scene + code('yaml')).cameras
    assert (camera.name, camera.frame, camera.shows) == ('hand', 'panda_hand', 'proximity')


def test_the_program_of_the_page_runs(capsys):
    exec(code('python'), {})
    assert capsys.readouterr().out == '2.5 [32764] (480, 640, 4)\n'
