"""Folders of compiled functions: nobody else writes to them, and older ones are removed."""

import os
from pathlib import Path

import pytest
from geometry._proximity.runtime.test_compiled import run
from numba import config

from drake_geom_ros.geometry._proximity.runtime import cache_folders


def test_a_folder_that_is_made_is_for_its_user_alone(tmp_path):
    before = os.umask(0)
    try:
        assert cache_folders.own_folder(tmp_path / 'ours')
    finally:
        os.umask(before)
    assert (tmp_path / 'ours').stat().st_mode & 0o777 == 0o700
    assert cache_folders.own_folder(tmp_path / 'ours')


@pytest.mark.parametrize('mode', [0o770, 0o707, 0o777])
def test_a_folder_that_others_can_write_to_is_not_used(tmp_path, mode):
    """They could have this user run their code."""
    (tmp_path / 'shared').mkdir()
    (tmp_path / 'shared').chmod(mode)
    assert not cache_folders.own_folder(tmp_path / 'shared')


@pytest.mark.skipif(os.getuid() != 0, reason='only root can make a folder of another user')
def test_a_folder_of_another_user_is_not_used(tmp_path):
    (tmp_path / 'theirs').mkdir(mode=0o700)
    os.chown(tmp_path / 'theirs', 12345, -1)
    assert not cache_folders.own_folder(tmp_path / 'theirs')


def test_a_room_has_folders_within_those_that_there_are():
    folders = cache_folders.CacheFolders('/own', '')
    assert folders.room('images') == ('/own/images', '')


def version(base, k):
    """Make the cache folder of the k-th of some older sources, and return it."""
    folder = base / f'kernels-{k:016x}'
    folder.mkdir(parents=True)
    os.utime(folder, (k, k))
    return folder


@pytest.mark.processes
@pytest.mark.skipif(config.DISABLE_JIT, reason='nothing is compiled')
def test_old_versions_are_removed_when_something_is_compiled(tmp_path):
    base = tmp_path / 'drake_geom_ros'
    old = [version(base, k) for k in range(8)]
    mine = Path(run(XDG_CACHE_HOME=str(tmp_path))[0])
    assert set(base.iterdir()) == {mine, *old[4:]}
    more = [version(base, k) for k in range(10, 18)]
    assert run(XDG_CACHE_HOME=str(tmp_path))[1:] == (1, 0)
    assert set(base.iterdir()) == {mine, *old[4:], *more}


def test_a_version_that_another_process_removes_meanwhile_is_no_obstacle(tmp_path):
    old = [version(tmp_path, k) for k in range(6)]
    (tmp_path / 'kernels-gone').symlink_to(tmp_path / 'nowhere')  # listed, and not there
    cache_folders.remove_old_versions(str(tmp_path / 'kernels-mine'))
    assert {path for path in tmp_path.iterdir() if path.exists()} == set(old[2:])


@pytest.mark.processes
def test_what_others_keep_in_the_folder_stays(tmp_path):
    theirs = [tmp_path / f'{k:016x}' for k in range(8)]
    theirs += [tmp_path / 'drake_geom_ros' / f'{k:016x}' for k in range(8)]
    for folder in theirs:
        folder.mkdir(parents=True)
    mine = Path(run(NUMBA_CACHE_DIR=str(tmp_path))[0])
    assert mine.parent == tmp_path / 'drake_geom_ros'
    assert all(folder.is_dir() for folder in theirs)
