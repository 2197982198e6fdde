"""What a recording does not tell is told of, at its ends and in its middle, and is never whole."""

import re

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import CELL, HERE, balls, poses  # noqa: F401

from drake_geom_ros.command_line.exit_codes import NO
from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import (
    IncompleteRecordingError,
    RecordingError,
    Topics,
    audit,
    clearance,
)
from drake_geom_ros.recordings.recorded_poses import recorded_poses

DISTANCES = 'drake_geom_msgs/msg/SignedDistancePairs'
CLOCK = 'rosgraph_msgs/msg/Clock'


def still(times):
    """Return messages of a ball and a box that rest 0.8 m apart."""
    return poses(times, 'ab', [[HERE, (1.0, 0, 0, 0, 0, 0, 1)]] * len(times))


def others(times):
    """Return messages that pose nothing."""
    return [(t, '/rosout', recorder.text('all is well')) for t in times]


def test_when_poses_were_stale_is_said(tmp_path, balls):  # noqa: F811
    silent = [(t, '/node/frame_poses', recorder.frame_poses(t, 'b', [HERE])) for t in (2.5, 2.7)]
    run = recorder.record(tmp_path / 'run', still([0.0, 0.5, 1.0]) + silent + still([2.8]))
    found = clearance(run, balls, between=['a:b'], stale_after=1.6)
    (told,) = found.reservations()
    assert told == ('a:b: 1 of 6 states are stale, or of unknown age, between 2.700 and 2.700 s')


@pytest.mark.parametrize('rate', [0.0, 20.0])
@pytest.mark.parametrize('sqlite', [False, True])
def test_a_driver_that_died_before_the_end_is_no_whole_run(tmp_path, balls, rate, sqlite):  # noqa: F811
    messages = still(0.1 * np.arange(20)) + others(np.arange(2.0, 10.5, 0.5))
    run = recorder.record(tmp_path / 'run', messages, sqlite=sqlite)
    found = clearance(run, balls, between=['a:b'], rate=rate)
    assert found.duration == pytest.approx(10.0)
    if rate:
        assert found.times[-1] == pytest.approx(10.0)
        assert found['a:b'].is_stale[found.times > 2.95].all()
        assert not found['a:b'].is_stale[found.times < 2.85].any()
    else:
        assert [tuple(gap) for gap in found.gaps] == [pytest.approx((1.9, 10.0))]
        assert found.reservations() == [
            '1 gap without data, 8.100 s in all, also at the end of the recording'
        ]
    with pytest.raises(IncompleteRecordingError):
        found.least()


def test_what_came_before_the_first_pose_is_a_gap(tmp_path, balls):  # noqa: F811
    messages = others([0.0]) + still(5.0 + 0.1 * np.arange(20))
    found = clearance(recorder.record(tmp_path / 'run', messages), balls, between=['a:b'])
    np.testing.assert_allclose(found.times, 5.0 + 0.1 * np.arange(20), rtol=0, atol=1e-9)
    assert [tuple(gap) for gap in found.gaps] == [pytest.approx((0.0, 5.0))]
    assert 'at the beginning of the recording' in found.reservations()[0]


def test_messages_that_were_refused_are_reservations(tmp_path, balls, capsys):  # noqa: F811
    messages = still(0.1 * np.arange(20))
    for k in (5, 6):
        messages[k][2].poses[3:7] = 0.0  # no quaternion
    run = recorder.record(tmp_path / 'run', messages)
    found = clearance(run, balls, between=['a:b'])
    (told,) = found.reservations()
    assert told.startswith('2 messages of /node/frame_poses refused, first: ')
    with pytest.raises(IncompleteRecordingError, match='2 messages'):
        found.least()
    asked = ['report', run, '--scene', balls, '--between', 'a:b', '--out', tmp_path / 'out']
    assert main(list(map(str, asked))) == 1
    assert told in capsys.readouterr().out


def test_joints_of_another_robot_are_none(tmp_path, balls):  # noqa: F811
    messages = still(0.1 * np.arange(20))
    wheels = [
        (0.1 * k, '/joint_states', recorder.joint_state(0, ['wheel'], [0])) for k in range(9)
    ]
    run = recorder.record(tmp_path / 'run', sorted(messages + wheels, key=lambda each: each[0]))
    found = clearance(run, balls, between=['a:b'])
    assert not found.reservations()
    assert any('wheel' in each.words for each in found.troubles)


