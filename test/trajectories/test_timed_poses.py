import numpy as np
import pytest

from drake_geom_ros.math.batched import slerp
from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.trajectories.timed_poses import COLUMNS, TimedPoses, read_timed_poses


def _turn_z(angle):
    return [0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)]


def test_poses_at_their_times_are_met():
    table = np.array(
        [[0, 0, 1, *_turn_z(0.0)], [1, 2, 3, *_turn_z(1.0)], [0, 1, 0, *_turn_z(3.0)]]
    )
    frame = TimedPoses([0.5, 1.0, 3.0], table)
    np.testing.assert_allclose(frame.poses([0.5, 1.0, 3.0]), table, rtol=0, atol=1e-15)
    np.testing.assert_allclose(frame.poses([0.0, 9.0]), table[[0, 2]], rtol=0, atol=1e-15)
    assert frame.end == 3.0
    assert frame.moves


def test_turns_at_constant_rate_by_the_shorter_way():
    away = -np.array(_turn_z(1.2))  # the same orientation, the other sign
    frame = TimedPoses([0.0, 2.0], [[0, 0, 0, *_turn_z(0.2)], [0, 0, 0, *away]])
    q = frame.poses(np.linspace(0.0, 2.0, 11))[:, 3:]
    np.testing.assert_allclose(2 * np.arctan2(q[:, 2], q[:, 3]), np.linspace(0.2, 1.2, 11))


@pytest.mark.parametrize('angle', [0.0, 1e-12, 1e-3, 1.0, np.pi - 1e-9, np.pi])
def test_slerp_stays_unit_and_divides_the_arc(angle):
    q0, q1 = np.array(_turn_z(0.0)), np.array(_turn_z(angle))
    u = np.linspace(0.0, 1.0, 9)[:, None]
    q = slerp(q0, q1, u)
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0)
    np.testing.assert_allclose(
        2 * np.arctan2(q[:, 2], q[:, 3]), angle * u[:, 0], rtol=0, atol=1e-15
    )


def test_one_pose_stands_still():
    frame = TimedPoses([0.0], [[1, 2, 3, 0, 0, 0, 1]])
    assert (frame.end, frame.moves) == (0.0, False)
    np.testing.assert_array_equal(frame.poses([-1.0, 0.0, 7.0]), [[1, 2, 3, 0, 0, 0, 1]] * 3)
    np.testing.assert_array_equal(frame.matrices(4.0)[:3, 3], [1, 2, 3])


@pytest.mark.parametrize(
    ('poses', 'reason'),
    [([[0, 0, 0, 0, 0, 0, 1.01]], '1.01'), ([[0, 0, 0, 0, 0, 1]], 'shape')],
)
def test_what_is_no_pose_is_refused(poses, reason):
    with pytest.raises((ValueError, RuntimeError), match=reason):
        TimedPoses([0.0], poses)


def _csv(tmp_path, *rows):
    path = tmp_path / 'poses.csv'
    path.write_text('\n'.join(rows) + '\n')
    return path


def test_csv_holds_many_frames(tmp_path):
    path = _csv(
        tmp_path,
        ','.join(COLUMNS),
        '0.0,a::ball,0,0,1,0,0,0,1',
        '0.0,a::cup,5,5,5,0,0,0,1',
        '2.0,a::ball,0,0,3,0,0,1,0',
    )
    frames = read_timed_poses(path)
    assert list(frames) == ['a::ball', 'a::cup']
    np.testing.assert_allclose(frames['a::ball'].poses(1.0)[:3], [0, 0, 2])
    np.testing.assert_allclose(frames['a::cup'].poses(1.0)[:3], [5, 5, 5])


@pytest.mark.parametrize(
    ('rows', 'reason'),
    [
        (['time,frame,x'], r'poses.csv:1: columns must be time,frame,x,y,z'),
        ([','.join(COLUMNS), '0,f,0,0,zero,0,0,0,1'], r'poses.csv:2: .*zero'),
        ([','.join(COLUMNS), '0,f,0,0,0,0,0,1'], r'poses.csv:2'),
        ([','.join(COLUMNS), '1,f,0,0,0,0,0,0,1', '0,f,0,0,0,0,0,0,1'], r"frame 'f': .*increase"),
    ],
)
def test_bad_csv_is_refused_with_its_line(tmp_path, rows, reason):
    with pytest.raises(SceneFileError, match=reason) as error:
        read_timed_poses(_csv(tmp_path, *rows))
    assert str(error.value).count('poses.csv') == 1


def test_what_is_not_text_is_refused_with_its_line(tmp_path):
    (tmp_path / 'poses.csv').write_bytes(','.join(COLUMNS).encode() + b'\n0,caf\xe9')
    with pytest.raises(SceneFileError, match=r'poses\.csv:2: byte 0xe9 is not UTF-8'):
        read_timed_poses(tmp_path / 'poses.csv')
