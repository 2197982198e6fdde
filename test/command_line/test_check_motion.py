"""``check-motion``: what it tells, its table, its picture and its exit code."""

import csv
import math

import numpy as np
import pytest
from batch.test_paths import ROD, SCENE
from PIL import Image

from drake_geom_ros.command_line.program import main


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp('rods')
    (folder / 'rod.urdf').write_text(ROD)
    (folder / 'scene.yaml').write_text(SCENE)
    np.save(folder / 'clear.npy', [[math.pi, 0.0], [2 * math.pi, 0.0]])
    np.save(folder / 'hit.npy', [[0.0, 0.0], [2 * math.pi, 0.0]])
    return folder


def test_a_clear_path_has_bounds_below_all_distances(folder, capsys):
    table = folder / 'pieces.csv'
    scene, path = str(folder / 'scene.yaml'), str(folder / 'clear.npy')
    code = main(['check-motion', scene, '--path', path, '--csv', str(table), '--pieces', '20'])
    assert code == 0
    assert 'outcome clear\ntimes 1.0 1.0\n' in capsys.readouterr().out
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == 20
    assert {row['outcome'] for row in rows} == {'clear'}
    for row in rows:
        assert 0.0 < float(row['lower_bound']) <= float(row['distance']) + 1e-9


def test_a_contact_is_told_and_drawn(folder, capsys):
    picture = folder / 'hit.png'
    scene, path = str(folder / 'scene.yaml'), str(folder / 'hit.npy')
    asked = ['--picture', str(picture), '--pieces', '50']
    assert main(['check-motion', scene, '--path', path, *asked]) == 1
    out = capsys.readouterr().out
    assert 'outcome contact' in out
    assert 'between' in out
    assert Image.open(picture).size == (960, 480)


def test_what_is_no_path_is_said_in_a_line(folder, capsys):
    np.save(folder / 'out.npy', [[0.0, 99.0]])
    scene, path = str(folder / 'scene.yaml'), str(folder / 'out.npy')
    assert main(['check-motion', scene, '--path', path]) == 2
    error = capsys.readouterr().err
    assert 'rod::push = 99; it is outside its limits' in error
    assert '--ignore-limits lets it pass' in error


SWING = """
joint_names: [turn, push]
points:
- {time_from_start: 0, positions: [3.14159, 0.0], velocities: [0.0, 0.0]}
- {time_from_start: 2, positions: [END, 0.0], velocities: [0.0, 0.0]}
"""


def test_a_trajectory_is_checked_along_its_spline(folder, capsys):
    table, file = folder / 'swing.csv', folder / 'swing.yaml'
    file.write_text(SWING.replace('END', '6.28318'))
    asked = ['--trajectory', str(file), '--csv', str(table), '--pieces', '20']
    assert main(['check-motion', str(folder / 'scene.yaml'), *asked]) == 0
    out = capsys.readouterr().out
    assert 'outcome clear\ntimes 2.0 2.0\n' in out
    assert 'fastest joint rod::turn, at most 2.3' in out  # 1.5 times the mean
    assert 'fastest body rod::' in out
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == 20
    assert {row['outcome'] for row in rows} == {'clear'}
    for row in rows:
        assert 0.0 < float(row['lower_bound']) <= float(row['distance']) + 1e-9
    file.write_text(SWING.replace('END', '0.0'))
    picture = folder / 'swing.png'
    asked = ['--trajectory', str(file), '--plot', str(picture), '--pieces', '30']
    assert main(['check-motion', str(folder / 'scene.yaml'), *asked]) == 1
    assert 'outcome contact' in capsys.readouterr().out
    assert Image.open(picture).size == (960, 480)


def test_a_trajectory_names_its_joints(folder, capsys):
    file = folder / 'other.yaml'
    file.write_text(SWING.replace('END', '6.28318').replace('push', 'pull'))
    scene = str(folder / 'scene.yaml')
    assert main(['check-motion', scene, '--trajectory', str(file)]) == 2
    assert 'pull' in capsys.readouterr().err
    assert main(['check-motion', scene, '--trajectory', str(file), '--names', 'turn']) == 2
    assert '--names goes with --path' in capsys.readouterr().err


CROSSING = """
robots:
  rod:
    joints: [turn]
    waypoints:
    - {at: 0.0, q: [%s]}
    - {at: 2.0, q: [%s]}
"""


def run_motion(folder, begin, *asked, end=6.283185307):
    (folder / 'motion.yaml').write_text(CROSSING % (begin, end))
    scene = str(folder / 'scene.yaml')
    return main(['check-motion', scene, '--motion', str(folder / 'motion.yaml'), *map(str, asked)])


def test_a_motion_file_is_checked_piece_by_piece(folder, capsys):
    table, picture = folder / 'motion.csv', folder / 'motion.png'
    asked = ('--csv', table, '--picture', picture, '--pieces', 80)
    assert run_motion(folder, math.pi, *asked) == 3
    out = capsys.readouterr().out
    assert 'outcome clear in pieces\ntimes 2.0 2.0\n' in out
    assert 'pieces 80, each straight from pose to pose' in out
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == 80
    assert all(0.0 < float(r['lower_bound']) <= float(r['distance']) + 1e-9 for r in rows)
    assert Image.open(picture).size == (960, 480)
    assert run_motion(folder, 0.0) == 1
    out = capsys.readouterr().out
    assert 'outcome contact' in out
    begin, end = map(float, out.splitlines()[1].split()[1:])
    assert 0.0 <= begin < end <= begin + 1e-6 < 2.0


@pytest.mark.parametrize('turns', [0, 4])
def test_no_motion_is_called_clear_by_what_is_seen_of_it(folder, capsys, turns):
    """Whole turns between two looks are seen as rest, and these hit the post."""
    end = math.pi + turns * 2.0 * math.pi
    assert run_motion(folder, math.pi, '--pieces', 1, end=end) == 3
    out = capsys.readouterr().out
    assert 'outcome clear in pieces\ntimes 2.0 2.0\n' in out


def test_what_goes_with_a_path_alone_is_refused_for_a_motion(folder, capsys):
    assert run_motion(folder, math.pi, '--ignore-start-contacts') == 2
    assert '--ignore-start-contacts goes with --path' in capsys.readouterr().err
