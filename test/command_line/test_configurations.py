"""Joint values for ``render`` and ``view``: by name, and as files of states."""

from pathlib import Path

import numpy as np
import pytest

from drake_geom_ros.batch import Joints
from drake_geom_ros.command_line.configurations import pose_joints, poses_of_states
from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.program import main
from drake_geom_ros.scene_files import SceneFileError

SCENE = Path(__file__).parents[1] / 'batch/cell.yaml'
CAMERA = ['--from', '2', '-2', '1.5', '--at', '0', '0', '0.5', '--size', '64', '48']


@pytest.fixture
def scene():
    return OpenedScene(str(SCENE))


def hand_of(scene):
    return scene.query.X_WF(scene.loaded.frames['arm', 'hand']).translation()


def test_joints_by_name_pose_the_robot(scene, capsys):
    values = pose_joints(scene, ['turn=0.5', 'arm::bend=-0.2'])
    assert values == {'arm::turn': 0.5, 'arm::bend': -0.2}
    joints = Joints.of(scene.loaded)
    (poses,) = joints.poses(np.array([[0.5, -0.2, 0.0, 0.0]]))
    place = joints.frame_ids.index(scene.loaded.frames['arm', 'hand'])
    np.testing.assert_array_equal(hand_of(scene), poses[place, :3])
    assert capsys.readouterr().err == ''
    pose_joints(scene, ['bend=2.5'])
    assert 'arm::bend is outside its limits [-2, 2]' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        (['elbow=1'], r"'elbow': no joint is called so; there are arm::turn"),
        (['turn'], 'must be NAME=VALUE'),
        (['turn=fast'], "'fast' is no number"),
        (['turn=nan'], 'must be finite'),
        (['turn=1', 'arm::turn=2'], 'given twice'),
    ],
)
def test_what_is_no_joint_value_is_refused(scene, given, words):
    with pytest.raises(SceneFileError, match=words):
        pose_joints(scene, given)


def test_states_of_a_file_are_rows_of_all_joints_or_of_those_it_names(scene, tmp_path, capsys):
    rows = np.array([[0.1, 0.2, 0.3, 0.05], [0.4, 0.5, 0.6, 0.2]])
    np.save(tmp_path / 'states.npy', rows)
    np.savez(tmp_path / 'some.npz', states=rows[:, :1], joints=['arm::bend'])
    found = poses_of_states(scene, str(tmp_path / 'states.npy'))
    assert len(found.poses) == 2
    assert found.values[1]['arm::slide'] == 0.2
    assert 'arm::slide is outside its limits [0, 0.1] in 1 of 2' in capsys.readouterr().err
    some = poses_of_states(scene, str(tmp_path / 'some.npz'))
    assert some.values == [{'arm::bend': 0.1}, {'arm::bend': 0.4}]
    for bad, words in (
        (rows[:, :2], '2 columns for 4 joints'),
        (rows * np.nan, 'not finite'),
        (rows[:0], 'no state'),
    ):
        np.save(tmp_path / 'bad.npy', bad)
        with pytest.raises(SceneFileError, match=words):
            poses_of_states(scene, str(tmp_path / 'bad.npy'))


def test_render_draws_each_state_with_nearest_points_and_through_bodies(tmp_path, capsys):
    np.save(tmp_path / 'states.npy', np.array([[0.1, 0.2, 0.3, 0.05], [0.9, 0.5, 0.6, 0.0]]))
    out = tmp_path / 'out'
    given = ['render', str(SCENE), *CAMERA, '--out', str(out)]
    states = ['--states', str(tmp_path / 'states.npy')]
    assert main([*given, *states, '--nearest', '0.2', '--see-through']) == 0
    names = {path.name for path in out.iterdir()}
    for number in ('0000', '0001'):
        assert {f'camera_{number}_color.png', f'camera_{number}_view.png'} <= names
    from PIL import Image

    views = [np.asarray(Image.open(out / f'camera_000{k}_view.png')) for k in (0, 1)]
    assert views[0].shape == (48, 64, 3)
    assert (views[0] != views[1]).any()
    assert main([*given, '--joints', 'turn=1.2']) == 0
    assert main([*given, '--joints', 'turn=x']) == 2
    assert "'x' is no number" in capsys.readouterr().err
