"""States of a file that changes meanwhile: an error that says so, never a mix, no signal."""

import os

import numpy as np
import pytest

from drake_geom_ros.batch.file_rows import FileRows
from drake_geom_ros.batch.state_files import read_states
from drake_geom_ros.scene_files import SceneFileError


@pytest.fixture
def path(tmp_path):
    np.save(tmp_path / 'states.npy', np.random.default_rng(0).normal(size=(5000, 3)))
    return tmp_path / 'states.npy'


def test_slices_are_those_of_the_array(path):
    whole, rows = np.load(path), FileRows.of(path)
    assert (rows.shape, rows.ndim, rows.dtype, len(rows)) == (whole.shape, 2, whole.dtype, 5000)
    for first, last in ((0, 5000), (1000, 1100), (1024, 2048), (4990, 9999), (7, 7), (6, 2)):
        np.testing.assert_array_equal(rows[first:last], whole[first:last])


@pytest.mark.parametrize('shape', [(0, 3), (3, 0), (0, 2, 7), (2, 2, 7)])
def test_small_and_empty_ones(tmp_path, shape):
    np.save(tmp_path / 'x.npy', np.ones(shape))
    np.testing.assert_array_equal(FileRows.of(tmp_path / 'x.npy')[0:9], np.ones(shape))


def test_what_is_written_over_in_place_is_noticed_whatever_the_times_say(path):
    before = path.stat()
    rows = read_states(path).rows
    mapped = np.load(path, mmap_mode='r+')
    mapped[3000, 1] += 1e-12
    mapped.flush()
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    rows[0:2048]
    with pytest.raises(SceneFileError, match='written over, or cut short'):
        rows[2500:4000]
    with pytest.raises(SceneFileError, match=r'states\.npy'):
        rows[0:5000]


def test_a_file_that_is_cut_short_ends_no_process(path):
    rows = read_states(path).rows
    os.truncate(path, 60_000)
    rows[0:1000]
    with pytest.raises(SceneFileError, match='cut short'):
        rows[3000:4000]
    with pytest.raises(SceneFileError, match='cut short'):
        read_states(path)


def test_a_file_that_is_replaced_is_still_the_one_that_was_opened(path):
    whole, states = np.load(path), read_states(path)
    np.save(path.with_name('new.npy'), np.zeros((5000, 3)))
    os.replace(path.with_name('new.npy'), path)
    np.testing.assert_array_equal(states.rows[0:5000], whole)
    assert states.digest != read_states(path).digest


def test_other_orders_are_read_at_once_and_other_types_refused(tmp_path):
    whole = np.arange(6.0).reshape(2, 3)
    np.save(tmp_path / 'x.npy', np.asfortranarray(whole))
    np.testing.assert_array_equal(read_states(tmp_path / 'x.npy').rows, whole)
    for wrong in (whole.astype(np.float32), whole.astype('>f8'), np.zeros(3)):
        np.save(tmp_path / 'x.npy', wrong)
        with pytest.raises(SceneFileError, match='float64'):
            read_states(tmp_path / 'x.npy')


@pytest.mark.parametrize('name', ['x.npy', 'x.npz'])
@pytest.mark.parametrize('content', [b'', b'PK\3\4 and no more', b'\x93NUMPY\1\0', b'a,b\n1\n'])
def test_what_holds_no_states_is_refused(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneFileError, match=name):
        read_states(tmp_path / name)


@pytest.mark.parametrize('name', ['x.npz', 'x.csv'])
def test_a_file_that_is_written_to_while_it_is_read_is_refused(tmp_path, name, monkeypatch):
    path = tmp_path / name
    np.savez(tmp_path / 'x.npz', states=np.ones((2, 3)))
    (tmp_path / 'x.csv').write_text('a,b\n1,2\n')
    array = np.array

    def slow(*arguments, **named):
        path.write_bytes(path.read_bytes() + b'\n')
        return array(*arguments, **named)

    class Slow(type(np.load(tmp_path / 'x.npz'))):
        def __getitem__(self, key):
            path.write_bytes(path.read_bytes())
            return super().__getitem__(key)

    monkeypatch.setattr(np, 'array', slow)
    monkeypatch.setattr(np, 'load', lambda file: Slow(open(file, 'rb'), own_fid=True))  # noqa: SIM115
    with pytest.raises(SceneFileError, match='written to while it was read'):
        read_states(path)
