"""A scene with its first poses: files, robots at rest, and poses by name."""

import numpy as np
import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.pose_file import FramePose
from drake_geom_ros.command_line.program import main
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import Location, SceneFileError
from drake_geom_ros.trajectories.kinematics import Kinematics

TWO_FRAMES = """
sources: [a, b]
frames:
- {name: f, source: a, pose: {position: [1, 0, 0]}}
- {name: f, source: b}
- {name: g, source: b, parent: f}
geometries:
- {name: ball, source: a, frame: f, shape: {type: sphere, radius: 1}}
- {name: ball, source: b, frame: g, shape: {type: sphere, radius: 1}}
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / 'two.yaml'
    path.write_text(TWO_FRAMES)
    return OpenedScene(str(path))


def pose(name, x):
    return FramePose(name, RigidTransform([x, 0, 0]), Location('poses.csv', 7))


def positions(scene):
    inspector = scene.inspector
    return {
        scene.frame_name(frame): scene.query.X_WF(frame).translation().tolist()
        for frame in inspector.GetAllFrameIds()
        if scene.query.is_placed(frame)
    }


def test_frames_stand_where_the_file_says(scene):
    assert positions(scene) == {'world': [0, 0, 0], 'a::f': [1, 0, 0]}
    with pytest.raises(SceneFileError, match=r'two.yaml: these frames have no pose: b::f, b::g;'):
        scene.check_whole()
    scene.pose([pose('b::f', 0.0), pose('g', 0.0)])
    scene.check_whole()
    assert sorted(scene.names.values()) == ['a::f/ball', 'b::g/ball']


def test_poses_are_those_in_the_parent_and_stay(scene):
    scene.pose([pose('b::f', 2.0), pose('g', 3.0)])
    scene.pose([pose('a::f', 7.0)])
    assert positions(scene)['b::g'] == [5, 0, 0]
    assert positions(scene)['a::f'] == [7, 0, 0]


@pytest.mark.parametrize(
    ('names', 'word'),
    [
        (['f'], 'several'),
        (['h'], 'neither a frame'),
        (['a::f/ball'], 'not a frame that can be posed'),
        (['world'], 'not a frame that can be posed'),
        (['g', 'b::g'], 'twice'),
    ],
)
def test_a_name_that_cannot_be_posed_is_blamed(scene, names, word):
    before = positions(scene)
    with pytest.raises(SceneFileError, match=word) as error:
        scene.pose([pose(name, 9.0) for name in names])
    assert str(error.value).startswith('poses.csv:7: ')
    assert positions(scene) == before


def test_links_of_a_robot_stand_as_its_configuration_says():
    scene = OpenedScene(str(ROOT / 'scenes/two_pandas.yaml'))
    (left, _) = scene.description.robots
    arm = Kinematics(str(left.urdf))
    standing = [left.configuration[name] for name in arm.joint_names]
    expected = arm.link_transforms(standing, left.X_WB.GetAsMatrix4())
    frames = {scene.frame_name(f): f for f in scene.inspector.GetAllFrameIds()}
    for name, X_WL in zip(arm.link_names, expected, strict=True):
        found = scene.query.X_WF(frames[f'left::{name}']).GetAsMatrix4()
        np.testing.assert_allclose(found, X_WL, rtol=0, atol=1e-14)


LOOSE = """<robot name="r"><link name="a"/>
<link name="b"><collision><geometry><capsule radius="0.1" length="1"/></geometry></collision>
</link>
<link name="c"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j" type="{}"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="k" type="fixed"><parent link="b"/><child link="c"/><origin xyz="0 0 3"/></joint>
</robot>"""


@pytest.fixture(params=['floating', 'planar'])
def loose(tmp_path, request):
    path = tmp_path / 'r.urdf'
    path.write_text(LOOSE.format(request.param))
    return path


def test_links_that_may_be_anywhere_wait_for_a_pose(loose):
    scene = OpenedScene(str(loose))
    with pytest.raises(SceneFileError, match=r'no pose: .*r::b, r::c'):
        scene.check_whole()


def test_a_robot_of_such_joints_is_checked_and_asked_by_poses(loose, tmp_path, capsys):
    assert main(['check', str(loose)]) == 0
    assert '  r::b in world waits for a pose' in capsys.readouterr().out.splitlines()
    assert main(['convert', str(loose), str(tmp_path / 'r.yaml')]) == 0
    poses = tmp_path / 'poses.json'
    poses.write_text(
        '{"a": [0, 0, 0, 0, 0, 0, 1], "b": [0, 0, 0, 0, 0, 0, 1], "c": [0, 0, 3, 0, 0, 0, 1]}'
    )
    scene = str(tmp_path / 'r.yaml')
    for given in (str(loose), scene):
        capsys.readouterr()
        query = ['query', given, '--poses', str(poses), '--format', 'json']
        assert main([*query, '--what', 'distance']) == 0
    assert main(['query', str(loose)]) == 2
    assert 'no pose: ' in capsys.readouterr().err
