"""``batch --what contacts``: a row for each pair that overlaps, and none that looks free."""

import json

import numpy as np
import pytest
from viewing.scenes import PRESSING

from drake_geom_ros.batch import evaluate
from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from drake_geom_ros.scene_files import load_scene

SURFACES = {
    'area': 'area',
    'centroid': 'centroid',
    'centre_of_pressure': 'centre_of_pressure',
    'force_on_M_W': 'force_on_A_W',
    'torque_on_M_Wo_W': 'torque_on_A_Wo_W',
    'max_pressure': 'max_pressure',
}
# Both balls above the table, one pressed, both, and the bare one alone.
HEIGHTS = [(0.06, 0.06), (0.045, 0.06), (0.04, 0.045), (0.06, 0.04)] * 3


@pytest.fixture
def poses():
    rows = np.zeros((len(HEIGHTS), 2, 7))
    rows[:, :, 6] = 1.0
    rows[:, 1, 0] = 0.2
    rows[:, :, 2] = HEIGHTS
    return rows


@pytest.fixture
def expected(poses):
    scene_graph = SceneGraph()
    frames = load_scene(PRESSING, scene_graph).frames
    ids = [frames['scene', 'ball'], frames['scene', 'bare']]
    return evaluate(scene_graph, ids, poses, want='contacts')


def ask(tmp_path, poses, output, *options):
    (tmp_path / 'scene.yaml').write_text(PRESSING)
    frames = np.array(['scene::ball', 'scene::bare'])
    np.savez(tmp_path / 'states.npz', poses=poses, frames=frames)
    files = [str(tmp_path / name) for name in ('scene.yaml', 'states.npz')]
    return main(['batch', *files, '--what', 'contacts', '--out', str(tmp_path / output), *options])


def test_the_file_has_the_surfaces_of_evaluate_and_the_pairs_without(
    tmp_path, poses, expected, capsys
):
    assert ask(tmp_path, poses, 'out.npz') == 0
    with np.load(tmp_path / 'out.npz') as file:
        found = dict(file)
    surfaces = found['reason'] == 0
    assert 0 < surfaces.sum() < len(surfaces)
    for name, column in SURFACES.items():
        np.testing.assert_array_equal(found[column][surfaces], getattr(expected, name))
        assert np.isnan(found[column][~surfaces]).all()
    for name in ('depth', 'error_bound', 'reason'):
        np.testing.assert_array_equal(found[name][~surfaces], getattr(expected, name))
    assert np.isnan(found['depth'][surfaces]).all()
    assert set(found['reason'].tolist()) == {0, NoSurface.NO_PROPERTIES}
    names = found['geometries'][found['geometry_a']], found['geometries'][found['geometry_b']]
    np.testing.assert_array_equal(names[0][surfaces], expected.name_M)
    np.testing.assert_array_equal(names[1][surfaces], expected.name_N)
    np.testing.assert_array_equal(names[0][~surfaces], expected.name_A)
    np.testing.assert_array_equal(names[1][~surfaces], expected.name_B)
    pairs = np.diff(expected.offsets) + np.diff(expected.point_offsets)
    np.testing.assert_array_equal(np.diff(found['offsets']), pairs)
    state = np.repeat(np.arange(len(poses)), np.diff(found['offsets']))
    of_surfaces = np.repeat(np.arange(len(poses)), np.diff(expected.offsets))
    np.testing.assert_array_equal(state[surfaces], of_surfaces)
    told = json.loads(found['columns'][0])
    assert 'NaN: the pair overlaps and has none' in told['area']
    assert '1 no properties' in told['reason']
    said = capsys.readouterr().out
    assert f'states {len(poses)}\n' in said
    assert 'states with pairs that overlap 9\n' in said
    assert f'PAIRS THAT OVERLAP WITHOUT A SURFACE {len(expected.id_A)}: ' in said
    force = np.linalg.norm(expected.force_on_M_W, axis=1).max()
    assert f'contact surfaces {surfaces.sum()}, largest force {force:.6g} N\n' in said


def test_parquet_has_the_same_rows(tmp_path, poses, expected):
    parquet = pytest.importorskip('pyarrow.parquet')
    assert ask(tmp_path, poses, 'out.parquet') == 0
    assert ask(tmp_path, poses, 'out.npz') == 0
    table = parquet.read_table(tmp_path / 'out.parquet')
    found = np.load(tmp_path / 'out.npz')
    state = np.repeat(np.arange(len(poses)), np.diff(found['offsets']))
    np.testing.assert_array_equal(table['state'].to_numpy(), state)
    np.testing.assert_array_equal(table['area'].to_numpy(), found['area'])
    forces = np.array(table['force_on_A_W'].to_pylist())
    np.testing.assert_array_equal(forces, found['force_on_A_W'])
    names = found['geometries'][found['geometry_b']].tolist()
    assert table['geometry_b'].to_pylist() == names


def test_contacts_have_no_distances_to_draw_or_to_limit(tmp_path, poses, capsys):
    picture = str(tmp_path / 'out.png')
    assert ask(tmp_path, poses, 'out.npz', '--picture', picture) == 2
    assert 'of which --what contacts has none' in capsys.readouterr().err
    assert ask(tmp_path, poses, 'out.npz', '--max-distance', '1') == 2
    assert 'must be infinity' in capsys.readouterr().err
    assert not (tmp_path / 'out.npz').exists()
