"""Files are there whole or not at all, and nothing that is read is written over."""

import os
import stat

import pytest

from drake_geom_ros.common.whole_files import check_outputs, open_folder, whole_file


def test_what_is_there_stays_until_the_new_is_whole(tmp_path):
    path = tmp_path / 'file.txt'
    path.write_text('before')
    path.chmod(0o640)
    with whole_file(path) as file:
        file.write('after')
        assert path.read_text() == 'before'
    assert path.read_text() == 'after'
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert os.listdir(tmp_path) == ['file.txt']


@pytest.mark.parametrize('there', [True, False])
@pytest.mark.parametrize('error', [OSError, KeyboardInterrupt])
def test_an_error_leaves_what_was_there_and_nothing_else(tmp_path, there, error):
    path = tmp_path / 'file.bin'
    if there:
        path.write_bytes(b'before')

    def fail():
        with whole_file(path, 'wb') as file:
            file.write(b'half')
            raise error

    with pytest.raises(error):
        fail()
    assert os.listdir(tmp_path) == (['file.bin'] if there else [])
    assert not there or path.read_bytes() == b'before'


def test_a_new_file_has_the_mode_of_any_new_file(tmp_path):
    (tmp_path / 'other').touch()
    with whole_file(tmp_path / 'file') as file:
        file.write('x')
    assert (tmp_path / 'file').stat().st_mode == (tmp_path / 'other').stat().st_mode


def test_a_link_is_followed_and_a_pipe_is_written_to(tmp_path):
    (tmp_path / 'elsewhere').mkdir()
    (tmp_path / 'link').symlink_to(tmp_path / 'elsewhere/file')
    with whole_file(tmp_path / 'link') as file:
        file.write('x')
    assert (tmp_path / 'link').is_symlink()
    assert (tmp_path / 'elsewhere/file').read_text() == 'x'
    with whole_file('/dev/null') as file:
        file.write('x')
    assert stat.S_ISCHR(os.stat('/dev/null').st_mode)
    os.mkfifo(tmp_path / 'pipe')
    reader = os.open(tmp_path / 'pipe', os.O_RDONLY | os.O_NONBLOCK)
    with whole_file(tmp_path / 'pipe') as file:
        file.write('x')
    assert os.read(reader, 9) == b'x'
    os.close(reader)
    assert stat.S_ISFIFO(os.stat(tmp_path / 'pipe').st_mode)


@pytest.mark.skipif(not os.path.exists('/dev/full'), reason='a device of Linux')
def test_a_full_disk_is_told_with_the_name_of_the_file():
    def fill():
        with whole_file('/dev/full') as file:
            file.write('x' * 100_000)

    with pytest.raises(OSError, match='No space left') as full:
        fill()
    assert full.value.filename == '/dev/full'


def test_a_folder_that_became_a_link_is_not_opened(tmp_path):
    (tmp_path / 'real/inner').mkdir(parents=True)
    os.close(open_folder(tmp_path / 'real/inner'))
    (tmp_path / 'link').symlink_to(tmp_path / 'real')
    for name in ('link', 'link/inner'):
        with pytest.raises(OSError, match='link'):
            open_folder(tmp_path / name)


def test_an_input_is_refused_by_whatever_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = tmp_path / 'in.npz'
    source.write_text('states')
    (tmp_path / 'link.npz').symlink_to(source)
    os.link(source, tmp_path / 'hard.npz')
    (tmp_path / 'folder').mkdir()
    for name in ('in.npz', 'folder/../in.npz', 'link.npz', 'hard.npz', str(source)):
        with pytest.raises(FileExistsError, match=f'--output {name} is the file .* that is read'):
            check_outputs({'--output': name}, [None, '', source])
    with pytest.raises(FileExistsError, match='--picture and --output are the same file'):
        check_outputs({'--output': 'new.npz', '--picture': 'folder/../new.npz'}, [source])
    check_outputs({'--output': 'out.npz', '--picture': None}, [source, '/nowhere'])
    check_outputs({'--output': '/dev/null', '--picture': '/dev/null'}, ['/dev/null'])
