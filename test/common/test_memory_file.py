"""Files in memory."""

import pickle

import pytest

from drake_geom_ros.common import MemoryFile


def test_what_is_in_it():
    empty = MemoryFile()
    assert (empty.contents(), empty.extension(), empty.filename_hint()) == (b'', '', '')
    file = MemoryFile(contents='v 0 0 0', extension='.OBJ', filename_hint='point')
    assert (file.contents(), file.extension()) == (b'v 0 0 0', '.obj')
    assert file.filename_hint() == 'point'


def test_a_value_prints_as_it_is_made():
    file = MemoryFile(b'\x00\xff', '.stl', 'part')
    assert eval(repr(file)) == file == pickle.loads(pickle.dumps(file))
    assert len({file, MemoryFile(b'\x00\xff', '.STL', 'part'), MemoryFile()}) == 2
    assert repr(MemoryFile(b'x' * 101)).startswith("MemoryFile(contents=<b'xxx")


def test_it_can_be_read(tmp_path):
    path = tmp_path / 'part.Stl'
    path.write_bytes(b'solid')
    assert MemoryFile.Make(path) == MemoryFile(b'solid', '.stl', str(path))
    with pytest.raises(RuntimeError, match='No such file'):
        MemoryFile.Make(path=tmp_path / 'none.stl')


@pytest.mark.parametrize('extension', ['obj', '.'])
def test_an_extension_has_a_dot(extension):
    with pytest.raises(RuntimeError, match='must be empty or like'):
        MemoryFile('', extension, '')
    with pytest.raises(RuntimeError, match='contents = 3'):
        MemoryFile(3)
