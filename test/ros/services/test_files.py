"""A saved scene is written whole or not at all; without ROS."""

import os
from types import SimpleNamespace as Plain

import pytest
from ros.live_scenes import live_scene

from drake_geom_ros.ros.conversions.file_access import FileAccess
from drake_geom_ros.ros.guard import Guard
from drake_geom_ros.ros.services import files

ANSWER = Guard(logger=None, count=None).answer


@pytest.fixture
def live(tmp_path):
    live = live_scene('sources: [mine]\nframes:\n- {name: hand, source: mine}\n')
    (tmp_path / 'inside').mkdir()
    live.files = FileAccess([str(tmp_path / 'inside')])
    return live


def save(live, path):
    response = Plain(text='')
    return ANSWER(files.save_scene, live, Plain(path=str(path)), response)


def test_a_saved_scene_takes_the_place_of_what_was_there(live, tmp_path):
    target = tmp_path / 'inside/scene.yaml'
    for before in (None, 'something else, longer than what comes\n' * 100):
        if before:
            target.write_text(before)
        response = save(live, target)
        assert response.success
        assert target.read_text() == response.text
        assert 'hand' in response.text
    assert os.listdir(tmp_path / 'inside') == ['scene.yaml']


def test_a_node_that_dies_while_it_writes_leaves_what_was_there(live, tmp_path, monkeypatch):
    target = tmp_path / 'inside/scene.yaml'
    target.write_text('before')
    seen = []

    def full(source, destination):
        seen.append((target.read_text(), destination.read_text()))
        raise OSError('no space left')

    monkeypatch.setattr(os, 'replace', full)
    response = save(live, target)
    assert not response.success
    assert 'no space left' in response.message
    # All that was written until then lay beside it, and is cleaned away.
    assert seen == [('before', 'before')]
    assert target.read_text() == 'before'
    assert os.listdir(tmp_path / 'inside') == ['scene.yaml']


def test_a_link_that_leads_inside_is_followed(live, tmp_path):
    link = tmp_path / 'link.yaml'
    link.symlink_to(tmp_path / 'inside/scene.yaml')
    assert save(live, link).success
    assert link.is_symlink()
    assert sorted(os.listdir(tmp_path)) == ['inside', 'link.yaml']
    assert (tmp_path / 'inside/scene.yaml').read_text() == link.read_text()


def test_nobody_elses_file_is_written_through(live, tmp_path):
    """Neither what is named as a file that is half written, nor where that leads."""
    outside, target = tmp_path / 'outside', tmp_path / 'inside/scene.yaml'
    outside.write_text('precious')
    link, file = tmp_path / 'inside/scene.yaml.part', tmp_path / 'inside/other.yaml.part'
    link.symlink_to(outside)
    file.write_text('mine')
    assert save(live, target).success
    assert save(live, tmp_path / 'inside/other.yaml').success
    assert outside.read_text() == 'precious'
    assert link.is_symlink()
    assert file.read_text() == 'mine'
    assert target.read_text().startswith('sources')
    assert not target.is_symlink()
    assert target.stat().st_mode == outside.stat().st_mode  # as any new file


def test_a_folder_is_refused_before_anything_is_written(live, tmp_path, monkeypatch):
    (tmp_path / 'inside/folder').mkdir()
    monkeypatch.setattr(files, 'to_yaml', None)
    response = save(live, tmp_path / 'inside/folder')
    assert not response.success
    assert 'cannot be written to' in response.message
    assert 'folder' in response.message


@pytest.mark.parametrize('name', ['folder', 'file/scene.yaml', 'nowhere/scene.yaml', 'n' * 300])
def test_what_cannot_be_written_is_refused(live, tmp_path, name):
    (tmp_path / 'inside/folder').mkdir()
    (tmp_path / 'inside/file').touch()
    response = save(live, tmp_path / 'inside' / name)
    assert not response.success
    assert 'cannot be written to' in response.message
    assert sorted(os.listdir(tmp_path / 'inside')) == ['file', 'folder']
