"""Clouds to distances on a live scene, without ROS."""

import warnings
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.conversions.test_point_cloud import cloud
from live.live_scenes import Topic, live_scene

from drake_geom_ros.live.inputs.point_queries import PointQueries
from drake_geom_ros.live.scene import point_blocks

TEXT = """
frames:
  - {name: hand, pose: {position: [1, 0, 0], quaternion: [0, 0, 1, 0]}}
geometries:
  - {name: ball, frame: hand, shape: {type: sphere, radius: 0.1}}
  - {name: floor, shape: {type: half_space}}
"""


def empty_result():
    return Plain(header=Plain(frame_id='', stamp=None))


@pytest.fixture
def live():
    return live_scene(TEXT, world_frame='map')


@pytest.fixture
def done():
    return []


def queries_of(live, listeners, done, is_active=lambda: True):
    """Return queries that answer to so many listeners, and put what they did into ``done``."""

    def did(count, seconds):
        assert seconds > 0.0
        done.append(count)

    return PointQueries(
        live, Topic(listeners), empty_result, lambda: 0.5, is_active=is_active, did=did
    )


@pytest.fixture
def queries(live, done):
    return queries_of(live, 1, done)


def distances(scene, message):
    """Return {(point, geometry): distance} by names."""
    names = {id.get_value(): name for id, name in scene.model.names.geometry_names.items()}
    pairs = zip(message.point_index, message.id_g, message.distance, strict=True)
    return {(k, names[g].split('/')[1]): pytest.approx(d, abs=1e-12) for k, g, d in pairs}


def test_points_in_the_world(scene, queries):
    message = queries.answer(cloud(np.array([[1, 0, 0.3], [5, 5, 5], [9, 9, -0.1]]), kind='f8'))
    assert distances(scene, message) == {(0, 'ball'): 0.2, (0, 'floor'): 0.3, (2, 'floor'): -0.1}
    assert message.threshold == 0.5
    assert message.header.frame_id == 'map'
    assert message.scene_version == scene.model.version


def test_an_answer_bears_the_stamp_of_its_cloud(queries):
    points = cloud(np.zeros((1, 3)))
    points.header.stamp = Plain(sec=5, nanosec=6)
    assert queries.answer(points).query_stamp is points.header.stamp


def test_points_in_a_frame(scene, queries):
    points = cloud(np.array([[0.2, 0, 0.2]]), kind='f8')
    points.header.frame_id = 'hand'
    found = distances(scene, queries.answer(points))
    assert found == {(0, 'ball'): np.hypot(0.2, 0.2) - 0.1, (0, 'floor'): 0.2}
    points.header.frame_id = 'map'
    assert distances(scene, queries.answer(points)) == {(0, 'floor'): 0.2}


def test_points_that_are_not_finite_are_skipped_and_counted(scene, queries):
    points = np.array([[np.nan, 0, 0], [1, 0, 0.3], [np.inf, 0, 0], [0, 0, 0.1]])
    found = distances(scene, queries.answer(cloud(points)))
    assert {point for point, _ in found} == {1, 3}


def test_blocks_of_points_answer_as_all_at_once(scene, queries, monkeypatch):
    points = cloud(np.random.default_rng(4).uniform(-1, 1, (50, 3)))
    whole = queries.answer(points)
    monkeypatch.setattr(point_blocks, 'ROWS_AT_ONCE', 7)
    blocks = queries.answer(points)
    assert len(whole.point_index) > 20
    for name in ('point_index', 'id_g', 'p_gn', 'distance', 'grad_w', 'is_grad_w_unique'):
        assert list(getattr(blocks, name)) == list(getattr(whole, name))


def test_an_empty_cloud_has_an_empty_answer(queries):
    assert list(queries.answer(cloud(np.zeros((0, 3)))).id_g) == []


def test_a_wrong_cloud_is_refused(queries):
    points = cloud(np.ones((4, 3)))
    points.header.frame_id = 'nobody'
    with pytest.raises(RuntimeError, match='nobody'):
        queries.take(points)
    assert queries._publisher.published == []


def test_nothing_is_computed_for_nobody(live, done):
    deaf = queries_of(live, 0, done)
    deaf.take(Plain())
    assert deaf._publisher.published == []
    assert done == []


@pytest.mark.parametrize('states', [(False,), (True, False)])
def test_an_inactive_node_publishes_nothing_not_even_what_it_had_begun(live, done, states):
    state = iter(states)
    queries = queries_of(live, 1, done, is_active=lambda: next(state))
    queries.take(cloud(np.zeros((1, 3))))
    assert queries._publisher.published == []
    assert done == []


def test_an_answer_is_published_and_told_of(queries, done):
    queries.take(cloud(np.zeros((1, 3))))
    (message,) = queries._publisher.published
    assert done == [len(message.distance)] == [1]


def test_what_waits_for_a_pose_is_left_out(done):
    live = live_scene(TEXT.replace(', pose: {position: [1, 0, 0], quaternion: [0, 0, 1, 0]}', ''))
    queries = queries_of(live, 1, done)
    with live.reading() as scene:
        found = distances(scene, queries.answer(cloud(np.array([[0, 0, 0.25]]))))
    assert found == {(0, 'floor'): 0.25}
    points = cloud(np.zeros((1, 3)))
    points.header.frame_id = 'hand'
    with pytest.raises(RuntimeError, match=r"'hand' .* never had a pose"):
        queries.take(points)


def test_more_distances_than_an_answer_holds_are_refused(queries, monkeypatch):
    monkeypatch.setattr(point_blocks, 'ROWS_AT_ONCE', 4)
    monkeypatch.setattr(point_blocks, '_MOST_ROWS', 6)
    queries._threshold = lambda: 100.0
    assert len(queries.answer(cloud(np.zeros((3, 3)))).distance) == 6
    with pytest.raises(RuntimeError, match=r'4 points have more than 6 distances up to 100.0 m'):
        queries.answer(cloud(np.zeros((4, 3))))


@pytest.mark.parametrize('frame', ['', 'hand'])
def test_points_that_are_not_finite_are_skipped_without_a_warning(queries, frame):
    points = [(np.nan, 0, 0), (np.inf, -np.inf, 0), (0.3, 0, 0), (0, np.inf, np.nan)]
    message = cloud(points)
    message.header.frame_id = frame
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        found = queries.answer(message)
    assert set(found.point_index) == {2}
