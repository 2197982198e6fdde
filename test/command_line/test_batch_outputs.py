"""``batch`` writes over nothing that it reads, and over nothing that is not its own."""

import json
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from drake_geom_ros.batch.parts import FinishedParts
from drake_geom_ros.command_line import batch
from drake_geom_ros.command_line.program import main

CELL = Path(__file__).parents[1] / 'batch/cell.yaml'
COLUMNS = 4


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ('cell.yaml', 'arm.urdf'):
        shutil.copy(CELL.with_name(name), tmp_path)
    states = np.random.default_rng(5).uniform(-1, 1, (64, COLUMNS))
    np.savez(tmp_path / 'mine.npz', states=states)
    np.save(tmp_path / 'mine.npy', states)
    return tmp_path


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob('*')
        if path.is_file()
    }


def ask(*options):
    return main(['batch', *options])


def refused(folder, capsys, words, *options):
    before = contents(folder)
    assert ask(*options) == 2
    said = capsys.readouterr().err
    assert words in said, said
    assert contents(folder) == before
    assert not (folder / 'mine.npz.parts').exists()


def test_the_states_are_not_written_over(folder, capsys):
    (folder / 'link.npz').symlink_to(folder / 'mine.npz')
    os.link(folder / 'mine.npz', folder / 'hard.npz')
    (folder / 'sub').mkdir()
    for name in ('mine.npz', 'sub/../mine.npz', str(folder / 'mine.npz'), 'link.npz', 'hard.npz'):
        refused(folder, capsys, 'that is read', 'cell.yaml', 'mine.npz', '--out', name)
    refused(folder, capsys, 'that is read', 'cell.yaml', 'link.npz', '--out', 'mine.npz')


def test_no_other_input_is_written_over(folder, capsys):
    (folder / 'points.npz').write_text('[[0, 0, 1]]')
    asked = ['cell.yaml', 'mine.npz', '--out', 'out.npz']
    for option in (
        ['--picture', 'mine.npz'],
        ['--picture', 'cell.yaml'],
        ['--picture', 'arm.urdf'],
        ['--what', 'points', '--points', 'points.npz', '--picture', 'points.npz'],
    ):
        refused(folder, capsys, 'that is read', *asked, *option)
    refused(folder, capsys, 'are the same file', *asked, '--picture', 'out.npz')


def test_results_take_the_place_of_results_and_of_nothing_else(folder, capsys):
    asked = ['cell.yaml', 'mine.npz', '--out', 'out.npz']
    assert ask(*asked) == 0
    first = dict(np.load('out.npz'))
    assert ask(*asked, '--max-distance', '0.01') == 0
    assert np.load('out.npz')['question'] != first['question']
    np.savez('other.npz', question=[1], distance=[2.0])
    (folder / 'text.npz').write_text('mine')
    (folder / 'folder.npz').mkdir()
    (folder / 'dangling.npz').symlink_to(folder / 'nowhere')
    for name in ('other', 'text', 'folder', 'dangling'):
        words = 'is there, and not as results of a batch'
        refused(folder, capsys, words, 'cell.yaml', 'mine.npz', '--out', f'{name}.npz')
        assert not (folder / f'{name}.npz.parts').exists()


def test_parquet_takes_the_place_of_results_alone(folder, capsys):
    pytest.importorskip('pyarrow')
    asked = ['cell.yaml', 'mine.npz', '--out', 'out.parquet']
    assert ask(*asked) == 0
    assert ask(*asked) == 0
    (folder / 'out.parquet').write_text('mine')
    refused(folder, capsys, 'is there, and not as results', *asked)


@pytest.mark.parametrize('task', [None, 'no JSON', '[]', '{}', '{"job": "x", "blocks": []}'])
@pytest.mark.parametrize('resume', [[], ['--resume']])
def test_a_folder_of_somebody_else_is_left_alone(folder, capsys, task, resume):
    (folder / 'k.npz.parts').mkdir()
    (folder / 'k.npz.parts/thesis.txt').write_text('years of work')
    if task is not None:
        (folder / 'k.npz.parts/task.json').write_text(task)
    asked = ['cell.yaml', 'mine.npz', '--out', 'k.npz', *resume]
    refused(folder, capsys, 'no folder of parts that a batch has made', *asked)


def test_a_link_or_a_file_in_the_place_of_parts_is_left_alone(folder, capsys):
    asked = ['cell.yaml', 'mine.npz', '--out', 'k.npz', '--resume']
    (folder / 'k.npz.parts').write_text('mine')
    refused(folder, capsys, 'no folder of parts', *asked)
    (folder / 'k.npz.parts').unlink()
    (folder / 'elsewhere').mkdir()
    (folder / 'k.npz.parts').symlink_to(folder / 'elsewhere')
    refused(folder, capsys, 'no folder of parts', *asked)


def test_what_somebody_puts_among_the_parts_stays(folder, monkeypatch, capsys):
    put = FinishedParts.put

    def with_a_guest(self, block, columns):
        put(self, block, columns)
        (self.folder / 'notes.txt').write_text('mine')

    monkeypatch.setattr(FinishedParts, 'put', with_a_guest)
    asked = ['cell.yaml', 'mine.npz', '--out', 'k.npz']
    assert ask(*asked) == 0
    assert 'holds what is not of this run' in capsys.readouterr().err
    assert os.listdir('k.npz.parts') == ['notes.txt']
    refused(folder, capsys, 'no folder of parts', *asked)


