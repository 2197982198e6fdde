import dataclasses
from itertools import combinations

import numpy as np
import pytest
from oracles import panda

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    FrameDescription,
    RobotDescription,
    SceneDescription,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.urdf_tree import read_link_tree
from drake_geom_ros.trajectories.motion_file import adjacent_links, load_motion


def robot(name, urdf, X_WB=None):
    tree = read_link_tree(urdf)
    return RobotDescription(name, urdf, X_WB or RigidTransform(), tree=tree)


SCENE = SceneDescription(
    robots=(robot('left', panda.URDF, RigidTransform([0.0, 0.0, 0.4])),),
    frames=(
        FrameDescription('left', 'panda_link0'),
        FrameDescription('objects', 'can', X_PF=RigidTransform([0.5, 0.0, 0.1])),
        FrameDescription('objects', 'lid', parent='can', X_PF=RigidTransform([0.0, 0.0, 0.1])),
        FrameDescription('objects', 'ball'),
        FrameDescription('objects', 'ghost'),
    ),
)
TEXT = """\
robots:
  left:
    joints: [panda_joint2, panda_joint4]
    waypoints:
    - {at: 0, q: [0.0, -1.0]}
    - {at: 2.0, q: [0.5, -2.0]}
grasps:
- {frame: objects::can, link: left::panda_hand, gripper: [left::panda_leftfinger],
   start: 0.5, end: 1.0}
frames:
  objects::ball:
  - {at: 0.0, pose: [0, 0, 1, 0, 0, 0, 1]}
  - {at: 3.0, pose: [0, 0, 2, 0, 0, 0, 1]}
"""


def _load(tmp_path, text, name='motion.yaml'):
    path = tmp_path / name
    path.write_text(text)
    return load_motion(path, SCENE)


def test_a_file_with_all_parts(tmp_path):
    motion = _load(tmp_path, TEXT)
    assert motion.duration == 3.0
    assert motion.frame_names['objects'] == ['can', 'lid', 'ball']
    curve = motion.robots['left'].joint_values
    names = motion.robots['left'].kinematics.joint_names
    q = dict(zip(names, curve.value(2.0), strict=True))
    assert (q['panda_joint2'], q['panda_joint4'], q['panda_joint1']) == (0.5, -2.0, 0.0)
    grasp = motion.held(0.7)[0]
    assert grasp.link == ('left', 'panda_hand')
    assert grasp.gripper == (('left', 'panda_leftfinger'),)
    np.testing.assert_allclose(motion.poses(1.5)['objects'][2, :3], [0, 0, 1.5])


def test_without_a_file_everything_stands_still_within_the_limits():
    motion = load_motion(None, SCENE)
    first, later = motion.poses([0.0, 5.0])['left']
    np.testing.assert_array_equal(first, later)
    arm = motion.robots['left']
    assert (arm.joint_values.value(0.0) >= arm.kinematics.lower).all()
    assert (arm.joint_values.value(0.0) <= arm.kinematics.upper).all()
    assert motion.frame_names['objects'] == ['can', 'lid']
    np.testing.assert_allclose(motion.poses(0.0)['objects'][0], [0.5, 0, 0.1, 0, 0, 0, 1])
    np.testing.assert_allclose(motion.poses(0.0)['left'][0], [0, 0, 0.4, 0, 0, 0, 1])


def test_a_csv_file_moves_free_frames_only(tmp_path):
    rows = ('0,objects::ball,0,0,0,0,0,0,1', '2,objects::ball,2,0,0,0,0,0,1')
    text = '\n'.join(('time,frame,x,y,z,qx,qy,qz,qw', *rows, ''))
    motion = _load(tmp_path, text, 'poses.csv')
    assert motion.duration == 2.0
    np.testing.assert_allclose(motion.poses(1.0)['objects'][2, 0], 1.0)


@pytest.mark.parametrize(
    ('old', 'new', 'error'),
    [
        ('panda_joint4]', 'panda_joint9]', r'yaml:3: robots.left.joints\[1\]: .*panda_joint9'),
        ('panda_joint4]', 'panda_joint2]', r'yaml:3: robots.left.joints\[1\]: .*twice'),
        ('-1.0]', '0.5]', r'yaml:5: robots.left.waypoints\[0\].q: panda_joint4 = 0.5 must lie in'),
        ('-1.0]', '-1.0, 0]', r'waypoints\[0\].q: 3 numbers; 2 are needed'),
        ('-1.0]', 'minus]', r"waypoints\[0\].q\[1\]: 'minus' must be a number"),
        ('at: 2.0, q', 'at: 0.1, q', r'yaml:4: robots.left.waypoints: panda_joint2 reaches 7.5'),
        ('at: 2.0, q', 'at: 0.0, q', r'robots.left.waypoints: .*increase strictly'),
        ('  left:', '  middle:', r'robots.middle: the scene has no such robot; there are left'),
        ('end: 1.0', 'until: 1.0', r'grasps\[0\].until: unknown key; allowed are frame, link'),
        (', end: 1.0', '', r'yaml:8: grasps\[0\]: missing `end`'),
        ('objects::can', 'objects::cup', r"motion.yaml: grasp of 'objects::cup'"),
        ('  objects::ball', '  objects::bat', r"the scene has no frame 'objects::bat'"),
        ('objects::can', 'objects::lid', r"'objects::lid': its parent is 'can'"),
        (
            'frames:\n',
            'robts: 3\nframes:\n',
            r'yaml:1\d: robts: unknown key; allowed are ro',
        ),
        ('[0, 0, 1, 0, 0, 0, 1]', '[0, 0, 1, 0, 0, 0, 2]', r'frames.objects::ball: .*norm 2'),
        ('grasps:\n- {', 'grasps: {', r'grasps: \{.* must be a list or nothing'),
        ('start: 0.5', 'start: true', r'grasps\[0\].start: True must be a number'),
    ],
)
def test_errors_name_file_line_and_key(tmp_path, old, new, error):
    assert old in TEXT
    with pytest.raises(SceneFileError, match=error):
        _load(tmp_path, TEXT.replace(old, new, 1))