def test_a_clock_that_nobody_ticks_makes_no_time_stand_still(tmp_path, balls):  # noqa: F811
    messages = still(0.1 * np.arange(20))
    late = [(t, topic, message) for t, topic, message in messages]
    for t, _, message in late:
        message.header.stamp = recorder.stamp(t - 3.0)  # measured three seconds ago
    run = recorder.record(tmp_path / 'run', late)
    silent = recorder.record(tmp_path / 'silent', late, silent=[('/clock', CLOCK)])
    found, other = (clearance(each, balls, between=['a:b']) for each in (run, silent))
    np.testing.assert_allclose(found['a:b'].age, 3.0)
    np.testing.assert_array_equal(other['a:b'].age, found['a:b'].age)
    assert any('/clock has no message' in each.words for each in other.troubles)
    assert not clearance(run, balls, topics=Topics(clock=''), between=['a:b']).troubles


def distances(seconds):
    """Return a message of a node that says nothing of any pair."""
    kind = recorder.store().types[DISTANCES]
    values = {'header': recorder.header(seconds)}
    for name, (each, _) in recorder.store().fielddefs[DISTANCES][1]:
        if name not in values:
            values[name] = np.zeros(0) if int(each) > 2 else 0
    return kind(**values)


def test_an_audit_of_nothing_says_so(tmp_path, balls, capsys):  # noqa: F811
    messages = still(0.1 * np.arange(20))
    topic, events = '/node/signed_distances', '/node/proximity_events'
    silent = [(topic, DISTANCES), (events, 'drake_geom_msgs/msg/ProximityEvents')]
    run = recorder.record(tmp_path / 'run', messages, silent=silent)
    found = audit(run, balls)
    assert found.reservations() == [
        f'no message of {topic} was recorded',
        'nothing: no result and no event was recorded',
    ]
    out = tmp_path / 'out'
    asked = ['report', run, '--scene', balls, '--between', 'a:b', '--audit', '--out', out]
    assert main(list(map(str, asked))) == 1
    assert 'not audited: nothing' in capsys.readouterr().out
    assert f'no message of {topic}' in (out / 'report.html').read_text()


def test_an_audit_of_a_damaged_file_says_what_is_lost(tmp_path, balls):  # noqa: F811
    messages = still(0.1 * np.arange(2000))
    messages[::100] = [(t, '/node/signed_distances', distances(t)) for t, *_ in messages[::100]]
    run = recorder.record(tmp_path / 'run', messages, sqlite=True)
    file = recorder.file_of(run)
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    found = audit(run, balls)
    assert not found.silent
    assert 2 < len(found.entries) < 15
    told = found.reservations()
    assert any(re.search(r'\.db3: .*malformed|breaks off', each) for each in told)


def test_a_run_that_holds_nothing_is_told_of(tmp_path, balls, capsys):  # noqa: F811
    runs = tmp_path / 'runs'
    recorder.record(runs / 'run_0', still(0.1 * np.arange(5)))
    recorder.record(runs / 'run_1', still(0.1 * np.arange(5)))
    recorder.file_of(runs / 'run_1').unlink()
    (runs / 'run_2').mkdir()
    asked = ['report', runs, '--scene', balls, '--between', 'a:b', '--out', runs / 'reports']
    assert main(list(map(str, asked))) == 2
    told = capsys.readouterr().err
    assert 'run_1 holds no recording' in told
    assert 'run_2 holds no recording' in told
    assert main(list(map(str, asked))) == 2
    assert 'reports' not in capsys.readouterr().err


CLOUD, IMAGE = 'sensor_msgs/msg/PointCloud2', 'sensor_msgs/msg/Image'


