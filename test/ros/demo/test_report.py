import csv

import numpy as np
from matplotlib.image import imread
from ros.demo import demo_scenes as scenes

from drake_geom_ros.ros.demo.report import COLUMNS, write_report, write_results
from drake_geom_ros.scene_files import read_scene

SCENE = """
sources: [left, right]
frames: [{name: hand, source: left}, {name: hand, source: right}]
geometries:
- {name: ball, source: left, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: right, frame: hand, shape: {type: sphere, radius: 0.1}}
"""
CAMERA = """
cameras:
- {name: eye, frame: "left::hand", pose: {position: [0, 0, -2]}, size: [64, 48], shows: proximity}
"""


def test_three_files_and_what_they_hold(tmp_path):
    said = write_report(scenes.recording(), tmp_path / 'out' / 'demo', scenes.DESCRIPTION)
    names = {path.name for path in (tmp_path / 'out' / 'demo').iterdir()}
    assert names == {'results.csv', 'distances.png', 'closest.png'}
    assert '120 rows of 40 results' in said[0]
    assert 'deepest penetration 2.00 mm, 2 filter changes' in said[1]
    assert 'left::hand - right::hand' in said[2]
    assert 'cycle p50 20.50 ms' in said[3]


def test_without_a_closest_moment_the_picture_is_left_out(tmp_path):
    made = scenes.recording()
    made.approach = None
    write_report(made, tmp_path, scenes.DESCRIPTION)
    assert {path.name for path in tmp_path.iterdir()} == {'results.csv', 'distances.png'}


def test_the_first_camera_of_the_scene_is_shown_at_the_closest_moment(tmp_path):
    said = write_report(scenes.recording(), tmp_path, read_scene(SCENE + CAMERA))
    assert any('camera.png' in line and 'eye' in line for line in said)
    pixels = imread(tmp_path / 'camera.png')
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 50


def test_a_scene_without_cameras_leaves_no_such_picture(tmp_path):
    write_report(scenes.recording(), tmp_path, read_scene(SCENE))
    assert not (tmp_path / 'camera.png').exists()


def test_every_kept_pair_is_a_row_with_its_depth(tmp_path):
    made = scenes.recording()
    rows_written = write_results(made, tmp_path / 'results.csv')
    with open(tmp_path / 'results.csv', newline='') as file:
        reader = csv.DictReader(file)
        assert tuple(reader.fieldnames) == COLUMNS
        rows = list(reader)
    assert len(rows) == rows_written == sum(len(pairs.distance) for pairs in made.pairs)
    deep = [row for row in rows if row['depth']]
    assert [float(row['time']) for row in deep] == [1.0, 1.1, 1.2, 3.0]
    for row in deep:
        assert (row['geometry_a'], row['geometry_b']) == ('left::hand/ball', 'things::can/can')
        assert float(row['depth']) == -float(row['distance']) == 0.002
        assert row['method'] == '2'
    hands = [float(r['distance']) for r in rows if r['geometry_b'] == 'right::hand/ball'
             and r['geometry_a'] == 'left::hand/ball']  # fmt: skip
    np.testing.assert_allclose(hands, 0.3 - 0.005 * np.arange(40))