def test_no_other_unfinished_file_is_touched(folder):
    (folder / 'out.npz.unfinished').write_text('mine')
    assert ask('cell.yaml', 'mine.npz', '--out', 'out.npz') == 0
    assert (folder / 'out.npz.unfinished').read_text() == 'mine'
    assert np.load('out.npz')['distance'].shape == (64,)


@pytest.mark.parametrize('cut', [False, True])
def test_states_that_are_rewritten_meanwhile_end_the_run(folder, monkeypatch, capsys, cut):
    computed = batch.computed

    def and_rewritten(job, rows, blocks, *more, **options):
        if cut:
            os.truncate('mine.npy', 200)
        else:
            np.load('mine.npy', mmap_mode='r+')[:] = 0.5
        return computed(job, rows, blocks, *more, **options)

    monkeypatch.setattr(batch, 'computed', and_rewritten)
    assert ask('cell.yaml', 'mine.npy', '--out', 'out.npz') == 2
    assert 'written over, or cut short' in capsys.readouterr().err
    assert not (folder / 'out.npz').exists()


def test_an_error_while_results_are_written_leaves_the_old_and_the_parts(folder, monkeypatch):
    asked = ['cell.yaml', 'mine.npz', '--out', 'out.npz']
    assert ask(*asked) == 0
    before = (folder / 'out.npz').read_bytes()

    def full(*arguments, **options):
        raise OSError('no space left')

    with monkeypatch.context() as patch:
        patch.setattr(os, 'fsync', full)
        assert ask(*asked, '--accuracy', 'fast') == 2
    assert (folder / 'out.npz').read_bytes() == before
    assert [name for name in os.listdir(folder) if name.startswith('.')] == []


def test_the_task_of_parts_says_whose_they_are(tmp_path):
    parts = FinishedParts(tmp_path / 'out.npz', {'job': 'x'}, [(0, 2)])
    parts.begin(resume=False)
    told = json.loads((parts.folder / 'task.json').read_text())
    assert told['format'] == 'drake_geom_ros parts of a batch 1'
    assert parts.remove()
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize('suffix', ['npz', 'parquet'])
def test_a_result_explains_itself_and_is_a_file_of_states_again(tmp_path, suffix):
    from drake_geom_ros.batch import Joints, evaluate
    from drake_geom_ros.batch.state_files import read_states
    from drake_geom_ros.geometry import SceneGraph
    from drake_geom_ros.scene_files import load_scene

    if suffix == 'parquet':
        pytest.importorskip('pyarrow')
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(CELL, scene_graph))
    rows = np.random.default_rng(2).uniform(-0.5, 0.5, (30, joints.count))
    np.save(tmp_path / 'rows.npy', rows)
    out = tmp_path / f'out.{suffix}'
    given = ['batch', str(CELL), str(tmp_path / 'rows.npy'), '--out', str(out)]
    assert main([*given, '--joint-gradients', '--what', 'within', '--max-distance', '0.2']) == 0
    expected = evaluate(
        *(scene_graph, None, None, 'within', 0.2), states=rows, joints=joints, by_joints=True
    )
    if suffix == 'parquet':
        parquet = pytest.importorskip('pyarrow.parquet').read_table(out)
        said = {key.decode(): text.decode() for key, text in parquet.schema.metadata.items()}
        assert json.loads(said['joints']) == list(joints.names)
        assert set(json.loads(said['columns'])) == set(parquet.column_names)
        found = np.array(parquet['joint_gradient'].to_pylist())
        states = np.array(parquet['states'].to_pylist())
        np.testing.assert_array_equal(states, rows[parquet['state'].to_numpy()])
        assert parquet['geometry_a'].to_pylist() == expected.name_A.tolist()
    else:
        with np.load(out) as file:
            found = file['joint_gradient']
            assert file['joints'].tolist() == list(joints.names)
            assert file['geometries'][file['geometry_a']].tolist() == expected.name_A.tolist()
            assert file['geometry_frames'].tolist() == [
                name.rpartition('/')[0].replace('things::world', 'world')
                for name in file['geometries'].tolist()
            ]
            told = json.loads(file['columns'][0])
            arrays = set(file.files) - {'geometries', 'geometry_frames', 'joints', 'columns'}
            assert set(told) == arrays - {'scene', 'question', 'versions'}
        again = read_states(out)
        np.testing.assert_array_equal(again.rows, rows)
        assert again.names == joints.names
    np.testing.assert_array_equal(found, expected.joint_gradient)


def test_states_may_be_left_out(tmp_path):
    np.save(tmp_path / 'rows.npy', np.zeros((3, 4)))
    given = ['batch', str(CELL), str(tmp_path / 'rows.npy'), '--what', 'collision']
    assert main([*given, '--without-states', '--out', str(tmp_path / 'out.npz')]) == 0
    with np.load(tmp_path / 'out.npz') as file:
        assert 'states' not in file.files
        assert len(file['joints']) == 4


def test_gradients_by_joints_of_what_has_none_are_refused(tmp_path, capsys):
    np.save(tmp_path / 'rows.npy', np.zeros((3, 4)))
    given = ['batch', str(CELL), str(tmp_path / 'rows.npy'), '--what', 'collision']
    assert main([*given, '--joint-gradients', '--out', str(tmp_path / 'out.npz')]) == 2
    assert 'by_joints' in capsys.readouterr().err
