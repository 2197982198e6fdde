"""Files of states as people have them, and broken ones, each refused in one line."""

import zipfile

import numpy as np
import pytest

from drake_geom_ros.batch.state_files import read_states
from drake_geom_ros.scene_files import SceneFileError


@pytest.mark.parametrize('start', ['', '\ufeff'])
@pytest.mark.parametrize('end', ['', '\n', '\n\n', '\r\n \r\n', '\n,\n'])
def test_a_byte_order_mark_and_blank_lines_at_the_end_are_fine(tmp_path, start, end):
    path = tmp_path / 's.csv'
    path.write_bytes(f'{start}r::a, r::b\n1,2\n3,4{end}'.encode())
    states = read_states(path)
    assert states.names == ('r::a', 'r::b')
    assert states.rows.tolist() == [[1, 2], [3, 4]]


def packed(**arrays):
    def write(path):
        np.savez(path, **arrays)

    return write


def torn(path):
    np.savez_compressed(path, states=np.random.default_rng(0).random((50, 2)))
    data = bytearray(path.read_bytes())
    data[200:260] = bytes(60)
    path.write_bytes(data)


def strange(path):
    with zipfile.ZipFile(path, 'w') as file:
        file.writestr('states.npy', b'\x93NUMPY\x01\x00v\x00{"descr": (((')


BROKEN = {
    'empty.csv': (lambda path: path.write_text(''), 'it is empty'),
    'blank.csv': (lambda path: path.write_text('\n\n'), 'it is empty'),
    'word.csv': (lambda path: path.write_text('a\n1\nx1\n'), r"row 3: 'x1' is no number"),
    'gap.csv': (lambda path: path.write_text('a\n1\n\n2\n'), 'row 3 has 0 values, the header 1'),
    'long.csv': (lambda path: path.write_text('a\n1,2\n'), 'row 2 has 2 values'),
    'latin.csv': (lambda path: path.write_bytes(b'\xe9\n1\n'), 'utf-8'),
    'field.csv': (lambda path: path.write_text(f'a\n{"1" * 200_000}\n'), 'field larger'),
    'no.npz': (lambda path: path.write_text('no zip'), 'cannot be read as states'),
    'none.npz': (packed(rows=np.zeros((2, 2))), 'states'),
    'names.npz': (packed(states=np.zeros((2, 2)), joints=np.arange(2)), "'joints' must be a list"),
    'letters.npz': (packed(states=np.zeros((2, 2)), joints=np.array('ab')), "'joints' must be"),
    'torn.npz': (torn, 'cannot be read as states'),
    'strange.npz': (strange, 'cannot be read as states'),
    'number.npz': (packed(states=np.array(1.0)), 'states must be float64'),
    'objects.npy': (lambda path: np.save(path, np.array([{}, {}])), 'cannot be read as states'),
    'cut.npy': (lambda path: path.write_bytes(b'\x93NUMPY\x01\x00'), 'cannot be read as states'),
    'text.npy': (lambda path: path.write_text('1 2 3'), 'cannot be read as states'),
    'folder.csv': (lambda path: path.mkdir(), 'directory'),
}


@pytest.mark.parametrize('name', BROKEN)
def test_what_is_broken_is_refused_in_one_line(tmp_path, name):
    write, word = BROKEN[name]
    write(tmp_path / name)
    with pytest.raises(SceneFileError, match=word) as told:
        read_states(tmp_path / name)
    assert name in str(told.value)
    assert '\n' not in str(told.value)
