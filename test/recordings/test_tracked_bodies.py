"""Reports of recordings with tracked bodies: those that come and go, silent trackers."""

import numpy as np
import pytest
from recordings import recorder

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.recordings import Topics, clearance

TOPIC, SCENE_TOPIC = '/node/tracked_objects', '/node/scene'
CELL = """
frames: [{name: hand, source: arm, pose: {}}]
geometries:
- {name: hand, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: floor, source: cell, shape: {type: half_space}, pose: {position: [0, 0, -5]}}
"""
REST = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


@pytest.fixture
def cell(tmp_path):
    file = tmp_path / 'cell.yaml'
    file.write_text(CELL)
    return file


def tracked(seconds, bodies, lifetime=0.5, frame=''):
    """Return a TrackedObjects of balls {name: x}."""
    kinds = recorder._Kinds()
    shape = {'type': 1, 'dimensions': np.array([0.1])}
    return kinds.TrackedObjects(
        header=recorder.header(seconds, frame),
        names=list(bodies),
        shapes=[kinds.Shape(**shape) for _ in bodies],
        poses=np.array([[x, *REST[1:]] for x in bodies.values()], dtype=float).ravel(),
        velocities=np.zeros(0),
        lifetimes=np.full(len(bodies), lifetime),
    )


def run_of(folder, times, said, more=()):
    """Record a hand at rest, and what trackers ``said`` at which times."""
    poses = [(t, '/node/frame_poses', recorder.frame_poses(t, ['hand'], [REST])) for t in times]
    bodies = [(t, TOPIC, message) for t, message in said]
    return recorder.record(folder, sorted([*poses, *bodies, *more], key=lambda each: each[0]))


def test_bodies_come_and_go_in_a_report_as_in_the_node(tmp_path, cell):
    said = [
        (0.05, tracked(0.05, {'anna': 3.0})),
        (0.45, tracked(0.45, {'anna': 2.0, 'ben': 1.0})),
        (0.85, tracked(0.85, {'anna': 2.5})),
    ]
    # The distances are taken with each message of poses, and of bodies.
    times = [0.1, 0.3, 0.5, 0.7, 0.9, 1.1]
    over = clearance(run_of(tmp_path / 'run', times, said), cell, between=['arm:tracked'])
    pairs = over['arm:tracked']
    at = dict(zip(np.round(pairs.times + 0.05, 6).tolist(), pairs.distance.tolist(), strict=True))
    expected = {0.1: 2.8, 0.3: 2.8, 0.5: 0.8, 0.7: 0.8, 0.9: 0.8, 1.1: 2.3}
    assert {t: at[t] for t in expected} == pytest.approx(expected)
    assert over.reservations() == []


def test_no_body_is_no_pair_and_a_silent_tracker_is_stale(tmp_path, cell):
    said = [(0.15, tracked(0.15, {'anna': 3.0})), (0.9, tracked(0.9, {}))]
    times = np.arange(0.1, 3.0, 0.2).tolist()
    over = clearance(
        run_of(tmp_path / 'run', times, said), cell, between=['arm:tracked'], stale_after=1.0
    )
    pairs = over['arm:tracked']
    first, silent = pairs.times < 0.04, pairs.times + 0.1 > 1.95
    assert pairs.is_waiting[first].all(), 'nobody knows who is there before the tracker speaks'
    assert pairs.is_stale[silent].all()
    assert np.isnan(pairs.distance[silent]).all()
    told = ' '.join(over.reservations())
    assert 'these never had a pose until then: tracked::heartbeat' in told
    assert 'states are stale' in told
    assert 'queries report no pair of the set' in told


def test_a_set_of_one_body_is_empty_while_it_is_away(tmp_path, cell):
    said = [(0.05, tracked(0.05, {})), (0.45, tracked(0.45, {'ben': 1.0}))]
    run = run_of(tmp_path / 'run', [0.1, 0.3, 0.5, 0.7], said)
    pairs = clearance(run, cell, between=['arm:tracked::ben'])['arm:tracked::ben']
    np.testing.assert_allclose(pairs.distance[pairs.times > 0.42], 0.8)
    assert np.isnan(pairs.distance[pairs.times < 0.35]).all()
    with pytest.raises(ArgumentError, match="'bob' stands for no geometry"):
        clearance(run, cell, between=['arm:bob'])


def test_bodies_in_another_frame_are_a_reservation(tmp_path, cell):
    said = [(0.05, tracked(0.05, {'anna': 3.0}, frame='camera'))]
    told = clearance(run_of(tmp_path / 'run', [0.1, 0.2], said), cell).reservations()
    assert any("header.frame_id is 'camera'" in each for each in told)


def test_bodies_of_a_topic_that_is_left_out_are_a_difference_of_scenes(tmp_path, cell):
    scene = recorder.scene(cell)
    kinds = recorder._Kinds()
    scene.sources.append(kinds.SceneSource(id=900, name='tracked'))
    for k, name in enumerate(['heartbeat', 'anna']):
        world = next(f.id for f in scene.frames if f.id == f.parent_id)
        frame = {'id': 901 + k, 'name': name, 'source_id': 900, 'parent_id': world}
        scene.frames.append(kinds.SceneFrame(**frame))
    said = [(0.05, tracked(0.05, {'anna': 3.0}))]
    run = run_of(tmp_path / 'run', [0.1, 0.2], said, [(0.12, SCENE_TOPIC, scene)])
    assert clearance(run, cell).reservations() == []
    told = clearance(run, cell, topics=Topics(tracked_objects='')).reservations()
    assert any('tracked::anna' in each for each in told)
