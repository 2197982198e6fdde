"""Results as data frames, as text and in notebooks, with names beside ids."""

import re

import numpy as np
import pytest
from batch.conftest import Cell

from drake_geom_ros.batch import Checker, PathChecker, evaluate
from drake_geom_ros.common.tables import flat_columns, html_table
from drake_geom_ros.geometry import FramePoseVector, GeometryError, SceneGraph
from drake_geom_ros.geometry._proximity.pairs.answer_rows import ANSWER_WIDTH
from drake_geom_ros.geometry.queries.query_results import SignedDistanceResults


@pytest.fixture(scope='module')
def query(cell):
    return next(cell.each(cell.states(1)))


def results_of(cell, query):
    states = {'states': cell.states(6), 'joints': cell.joints}
    return {
        'least': evaluate(cell.scene_graph, want='least', by_joints=True, **states),
        'within': evaluate(cell.scene_graph, want='within', max_distance=0.5, **states),
        'points': evaluate(cell.scene_graph, want='points', points=[[0, 0, 1]], **states),
        'distances': query.ComputeSignedDistancePairwiseClosestPoints(),
        'penetrations': query.ComputePointPairPenetration(),
        'point distances': query.ComputeSignedDistanceToPoint([[0, 0, 1], [0.5, 0, 0]]),
    }


def test_columns_have_a_row_each_and_names_beside_ids(cell, query):
    names = {'::'.join(key[:2]) + '/' + key[2] for key in cell.loaded.geometries}
    for kind, results in results_of(cell, query).items():
        columns = results.columns()
        count = len(next(iter(columns.values())))
        assert {len(values) for values in columns.values()} == {count}, kind
        ids = [name for name in columns if name.startswith('id_')]
        assert ids, kind
        for name in ids:
            assert set(columns[name.replace('id_', 'name_')]) <= names, kind
            named = columns[name.replace('id_', 'name_')].tolist()
            assert named == cell.scene_graph.model_inspector().full_names(columns[name]), kind


def test_states_of_rows_are_those_of_the_offsets(cell, query):
    within = results_of(cell, query)['within']
    expected = np.repeat(np.arange(6), np.diff(within.offsets))
    np.testing.assert_array_equal(within.columns()['state'], expected)


def test_data_frames_have_all_columns(cell, query):
    pytest.importorskip('pandas', reason='the extra dataframes')
    for kind, results in results_of(cell, query).items():
        frame = results.to_dataframe()
        columns = flat_columns(results.columns())
        assert list(frame.columns) == list(columns), kind
        for name, values in columns.items():
            np.testing.assert_array_equal(frame[name].to_numpy(), values)
    least = results_of(cell, query)['least'].to_dataframe()
    assert {'p_WCa_x', 'gradient_11', 'joint_gradient_3', 'name_A'} <= set(least.columns)


def test_notebooks_show_the_ten_nearest_by_name(cell, query):
    for kind, results in results_of(cell, query).items():
        text = results._repr_html_()
        rows = re.findall(r'<tr>(?!<th>)(.*?)</tr>', text)
        columns = results.columns()
        key = columns['distance'] if 'distance' in columns else -columns['depth']
        assert len(rows) == min(10, len(key)), kind
        some = next(name for name in columns if name.startswith('name_'))
        for row, k in zip(rows, np.argsort(key, kind='stable'), strict=False):
            assert f'<td>{abs(key[k]):.6g}</td>' in row.replace('<td>-', '<td>'), kind
            assert f'<td>{columns[some][k]}</td>' in row, kind


def test_texts_say_how_many(cell, query):
    results = results_of(cell, query)
    assert repr(results['least']).startswith('<LeastDistances: 6 rows of 6 states, the nearest ')
    count = len(results['within'].distance)
    assert repr(results['within']).startswith(f'<PairsOfStates: {count} rows of 6 states')
    assert (
        repr(results['distances'])
        == f'<SignedDistanceResults of {len(results["distances"])} results>'
    )
    none = evaluate(
        cell.scene_graph,
        want='within',
        max_distance=-9.0,
        states=cell.states(2),
        joints=cell.joints,
    )
    assert repr(none) == '<PairsOfStates: 0 rows of 2 states>'
    assert none._repr_html_().count('<tr>') == 1
    inspector = cell.scene_graph.model_inspector()
    assert repr(cell.scene_graph).startswith(
        f'<SceneGraph: {inspector.num_sources()} sources, {inspector.num_frames()} frames, '
        f'{inspector.num_geometries()} geometries'
    )
    assert '<td>things</td>' in cell.scene_graph._repr_html_()
    assert repr(cell.joints).startswith('<Joints: 4 of 1 robots, arm::turn')
    assert '<td>arm::turn</td>' in cell.joints._repr_html_()
    checker = Checker(cell.scene_graph, cell.joints, 0.02)
    assert f'{len(checker.pairs)} pairs, margin 0.02 m' in repr(checker)
    assert checker._repr_html_().count('<tr>') == 11
    assert '4 joints' in repr(PathChecker(cell.scene_graph, cell.joints))


def test_names_are_those_of_the_context_and_none_are_made_up():
    own = Cell()
    context = own.scene_graph.CreateDefaultContext()
    (poses,) = own.joints.poses(own.states(1))
    context.UpdateFramePoses(FramePoseVector.FromArrays(own.joints.frame_ids, poses))
    query = own.scene_graph.get_query_output_port().Eval(context)
    results = query.ComputeSignedDistancePairwiseClosestPoints()
    before = results.name_A.tolist()
    assert results.penetrations().columns()['name_A'].tolist() == [
        name for name, distance in zip(before, results.distance, strict=True) if distance < 0.0
    ]
    wall = own.loaded.geometries['things', 'world', 'wall']
    source = own.loaded.sources['things']
    own.scene_graph.RemoveGeometry(source, wall)
    assert results.name_A.tolist() == before
    own.scene_graph.RemoveGeometry(context, source, wall)
    with pytest.raises(GeometryError):
        _ = results.columns()
    unknown = SignedDistanceResults(np.zeros((0, ANSWER_WIDTH)))
    assert 'name_A' not in unknown.columns()
    with pytest.raises(GeometryError, match='know no scene'):
        _ = unknown.name_A


def test_texts_in_tables_are_escaped():
    assert '&lt;b&gt;' in html_table('a', {'<b>': ['x']})
    assert '<td>&amp;</td>' in html_table('a', {'b': ['&']})
    assert repr(SceneGraph()).startswith('<SceneGraph: 1 sources')
