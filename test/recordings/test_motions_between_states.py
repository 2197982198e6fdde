"""What lies between states is proved, or told to be unknown."""

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import HERE, balls, poses, random_rows  # noqa: F401

from drake_geom_ros.geometry import ArgumentError, FramePoseVector, SceneGraph
from drake_geom_ros.recordings import clearance, states
from drake_geom_ros.scene_files import load_scene

PAST = [(-0.5, 0, 0), (0.5, 0, 0)]  # through the box, and no state of it does


def rows_of(places):
    return [(*place, 0, 0, 0, 1) for place in places]


def test_what_no_state_shows_is_found_between(tmp_path, balls):  # noqa: F811
    rows = [[row, HERE] for row in rows_of(PAST)]
    run = recorder.record(tmp_path / 'run', poses([0.0, 0.5], 'ab', rows))
    found = clearance(run, balls, between=['a:b'], certify=0.001)
    assert found.least().distance > 0.2
    told = found['a:b'].certified()
    assert (told.clear, told.contact, told.unknown) == (0, 1, 0)
    assert np.isnan(told.lower_bound)
    with pytest.raises(ArgumentError, match='not certified'):
        clearance(run, balls)['all'].certified()
    with pytest.raises(ArgumentError, match='certify'):
        clearance(run, balls, certify=-1.0)


def test_no_pose_between_the_moments_of_a_rate_is_left_out(tmp_path, balls):  # noqa: F811
    # Through the box and back again, between two moments of 2 Hz.
    x = [-0.5, 0.5, -0.5, -0.5]
    rows = [[row, HERE] for row in rows_of([(each, 0, 0) for each in x])]
    run = recorder.record(tmp_path / 'run', poses([0.0, 0.2, 0.4, 0.6], 'ab', rows))
    with pytest.raises(ArgumentError, match=r'rate=2.0 leaves out poses'):
        clearance(run, balls, between=['a:b'], certify=0.001, rate=2.0)
    told = clearance(run, balls, between=['a:b'], certify=0.001)['a:b'].certified()
    assert (told.clear, told.contact, told.unknown) == (1, 2, 0)


def test_each_motion_is_that_of_check_motion(tmp_path, balls, monkeypatch):  # noqa: F811
    rows, times = random_rows(30, 2, seed=2), 0.1 * np.arange(30)
    rows[10:15] = rows[10]  # at rest
    run = recorder.record(tmp_path / 'run', poses(times, 'ab', rows))
    found = clearance(run, balls, between=['a:b'], certify=0.001)['a:b']
    graph = SceneGraph()
    loaded = load_scene(balls, graph)
    frames = [loaded.frames['s', name] for name in 'ab']
    seen = {0: 0, 1: 0, 2: 0}
    for k in range(1, 30):
        context = graph.CreateSharedContext(partial=True)
        context.UpdateFramePoses(FramePoseVector.FromArrays(frames, rows[k - 1]))
        query = graph.get_query_output_port().Eval(context)
        ends = FramePoseVector.FromArrays(frames, rows[k])
        check = query.CheckMotion(ends, bound_tolerance=0.001)
        code = ('unknown', 'clear', 'contact').index(check.outcome)
        floor = min(row[2] for row in rows[k - 1 : k + 1].reshape(-1, 7)) < -0.7
        if not floor:  # which is in no pair of the set
            assert found.motion[k] == code
        seen[int(found.motion[k])] += 1
        if found.motion[k] == 1:
            between = [
                np.linalg.norm(
                    (1 - t) * (rows[k - 1, 0] - rows[k - 1, 1])[:3]
                    + t * (rows[k, 0] - rows[k, 1])[:3]
                )
                for t in np.linspace(0, 1, 50)
            ]
            # A ball of 0.1 and a box whose corners are 0.1732 from its middle.
            assert found.motion_bound[k] <= min(between) - 0.2 + 1e-9
            ends = found.known_distance[k - 1 : k + 1].min()
            assert found.motion_bound[k] <= ends
    assert seen[1] > 5
    monkeypatch.setattr(states, '_MOST_STATES', 7)
    small = clearance(run, balls, between=['a:b'], certify=0.001, threads=1)['a:b']
    np.testing.assert_array_equal(small.motion, found.motion)
    np.testing.assert_array_equal(small.motion_bound, found.motion_bound)


def test_what_is_not_known_is_told(tmp_path, balls):  # noqa: F811
    far = rows_of([(1.0, 0, 0), (1.1, 0, 0), (1.2, 0, 0), (1.3, 0, 0)])
    rows = [[row, HERE] for row in far]
    run = recorder.record(tmp_path / 'run', poses([0.0, 0.5, 3.0, 3.5], 'ab', rows))
    found = clearance(run, balls, between=['a:b'], certify=0.001)
    assert found['a:b'].motion.tolist() == [0, 1, 0, 1]
    told = found['a:b'].certified()
    assert told.lower_bound == pytest.approx(0.8, abs=0.001)
    assert any('nothing is proved of 1 motion' in words for words in found.reservations())
