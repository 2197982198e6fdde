"""Results with names: arrays, records, parts of them."""

from copy import copy
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from ros.demo import demo_scenes as scenes

from drake_geom_ros.client.left_out import IncompleteError
from drake_geom_ros.client.results import Penetrations, PointDistances, SignedDistances
from drake_geom_ros.client.scene_table import UnknownNameError

TABLE = scenes.table(version=3)
HEADER = Some(stamp=Some(sec=12, nanosec=500_000_000))
WHOLE = {'waiting_frames': [], 'waiting_pairs': 0, 'waiting_geometries': 0,
         'shell_points': 0, 'least_shell_distance': np.inf}  # fmt: skip
COMMON = {
    **WHOLE,
    'header': HEADER,
    'scene_version': 3,
    'oldest_pose_age': 0.25,
    'oldest_frame': 0,
    'method': [1, 2, 4],
}
DISTANCES = SignedDistances(
    Some(
        **COMMON,
        max_distance=0.5,
        id_a=[1, 1, 3],
        id_b=[3, 5, 5],
        distance=[0.3, 0.1, 0.2],
        error_bound=[0.0, 0.0, 0.15],
        p_aca=np.arange(9.0),
        p_bcb=np.arange(9.0) + 10,
        nhat_ba_w=[0.0, 0.0, 1.0] * 3,
    ),
    TABLE,
)


def test_a_record_has_names_sources_points_and_the_certified_bound():
    pair = DISTANCES[2]
    assert (pair.source_a, pair.name_a) == ('right', 'hand/ball')
    assert (pair.source_b, pair.name_b) == ('room', 'world/table')
    assert (pair.id_a, pair.id_b, pair.distance, pair.error_bound) == (3, 5, 0.2, 0.15)
    assert pair.lower_bound == pytest.approx(0.05)
    assert pair.p_ACa.tolist() == [6, 7, 8]
    assert pair.p_BCb.tolist() == [16, 17, 18]
    assert pair.nhat_BA_W.tolist() == [0, 0, 1]


def test_what_holds_for_all_rows():
    assert (DISTANCES.stamp, DISTANCES.oldest_pose_age, DISTANCES.scene_version) == (12.5, 0.25, 3)
    assert DISTANCES.max_distance == 0.5
    np.testing.assert_allclose(DISTANCES.lower_bound, [0.3, 0.1, 0.05])
    assert len(DISTANCES) == 3
    assert [pair.id_b for pair in DISTANCES] == [3, 5, 5]
    assert DISTANCES[-1].id_a == DISTANCES[1:][1].id_a == 3
    with pytest.raises(IndexError):
        DISTANCES[3]


def test_the_closest_is_that_of_the_least_lower_bound():
    assert DISTANCES.closest().id_a == 3
    assert DISTANCES.between('left', 'things').closest() is None


def test_a_name_that_stands_for_nothing_is_no_free_space():
    for ask in (DISTANCES.between, lambda name: DISTANCES.between('left', name)):
        with pytest.raises(UnknownNameError, match=r"'rigth' stands for .*; nearest: 'right'"):
            ask('rigth')


def left_out(frames):
    """Return the distances of a message that leaves pairs of these frames out."""
    message = vars(DISTANCES._message) | {'waiting_frames': frames, 'waiting_pairs': 4}
    return SignedDistances(Some(**message), TABLE)


def test_what_is_left_out_is_no_free_space():
    found = left_out(['things::can'])
    assert (found.is_complete, found.waiting_pairs) == (False, 4)
    assert found.waiting_frames == ('things::can',)
    for less in (found, found.between('things'), found.between('left'), found[:0], found[1:]):
        assert not less.is_complete
        with pytest.raises(IncompleteError, match=r'4 pairs are left out .*: things::can'):
            less.closest()
    assert found.closest(allow_incomplete=True).id_a == DISTANCES.closest().id_a
    assert found
    with pytest.raises(IncompleteError, match='no row: '):
        bool(found[:0])
    assert not DISTANCES[:0]
    # Of what has poses all is there.
    whole = found.between('left', 'right')
    assert whole.is_complete
    assert whole.closest().id_b == 3
    assert not whole.between('left', 'left')


def test_points_beside_bodies_are_no_free_space_where_a_map_may_be_near():
    table, beside = copy(TABLE), {'shell_points': 7, 'least_shell_distance': 0.02}
    first = next(iter(table.geometries))
    table.geometries = dict(TABLE.geometries)
    message = Some(**vars(DISTANCES._message) | beside)
    found = SignedDistances(message, table)
    assert (found.is_complete, found.shell_points, found.least_shell_distance) == (False, 7, 0.02)
    for less in (found, found[:0], found[1:]):
        with pytest.raises(IncompleteError, match=r'7 points of sensors are beside .* 0\.02 m'):
            less.closest()
    assert found.between('left').is_complete  # no map is among these
    table.geometries[first] = replace(table.geometries[first], source='obstacles')
    assert not found.between('*').is_complete


@pytest.mark.parametrize(
    ('names', 'rows'),
    [
        (('left', 'right'), [0]),
        (('right', 'left'), [0]),
        (('room',), [1, 2]),
        (('hand', 'hand'), [0]),
        (('left', 'left'), []),
        (('room::table', '*::hand/*'), [1, 2]),
    ],
)
def test_pairs_between_two_names(names, rows):
    found = DISTANCES.between(*names)
    assert found.distance.tolist() == DISTANCES.distance[rows].tolist()
    assert found.method.tolist() == DISTANCES.method[rows].tolist()


def test_penetrations():
    found = Penetrations(
        Some(
            **COMMON,
            id_a=[1, 1, 2],
            id_b=[3, 5, 5],
            depth=[0.1, 0.2, 0.3],
            error_bound=[0.0, 0.1, 0.2],
            p_wca=np.arange(9.0),
            p_wcb=np.arange(9.0),
            nhat_ba_w=np.arange(9.0),
        ),
        TABLE,
    )
    (pair,) = found.between('left::arm')
    assert (pair.name_a, pair.source_b, pair.depth, pair.error_bound) == (
        'arm/rod',
        'room',
        0.3,
        0.2,
    )
    assert pair.p_WCa.tolist() == pair.p_WCb.tolist() == [6, 7, 8]


def test_points():
    found = PointDistances(
        Some(
            **COMMON,
            query_stamp=Some(sec=7, nanosec=0),
            point_index=[0, 0, 1],
            id_g=[1, 5, 5],
            distance=[0.1, 0.2, 0.3],
            error_bound=[0.0, 0.0, 0.1],
            p_gn=np.arange(9.0),
            grad_w=np.arange(9.0),
        ),
        TABLE,
    )
    assert found.query_stamp == 7.0
    with pytest.raises(UnknownNameError, match="nearest: 'room'"):
        found.to('roam')
    point = found.to('room')[1]
    assert (point.point_index, point.source, point.name) == (1, 'room', 'world/table')
    assert point.lower_bound == pytest.approx(0.2)
    assert point.p_GN.tolist() == point.grad_W.tolist() == [6, 7, 8]
    message = vars(found._message) | {'waiting_frames': ['left::hand'], 'waiting_geometries': 1}
    found = PointDistances(Some(**message), TABLE)
    assert (found.is_complete, found.waiting_geometries) == (False, 1)
    assert found.to('room').is_complete
    assert not found.to('left').is_complete
