"""A saved scene is written whole or not at all, and over nothing but such a one; without ROS."""

import os
import socket
import stat
from types import SimpleNamespace as Plain

import pytest
from live.live_scenes import live_scene

from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.services import files, saved_file
from drake_geom_ros.scene_files import read_scene

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


def test_a_saved_scene_takes_the_place_of_a_saved_scene(live, tmp_path):
    for name in 'scene.yaml', 'scene.yml':
        target = tmp_path / 'inside' / name
        for _ in range(2):
            response = save(live, target)
            assert response.success, response.message
            assert target.read_text() == saved_file.MARK + response.text
            assert 'hand' in response.text
            target.write_text(target.read_text() + '# longer than what comes\n' * 100)
    assert sorted(os.listdir(tmp_path / 'inside')) == ['scene.yaml', 'scene.yml']
    assert [frame.name for frame in read_scene(target).frames] == ['hand']


def test_the_mode_of_a_saved_scene_stays(live, tmp_path):
    target = tmp_path / 'inside/scene.yaml'
    assert save(live, target).success
    target.chmod(0o640)
    assert save(live, target).success
    assert stat.S_IMODE(target.stat().st_mode) == 0o640
    target.chmod(0o440)
    before = target.read_text()
    response = save(live, target)
    assert not response.success
    assert 'write-protected' in response.message
    assert target.read_text() == before


@pytest.mark.parametrize(
    'name', ['run.sh', '.bashrc', 'mesh.obj', 'scene.yaml.sh', '.yaml', 'yaml']
)
@pytest.mark.parametrize('there', [True, False])
def test_a_name_that_is_none_of_a_scene_is_refused(live, tmp_path, name, there):
    """A source may be called ``$(touch PWNED)``: what runs the file runs that."""
    target = tmp_path / 'inside' / name
    if there:
        target.write_text('mine')
    response = save(live, target)
    assert not response.success
    assert '.yaml or .yml' in response.message
    assert target.exists() == there
    assert not there or target.read_text() == 'mine'


@pytest.mark.parametrize(
    'text', ['', 'services: {}\n', 'sources: [other]\n', f'\n{saved_file.MARK}sources: []\n']
)
def test_a_file_that_it_did_not_write_is_left_alone(live, tmp_path, text):
    """Not even a scene, which somebody may have written by hand."""
    target = tmp_path / 'inside/mine.yaml'
    target.write_text(text)
    response = save(live, target)
    assert not response.success
    assert 'was not written by save_scene' in response.message
    assert target.read_text() == text
    assert os.listdir(tmp_path / 'inside') == ['mine.yaml']


def test_nothing_is_written_through_what_is_no_plain_file(live, tmp_path):
    inside = tmp_path / 'inside'
    assert save(live, inside / 'scene.yaml').success
    before = (inside / 'scene.yaml').read_text()
    (inside / 'link.yaml').symlink_to(inside / 'scene.yaml')
    (inside / 'dangling.yaml').symlink_to(inside / 'new.yaml')
    os.mkfifo(inside / 'pipe.yaml')
    (inside / 'folder.yaml').mkdir()
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(inside / 'socket.yaml'))
        for name in 'link', 'dangling', 'pipe', 'folder', 'socket':
            response = save(live, inside / f'{name}.yaml')
            assert not response.success
            assert 'is no plain file' in response.message
    assert (inside / 'scene.yaml').read_text() == before
    assert not (inside / 'new.yaml').exists()
    assert stat.S_ISFIFO((inside / 'pipe.yaml').stat().st_mode)
    assert len(os.listdir(inside)) == 6


def test_a_folder_that_becomes_a_link_leads_nowhere(live, tmp_path, monkeypatch):
    """What was looked at is what is written to, or nothing is."""
    (tmp_path / 'inside/sub').mkdir()
    (tmp_path / 'outside').mkdir()
    to_yaml = files.to_yaml

    def slow(description):
        (tmp_path / 'inside/sub').rmdir()
        (tmp_path / 'inside/sub').symlink_to(tmp_path / 'outside')
        return to_yaml(description)

    monkeypatch.setattr(files, 'to_yaml', slow)
    assert not save(live, tmp_path / 'inside/sub/scene.yaml').success
    assert os.listdir(tmp_path / 'outside') == []


def test_a_node_that_dies_while_it_writes_leaves_what_was_there(live, tmp_path, monkeypatch):
    target = tmp_path / 'inside/scene.yaml'
    assert save(live, target).success
    before, seen = target.read_text(), []

    def full(descriptor):
        seen.append((target.read_text(), os.fstat(descriptor).st_size))
        raise OSError('no space left')

    monkeypatch.setattr(os, 'fsync', full)
    response = save(live, target)
    assert not response.success
    assert 'no space left' in response.message
    # All that was written until then lay beside it, and is cleaned away.
    assert seen == [(before, len(before))]
    assert target.read_text() == before
    assert os.listdir(tmp_path / 'inside') == ['scene.yaml']


def test_a_folder_that_leads_inside_is_followed(live, tmp_path):
    (tmp_path / 'link').symlink_to(tmp_path / 'inside')
    assert save(live, tmp_path / 'link/scene.yaml').success
    assert os.listdir(tmp_path / 'inside') == ['scene.yaml']


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
    assert target.read_text().startswith(saved_file.MARK)
    assert not target.is_symlink()
    assert target.stat().st_mode == outside.stat().st_mode  # as any new file


def test_what_cannot_be_written_to_is_refused_before_anything_is_made(live, tmp_path, monkeypatch):
    (tmp_path / 'inside/folder.yaml').mkdir()
    monkeypatch.setattr(files, 'to_yaml', None)
    response = save(live, tmp_path / 'inside/folder.yaml')
    assert not response.success
    assert 'cannot be written to' in response.message
    assert 'folder' in response.message


@pytest.mark.parametrize('name', ['file/scene.yaml', 'nowhere/scene.yaml', 'n' * 300 + '.yaml'])
def test_what_cannot_be_written_is_refused(live, tmp_path, name):
    (tmp_path / 'inside/file').touch()
    response = save(live, tmp_path / 'inside' / name)
    assert not response.success
    assert 'cannot be written to' in response.message
    assert os.listdir(tmp_path / 'inside') == ['file']