@pytest.mark.parametrize(
    ('name', 'text'), [('poses.csv', 'time\n'), ('m.yaml', 'a: [\n'), ('m.yaml', '- 1\n')]
)
def test_files_of_another_form_are_refused_by_name(tmp_path, name, text):
    with pytest.raises(SceneFileError, match=name):
        _load(tmp_path, text, name)


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(SceneFileError, match=r'absent.yaml'):
        load_motion(tmp_path / 'absent.yaml', SCENE)


def test_a_urdf_that_is_no_tree_is_left_out_by_name(tmp_path):
    urdf = tmp_path / 'odd.urdf'
    urdf.write_text('<robot name="odd"><link name="a"/><link name="b"/></robot>')
    motion = load_motion(None, dataclasses.replace(SCENE, robots=(robot('odd', urdf),)))
    assert 'odd' not in motion.robots
    assert 'one tree' in motion.left_out['odd']


def test_adjacent_links_are_those_that_loading_filters():
    scene = read_scene(f'robots:\n- {{name: left, urdf: {panda.URDF}}}')
    pairs = adjacent_links(scene)
    assert ('left::panda_link3', 'left::panda_link4') in pairs
    assert ('left::panda_link7', 'left::panda_hand') in pairs  # across a bare flange
    cliques = [entry for entry in scene.filters if isinstance(entry, CliqueDescription)]
    filtered = {
        (f'{a.source}::{a.frame}', f'{b.source}::{b.frame}')
        for clique in cliques
        for a, b in combinations(clique.members, 2)
    }
    assert set(pairs) == filtered


def test_names_with_colons_are_looked_up_whole_or_refused(tmp_path):
    scene = read_scene(
        """
sources: [o, 'o::p']
frames:
- {name: 'p::q', source: o, pose: {position: [1, 0, 0]}}
- {name: q, source: 'o::p', pose: {position: [2, 0, 0]}}
- {name: 'arm::base', source: o}
"""
    )
    still = load_motion(None, scene)
    assert still.frame_names == {'o': ['p::q'], 'o::p': ['q']}
    assert still.poses(0.0)['o'][0, 0] == 1.0
    assert still.poses(0.0)['o::p'][0, 0] == 2.0
    path = tmp_path / 'motion.yaml'
    rows = '\n  - {at: 0.0, pose: [3, 0, 0, 0, 0, 0, 1]}\n'
    path.write_text(f"frames:\n  'o::arm::base':{rows}")
    assert load_motion(path, scene).frame_names['o'] == ['p::q', 'arm::base']
    path.write_text(f"frames:\n  'o::p::q':{rows}")
    with pytest.raises(SceneFileError, match=r"'p::q' of source 'o' and 'q' of"):
        load_motion(path, scene)


BASE = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j" type="{}"><parent link="a"/><child link="b"/>{}<axis xyz="0 0 1"/></joint>
<joint name="k" type="continuous"><parent link="b"/><child link="c"/></joint></robot>"""


def _mobile(tmp_path, kind, joints, inside=''):
    (tmp_path / 'r.urdf').write_text(BASE.format(kind, inside))
    scene = SceneDescription(
        robots=(robot('r', tmp_path / 'r.urdf'),),
        frames=tuple(FrameDescription('r', name) for name in 'abc'),
    )
    if not joints:
        return load_motion(None, scene)
    path = tmp_path / 'motion.yaml'
    values = ', '.join(['1.5'] * len(joints))
    path.write_text(
        f'robots: {{r: {{joints: [{", ".join(joints)}], waypoints: [{{at: 0, q: [{values}]}}, '
        f'{{at: 1, q: [{values}]}}]}}}}'
    )
    return load_motion(path, scene)


def test_links_below_a_planar_joint_move_when_all_its_values_are_given(tmp_path):
    for joints in ([], ['k'], ['j/x', 'j/y']):
        assert _mobile(tmp_path, 'planar', joints).frame_names == {'r': ['a']}
    motion = _mobile(tmp_path, 'planar', ['j/x', 'j/y', 'j/theta'])
    assert motion.frame_names == {'r': ['a', 'b', 'c']}
    assert motion.poses(0.5)['r'][2, :2].tolist() == pytest.approx([1.5, 1.5])


def test_a_robot_that_no_joint_values_pose_is_left_out_and_named(tmp_path):
    leader = '<mimic joint="thumb"/>'
    motion = _mobile(tmp_path, 'continuous', [], leader)
    assert motion.frame_names == {}
    assert "'thumb'" in motion.left_out['r']
    with pytest.raises(SceneFileError, match=r"motion.yaml:1: robots.r: .*'thumb'"):
        _mobile(tmp_path, 'continuous', ['k'], leader)