@pytest.mark.parametrize('has_messages', [True, False])
@pytest.mark.parametrize('name', ['/scene_graph/obstacles', '/camera'])
def test_maps_that_sensors_see_are_in_no_distance_and_told_of(
    tmp_path,
    balls,  # noqa: F811
    capsys,
    name,
    has_messages,
):
    """Nobody computes with them here, so what is told of the rest is not all."""
    topics = {f'{name}/points': CLOUD, f'{name}/depth/image_rect_raw': IMAGE}
    messages, silent = still(0.1 * np.arange(20)), [('/camera/obstacles/info', IMAGE)]
    if has_messages:
        header = recorder.header(0.5, 'world')
        nothing = np.zeros(0, dtype=np.uint8)
        values = {
            CLOUD: (header, 1, 0, [], False, 16, 0, nothing, True),
            IMAGE: (header, 1, 0, '16UC1', 0, 0, nothing),
        }
        types = recorder.store().types
        messages += [(0.5, topic, types[kind](*values[kind])) for topic, kind in topics.items()]
        messages.sort(key=lambda each: each[0])
    else:
        silent += topics.items()
    run = recorder.record(tmp_path / 'run', messages, silent=silent)
    found = clearance(run, balls, between=['a:b'])
    assert set(found.maps) == set(topics)
    told = f'what sensors see, on {" and ".join(found.maps)}, is in no distance: pairs with maps'
    (reserved,) = found.reservations()
    assert reserved.startswith(told)
    with pytest.raises(IncompleteRecordingError, match='pairs with maps'):
        found.least()
    arguments = ['report', str(run), '--scene', str(balls), '--out', str(tmp_path / 'out')]
    assert main(arguments) == NO
    assert f'not known: {reserved}' in capsys.readouterr().out
    assert reserved in (tmp_path / 'out' / 'report.html').read_text()
    assert main([*arguments, '--topic', 'obstacles=']) == 0
    assert 'what sensors see' not in (tmp_path / 'out' / 'report.html').read_text()
    poses = []
    recorded_poses(run, balls, 10.0, warn=poses.append)
    assert poses == [reserved]


def test_sensors_of_the_scene_are_in_no_distance_though_nobody_recorded_them(
    tmp_path,
    balls,  # noqa: F811
):
    sensors = 'front: {type: laser_scan, topic: scan}, own: {type: octomap, topic: ~/o}'
    balls.write_text(f'{balls.read_text()}\nobstacle_sources: {{{sensors}}}\n')
    run = recorder.record(tmp_path / 'run', still(0.1 * np.arange(20)))
    found = clearance(run, balls, between=['a:b'])
    assert found.maps == ('/scan', '/scene_graph/o')
    assert found.reservations()[0].startswith('what sensors see, on /scan and /scene_graph/o')


def test_who_says_what_a_node_saw_is_believed_where_it_was_recorded(
    tmp_path,
    balls,  # noqa: F811
):
    silent = [('/lidar', CLOUD), ('/aligned', IMAGE), ('/text', 'std_msgs/msg/String')]
    run = recorder.record(tmp_path / 'run', still(0.1 * np.arange(20)), silent=silent)

    def maps(*obstacles):
        topics = Topics.of([f'obstacles={each}' for each in obstacles])
        return clearance(run, balls, topics=topics).maps

    assert maps() == ('/lidar',)
    assert maps('') == ()
    assert maps('/aligned,lidar') == ('/aligned', '/lidar')
    with pytest.raises(RecordingError, match="no topic '/lida' was recorded; nearest: '/lidar'"):
        maps('/lida')
    with pytest.raises(RecordingError, match='/text is of the type std_msgs/msg/String, and obst'):
        maps('/text')
    with pytest.raises(RecordingError, match="obstacles is given twice, as '/lidar' and '/ali"):
        maps('/lidar', '/aligned')


@pytest.mark.parametrize('every', [2, 10])
def test_a_recording_of_two_senders_of_joint_values_is_not_whole(tmp_path, every):
    joints, messages = ('turn', 'bend', 'roll', 'slide'), []
    for k in range(200):
        values = [0.5, 0.5, 0.5, 0.1] if k % every == 0 else [0.001 * k, 0.0, 0.0, 0.0]
        messages.append(
            (0.01 * k, '/joint_states', recorder.joint_state(0.01 * k, joints, values))
        )
    found = clearance(recorder.record(tmp_path / 'run', messages), CELL)
    told = '; '.join(trouble.words for trouble in found.troubles)
    assert 'are sent by two senders in turn' in told
    assert found.reservations()
