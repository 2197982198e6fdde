"""``batch``: files in, files out, and a run that is cut off goes on where it was."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.batch.parts import FinishedParts
from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

SCENE = Path(__file__).parents[1] / 'batch/cell.yaml'


@pytest.fixture(scope='module')
def loaded():
    scene_graph = SceneGraph()
    return scene_graph, load_scene(SCENE, scene_graph)


@pytest.fixture(scope='module')
def states(loaded):
    joints = Joints.of(loaded[1])
    lower, upper = joints.lower.clip(-3), joints.upper.clip(max=3)
    return np.random.default_rng(5).uniform(lower, upper, (200, joints.count))


@pytest.fixture
def ask(tmp_path, states):
    np.save(tmp_path / 'states.npy', states)

    def run(*options, file='states.npy', output='out.npz'):
        files = str(SCENE), str(tmp_path / file), '--out', str(tmp_path / output)
        return main(['batch', *files, *options])

    return run


def names_of(loaded, id_values):
    names = {
        id.get_value(): f'{source}::{frame}/{name}'
        for (source, frame, name), id in loaded[1].geometries.items()
    }
    return [names[id] for id in id_values.tolist()]


def test_the_file_holds_what_evaluate_returns(ask, tmp_path, loaded, states, capsys):
    assert ask('--what', 'within', '--max-distance', '0.1') == 0
    expected = evaluate(
        *(loaded[0], None, None, 'within', 0.1), states=states, joints=Joints.of(loaded[1])
    )
    with np.load(tmp_path / 'out.npz') as found:
        for name in ('offsets', 'distance', 'error_bound', 'gradient', 'p_WCa', 'method'):
            np.testing.assert_array_equal(found[name], getattr(expected, name))
        names = found['geometries'][found['geometry_a']].tolist()
        assert names == names_of(loaded, expected.id_A)
        assert found['question'][0].startswith('within max_distance=0.1')
        assert 'sources' in json.loads(found['versions'][0])['drake_geom_ros']
        assert len(found['scene'][0]) == 64
    assert capsys.readouterr().out.startswith('states 200\n')
    assert not (tmp_path / 'out.npz.parts').exists()


@pytest.mark.parametrize('what', ['least', 'within', 'points'])
def test_each_part_is_read_once_however_many_columns_there_are(ask, tmp_path, monkeypatch, what):
    read, get = [], FinishedParts.get
    monkeypatch.setattr(
        FinishedParts, 'get', lambda self, block: read.append(block) or get(self, block)
    )
    options = ['--what', what, '--max-distance', '0.3']
    if what == 'points':
        (tmp_path / 'points.csv').write_text('x,y,z\n0,0,1\n')
        options += ['--points', str(tmp_path / 'points.csv')]
    assert ask(*options) == 0
    assert len(read) == len(set(read)) > 1
    written = np.load(tmp_path / 'out.npz')
    assert len(written.files) >= 7
    if what != 'least':
        assert written['offsets'][0] == 0
        assert written['offsets'][-1] == len(written['distance'])


def test_states_come_as_csv_and_npz_too(ask, tmp_path, loaded, states):
    joints = Joints.of(loaded[1])
    with (tmp_path / 'states.csv').open('w') as file:
        file.write(','.join(joints.names) + '\n')
        np.savetxt(file, states, delimiter=',', fmt='%.17g')
    np.savez(tmp_path / 'named.npz', states=states[:, ::-1], joints=joints.names[::-1])
    frames = {id: f'{source}::{frame}' for (source, frame), id in loaded[1].frames.items()}
    posed = [frames[id] for id in joints.frame_ids]
    np.savez(tmp_path / 'posed.npz', poses=joints.poses(states), frames=posed)
    files = []
    for name in ('states.npy', 'states.csv', 'named.npz', 'posed.npz'):
        assert ask(file=name, output=f'{name}.npz') == 0
        files.append(dict(np.load(tmp_path / f'{name}.npz')))
    for other in files[1:]:
        for name in ('distance', 'geometry_a', 'gradient'):
            np.testing.assert_array_equal(other[name], files[0][name])


def test_a_run_that_was_cut_off_goes_on(ask, tmp_path, monkeypatch, capsys):
    put, kept = FinishedParts.put, []

    def interrupted(self, block, columns):
        if len(kept) == 5:
            raise KeyboardInterrupt
        kept.append(block)
        put(self, block, columns)

    monkeypatch.setattr(FinishedParts, 'put', interrupted)
    assert ask() == 130
    assert '--resume' in capsys.readouterr().err
    monkeypatch.setattr(FinishedParts, 'put', put)
    assert ask() == 2
    assert 'parts of an earlier run' in capsys.readouterr().err
    assert ask('--accuracy', 'fast', '--resume') == 2
    assert 'of another question (' in capsys.readouterr().err
    assert ask('--resume') == 0
    assert '5 of 16 blocks are there' in capsys.readouterr().err
    assert ask(output='whole.npz') == 0
    resumed, whole = np.load(tmp_path / 'out.npz'), np.load(tmp_path / 'whole.npz')
    for name in whole:
        np.testing.assert_array_equal(resumed[name], whole[name])


def test_a_block_that_was_half_written_is_done_again(ask, tmp_path, monkeypatch):
    remove, task = FinishedParts.remove, []
    monkeypatch.setattr(FinishedParts, 'remove', lambda self: task.append(self))
    assert ask() == 0
    monkeypatch.setattr(FinishedParts, 'remove', remove)
    first = sorted(task[0].folder.glob('*.npz'))[0]
    first.with_suffix('.unfinished').write_bytes(first.read_bytes()[:100])
    first.unlink()
    whole = np.load(tmp_path / 'out.npz')['distance']
    assert ask('--resume') == 0
    np.testing.assert_array_equal(np.load(tmp_path / 'out.npz')['distance'], whole)


@pytest.mark.skipif(not importlib.util.find_spec('pyarrow'), reason='pyarrow is not installed')
@pytest.mark.parametrize('what', ['least', 'within', 'collision', 'points'])
def test_parquet_holds_the_same(ask, tmp_path, what):
    import pyarrow.parquet

    options = ['--what', what, '--max-distance', '0.1']
    if what == 'points':
        (tmp_path / 'points.csv').write_text('x,y,z\n0,0,1\n0.5,0,0.2\n')
        options += ['--points', str(tmp_path / 'points.csv')]
    assert ask(*options) == 0
    assert ask(*options, output='out.parquet') == 0
    table = pyarrow.parquet.read_table(tmp_path / 'out.parquet')
    with np.load(tmp_path / 'out.npz') as plain:
        assert table.schema.metadata[b'question'].decode() == plain['question'][0]
        for name in ('distance', 'error_bound', 'gradient', 'collision', 'grad_W'):
            if name in plain:
                found = np.array(table[name].to_pylist())
                np.testing.assert_array_equal(found.reshape(plain[name].shape), plain[name])
        if 'offsets' in plain:
            counts = np.bincount(table['state'].to_numpy(), minlength=200)
            np.testing.assert_array_equal(counts, np.diff(plain['offsets']))
        place = 'geometry' if what == 'points' else 'geometry_a'
        if place in plain:
            names = [*plain['geometries'].tolist(), None]
            assert table[place].to_pylist() == [names[k] for k in plain[place]]


def test_a_picture_of_the_distances(ask, tmp_path):
    assert ask('--picture', str(tmp_path / 'clearances.png')) == 0
    assert (tmp_path / 'clearances.png').read_bytes().startswith(b'\x89PNG')


def test_a_margin_is_heeded(ask, tmp_path, loaded, states):
    asked = {'want': 'collision', 'states': states, 'joints': Joints.of(loaded[1])}
    shares = []
    for options, margin in (((), np.inf), (('--max-distance', '0.002'), 0.002)):
        assert ask('--what', 'collision', *options) == 0
        expected = evaluate(loaded[0], max_distance=margin, **asked)
        np.testing.assert_array_equal(np.load(tmp_path / 'out.npz')['collision'], expected)
        shares.append(expected.mean())
    assert 0.0 < shares[0] < shares[1]


def test_what_is_summed_up_is_certified(ask, tmp_path, capsys):
    assert ask('--accuracy', 'bound') == 0
    said = capsys.readouterr().out
    assert ask(output='exact.npz') == 0
    loose, exact = np.load(tmp_path / 'out.npz'), np.load(tmp_path / 'exact.npz')
    least = (loose['distance'] - loose['error_bound']).min()
    assert f'certified lower bounds: least {least:.6g} m' in said
    assert least <= exact['distance'].min()
    for name, part in (('below zero', np.add), ('not certified to be above', np.subtract)):
        share = 100.0 * (part(loose['distance'], loose['error_bound']) < 0.0).mean()
        assert f'{name} {share:.2f} %' in said
    overlap = 100.0 * (exact['distance'] < 0.0).mean()
    assert 100.0 * (loose['distance'] - loose['error_bound'] < 0.0).mean() >= overlap


def test_bad_input_is_said_in_a_line(ask, tmp_path, capsys):
    np.save(tmp_path / 'short.npy', np.zeros((2, 3)))
    np.save(tmp_path / 'posed.npy', np.zeros((2, 3, 7)))
    np.savez(tmp_path / 'tray.npz', poses=np.zeros((2, 1, 7)), frames=['things::tray'])
    (tmp_path / 'rows.csv').write_text('arm::turn\n1\n2,3\n')
    for options, keywords, words in (
        ([], {'file': 'short.npy'}, '3 columns for 4 joints'),
        (['--names', 'arm::x', 'b', 'c'], {'file': 'short.npy'}, "'arm::x' is not one of"),
        ([], {'file': 'posed.npy'}, '--names'),
        (['--names', 'a', 'b', 'c'], {'file': 'posed.npy'}, "no frame 'a'"),
        ([], {'file': 'rows.csv'}, 'row 3 has 2 values'),
        ([], {'output': 'out.txt'}, '.parquet'),
        (['--what', 'points'], {}, 'points'),
        (['--what', 'collision', '--picture', 'x.png'], {}, '--picture'),
        ([], {'file': 'tray.npz'}, 'never had a pose'),
    ):
        assert ask(*options, **keywords) == 2
        assert words in capsys.readouterr().err


@pytest.mark.skipif(
    not importlib.util.find_spec('distributed'), reason="Dask's distributed is not installed"
)
def test_a_scheduler_that_is_not_there_leaves_no_parts_behind(ask, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv('DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT', '1s')
    assert ask('--cluster', 'tcp://127.0.0.1:9') == 2
    assert 'no scheduler at tcp://127.0.0.1:9' in capsys.readouterr().err
    assert not (tmp_path / 'out.npz.parts').exists()
    assert ask() == 0


def test_a_name_of_two_frames_is_refused_with_both(tmp_path, capsys):
    (tmp_path / 'scene.yaml').write_text(
        "sources: [a, 'a::b']\n"
        "frames: [{name: 'b::c', source: a, pose: {}}, {name: c, source: 'a::b', pose: {}},"
        ' {name: d, source: a}]\n'
    )
    np.save(tmp_path / 'poses.npy', [[[0, 0, 0, 0, 0, 0, 1.0]]])
    files = str(tmp_path / 'scene.yaml'), str(tmp_path / 'poses.npy')
    files += '--out', str(tmp_path / 'out.npz')
    assert main(['batch', *files, '--names', 'a::d']) == 0
    capsys.readouterr()
    (tmp_path / 'out.npz').unlink()
    assert main(['batch', *files, '--names', 'a::b::c']) != 0
    told = "'a::b::c' stands for 'b::c' of source 'a' and 'c' of source 'a::b'"
    assert told in capsys.readouterr().err
    assert not (tmp_path / 'out.npz').exists()
