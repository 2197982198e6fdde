"""Tables: names and numbers of the queries, as CSV and as JSON."""

import csv
import io
import json
import math

import numpy as np
import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.command_line.answers import (
    KINDS,
    QueryOptions,
    write_csv,
    write_json,
    write_table,
)
from drake_geom_ros.command_line.opened_scene import OpenedScene


@pytest.fixture(scope='module')
def scene():
    return OpenedScene(str(ROOT / 'scenes/minimal.yaml'))


def ask(scene, what, limit=10.0, points=None, **asked):
    return KINDS[what](scene, QueryOptions(limit, points=points, **asked))


def test_distances_name_both_and_give_points_in_the_world(scene):
    table = ask(scene, 'distance', 0.5)
    assert table['geometry_a'] == ['scene::world/post']
    assert table['geometry_b'] == ['scene::ball/ball']
    assert table['distance'] == pytest.approx([0.35], abs=1e-13)
    np.testing.assert_allclose(table['p_wca'], [[0.05, 0, 1]], rtol=0, atol=1e-13)
    np.testing.assert_allclose(table['p_wcb'], [[0.4, 0, 1]], rtol=0, atol=1e-13)
    assert table['method'] == ['closed_form']


def test_the_nearest_pairs_are_those_with_the_smallest_lower_bounds(scene):
    every = ask(scene, 'distance')
    lower = every['distance'] - every['error_bound']
    for count in (1, 2, 10):
        table = ask(scene, 'nearest', count=count)
        assert (table['distance'] - table['error_bound']).tolist() == sorted(lower)[:count]
        rows = [every['distance'].tolist().index(d) for d in table['distance'].tolist()]
        assert table['geometry_a'] == [every['geometry_a'][row] for row in rows]
        np.testing.assert_array_equal(table['p_wca'], every['p_wca'][rows])
    assert ask(scene, 'least')['distance'].tolist() == ask(scene, 'nearest')['distance'].tolist()
    assert ask(scene, 'least', limit=0.1)['geometry_a'] == []


HALF_SPACES = """
frames: [{name: f, source: s, pose: {position: [0, 0, -0.01], rpy: [{ROLL}, 0, 0]}}]
geometries:
- {name: floor, shape: {type: half_space}, pose: {position: [0, 0, -0.5]}}
- {name: roof, source: s, frame: f, shape: {type: half_space}}
- {name: ball, shape: {type: sphere, radius: 0.1}, pose: {position: [0, 0, 5]}}
"""


@pytest.mark.parametrize(('roll', 'distance'), [(math.pi, 0.49), (3.0, -math.inf)])
def test_the_nearest_pairs_may_be_half_spaces(tmp_path, roll, distance):
    path = tmp_path / 'planes.yaml'
    path.write_text(HALF_SPACES.replace('{ROLL}', repr(roll)))
    table = ask(OpenedScene(str(path)), 'nearest', count=9)
    planes = [{'floor', 'roof'} == {a.split('/')[1], b.split('/')[1]} for a, b in pairs_of(table)]
    assert table['distance'][planes].tolist() == [pytest.approx(distance)]
    assert len(planes) == 2  # with the ball and the roof; the ball and the floor are anchored
    lower = table['distance'] - table['error_bound']
    assert lower.tolist() == sorted(lower)
    file = io.StringIO()
    write_json([(None, table)], False, file)
    (moment,) = json.loads(file.getvalue(), parse_constant=pytest.fail)
    assert [float(row['distance']) for row in moment['rows']] == table['distance'].tolist()


def pairs_of(table):
    return list(zip(table['geometry_a'], table['geometry_b'], strict=True))


def test_points_are_answered_by_index(scene):
    points = np.array([[0.5, 0, 2.0], [9, 9, 9.0]])
    table = ask(scene, 'points', 1.0, points)
    assert list(table['point_index']) == [0]
    assert table['geometry'] == ['scene::ball/ball']
    assert table['distance'] == pytest.approx([0.9])
    np.testing.assert_allclose(table['p_gn'], [[0, 0, 0.1]], rtol=0, atol=1e-13)


def test_nothing_overlaps_there(scene):
    assert ask(scene, 'collisions')['has_collisions'].tolist() == [False]
    assert ask(scene, 'penetration')['geometry_a'] == []
    assert ask(scene, 'candidates')['geometry_a'] == []


TABLE = {'name': ['a', 'b'], 'p': np.array([[1.0, 2, 3], [0.1, 0.2, 0.3]]), 'd': np.array([5, 6])}


def test_csv_has_a_column_an_axis_and_the_time_where_there_is_one():
    file = io.StringIO()
    write_csv([(0.0, TABLE), (0.5, TABLE)], True, file)
    rows = list(csv.reader(io.StringIO(file.getvalue())))
    assert rows[0] == ['time', 'name', 'p_x', 'p_y', 'p_z', 'd']
    assert rows[1] == ['0.0', 'a', '1.0', '2.0', '3.0', '5']
    assert rows[4] == ['0.5', 'b', '0.1', '0.2', '0.3', '6']
    file = io.StringIO()
    write_csv([(None, TABLE)], False, file)
    assert file.getvalue().startswith('name,p_x')


def test_json_has_an_object_a_moment():
    file = io.StringIO()
    write_json([(None, TABLE), (0.5, TABLE)], True, file)
    first, second = json.loads(file.getvalue())
    assert first == {
        'time': None,
        'rows': [
            {'name': 'a', 'p': [1, 2, 3], 'd': 5},
            {'name': 'b', 'p': [0.1, 0.2, 0.3], 'd': 6},
        ],
    }
    assert second['time'] == 0.5


def test_every_number_is_written_with_all_its_digits():
    file = io.StringIO()
    write_csv([(None, {'d': np.array([1 / 3])})], False, file)
    assert float(file.getvalue().splitlines()[1]) == 1 / 3


def test_a_table_for_people_has_aligned_columns_and_short_numbers():
    file = io.StringIO()
    write_table([(None, TABLE)], False, file)
    assert file.getvalue().splitlines() == [
        'name  p_x  p_y  p_z  d',
        'a     1    2    3    5',
        'b     0.1  0.2  0.3  6',
    ]
