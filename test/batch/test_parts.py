"""Parts of a batch that was cut off: what is whole is kept, the rest is named and done again."""

import json
import os

import numpy as np
import pytest

from drake_geom_ros.batch.parts import FinishedParts
from drake_geom_ros.batch.running import BatchError

BLOCKS = [(0, 3), (3, 5)]
TASK = {'question': 'least', 'version': '1', 'scene': 's', 'states': 't', 'job': 'j'}


def parts(folder, **changed):
    return FinishedParts(folder / 'out.npz', {**TASK, **changed}, BLOCKS)


def columns(count):
    return {'distance': np.arange(float(count)), 'id_A': np.arange(count)}


@pytest.fixture
def done(tmp_path):
    """Return a folder in which the first of two blocks is done."""
    run = parts(tmp_path)
    assert run.begin(resume=False) == BLOCKS
    run.put(BLOCKS[0], columns(3))
    return tmp_path


def test_a_run_goes_on_with_what_is_missing(done):
    assert parts(done).begin(resume=True) == BLOCKS[1:]
    with pytest.raises(BatchError, match='go on with --resume'):
        parts(done).begin(resume=False)


@pytest.mark.parametrize(
    'damage',
    [
        lambda data: b'',
        lambda data: data[: len(data) // 2],
        lambda data: data[:200] + b'\0' * 80 + data[280:],
        lambda data: b'no zip file',
        lambda data: np.random.default_rng(0).bytes(len(data)),
    ],
)
def test_a_damaged_part_is_named_dropped_and_done_again(done, damage):
    path = done / 'out.npz.parts/000000000000.npz'
    path.write_bytes(damage(path.read_bytes()))
    told = []
    assert parts(done).begin(True, told.append) == BLOCKS
    assert len(told) == 1
    assert f'{path} is damaged, and done again: ' in told[0]
    assert not path.exists()


def test_a_part_of_other_states_is_damaged(done):
    parts(done).put(BLOCKS[0], columns(2))
    told = []
    assert parts(done).begin(True, told.append) == BLOCKS
    assert 'it has 2 states, not 3' in told[0]


@pytest.mark.parametrize('text', ['', '{"format": "drake', '\0' * 90])
def test_with_a_damaged_task_all_begins_anew(done, text):
    task = done / 'out.npz.parts/task.json'
    task.write_text(text)
    with pytest.raises(BatchError, match='parts of an earlier run'):
        parts(done).begin(resume=False)
    told = []
    assert parts(done).begin(True, told.append) == BLOCKS
    assert 'task.json is damaged' in told[0]
    assert json.loads(task.read_text())['question'] == 'least'
    assert os.listdir(done / 'out.npz.parts') == ['task.json']


@pytest.mark.parametrize(
    ('changed', 'words'),
    [
        ({'question': 'within', 'job': 'k'}, r'another question \(least, not within\)$'),
        ({'version': '2'}, r'another version of drake_geom_ros \(1, not 2\)$'),
        (
            {'scene': 'x', 'states': 'y', 'job': 'k'},
            'another scene and of another file of states$',
        ),
        ({'job': 'k'}, 'another choice of joints or frames$'),
    ],
)
def test_of_another_task_it_is_told_what_differs(done, changed, words):
    with pytest.raises(BatchError, match=words):
        parts(done, **changed).begin(resume=True)


def test_a_run_that_kept_nothing_does_not_stand_in_the_way(tmp_path):
    parts(tmp_path).begin(resume=False)
    (tmp_path / 'out.npz.parts/000000000000.unfinished').write_text('')
    assert parts(tmp_path, question='within').begin(resume=False) == BLOCKS
    assert parts(tmp_path, scene='x').begin(resume=True) == BLOCKS


def test_files_of_others_in_the_folder_stay(tmp_path):
    parts(tmp_path).begin(resume=False)
    (tmp_path / 'out.npz.parts/notes.txt').write_text('mine')
    parts(tmp_path).begin(resume=False)
    assert (tmp_path / 'out.npz.parts/notes.txt').read_text() == 'mine'
    (tmp_path / 'out.npz.parts/task.json').write_text('')
    with pytest.raises(BatchError, match='no folder of parts'):
        parts(tmp_path).begin(resume=True)


def test_a_part_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    synced = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, 'fsync', lambda fd: (synced.append('content'), fsync(fd)))
    monkeypatch.setattr(os, 'replace', lambda *a, **b: (synced.append('name'), replace(*a, **b)))
    run = parts(tmp_path)
    run.begin(resume=False)
    synced.clear()
    run.put(BLOCKS[0], columns(3))
    assert synced == ['content', 'name']
