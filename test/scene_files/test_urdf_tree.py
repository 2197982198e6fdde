"""Links and joints of a URDF: what is read of them, and what is no tree."""

import math

import numpy as np
import pytest

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.link_tree import Mimic
from drake_geom_ros.scene_files.scene_file import read_scene
from drake_geom_ros.scene_files.urdf_tree import fixed_poses, read_link_tree, root_links


def joint(name, parent, child, inside='', kind='fixed'):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'{inside}</joint>\n'
    )


def read(tmp_path, links, *joints):
    text = ''.join(f'<link name="{name}"/>' for name in links)
    path = tmp_path / 'r.urdf'
    path.write_text(f'<robot name="r">{text}\n{"".join(joints)}</robot>')
    return read_link_tree(path)


def test_a_joint_is_read_with_its_axis_limits_and_leader(tmp_path):
    tree = read(
        tmp_path,
        'abc',
        joint(
            'lift',
            'a',
            'b',
            '<origin xyz="0 0 1"/><axis xyz="0 0 2"/><limit upper="2" velocity="0.5"/>',
            'prismatic',
        ),
        joint('turn', 'b', 'c', '<mimic joint="lift" offset="1"/>', 'continuous'),
    )
    assert (tree.name, tree.links) == ('r', ('a', 'b', 'c'))
    lift, turn = tree.joints
    assert (lift.name, lift.type, lift.parent, lift.child) == ('lift', 'prismatic', 'a', 'b')
    np.testing.assert_array_equal(lift.X_PJ.translation(), [0, 0, 1])
    assert (lift.axis, lift.lower, lift.upper, lift.max_speed) == ((0, 0, 2), 0, 2, 0.5)
    assert (turn.axis, turn.lower, turn.upper) == ((1, 0, 0), -math.inf, math.inf)
    assert turn.mimic == Mimic('lift', 1.0, 1.0)
    assert turn.where.line == 3


def test_a_second_joint_of_a_name_is_refused_with_both_lines(tmp_path):
    with pytest.raises(SceneFileError, match=r":3: joint\[j\]: joint 'j' is listed twice.*line 2"):
        read(tmp_path, 'abc', joint('j', 'a', 'b'), joint('j', 'b', 'c'))


def test_a_link_with_two_parents_is_refused_with_both_joints(tmp_path):
    with pytest.raises(
        SceneFileError,
        match=r":3: joint\[k\]: link 'c' has two parents: joint 'j' \(line 2\) holds it to 'a', "
        "and this one to 'b'",
    ):
        read(tmp_path, 'abc', joint('j', 'a', 'c'), joint('k', 'b', 'c'))


@pytest.mark.parametrize(
    ('ends', 'told'),
    [
        (['bc', 'cb'], r"'j1' \(line 3\), 'j0' \(line 2\)"),
        (['ab', 'cd', 'de', 'ec'], r"'j2' \(line 4\), 'j3' \(line 5\), 'j1' \(line 3\)"),
        (['aa'], r"'j0' \(line 2\)"),
    ],
)
def test_a_ring_is_refused_with_its_joints(tmp_path, ends, told):
    joints = [joint(f'j{k}', *pair) for k, pair in enumerate(ends)]
    with pytest.raises(SceneFileError, match=f'form a ring: {told}; links must form a tree'):
        read(tmp_path, 'abcde', *joints)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('<robot name="r"/>', 'r.urdf:1: no links; a robot has at least one'),
        ('<robot name="r"><link name="world"/></robot>', "no links but 'world'"),
        ('<robot><link name="a"/></robot>', 'missing attribute `name`'),
        ('<robot name="r"><link name="a"/><joint name="j" type="fixed"/></robot>', '<parent'),
        ('', 'it is empty'),
    ],
)
def test_what_has_no_links_or_half_a_joint_is_refused(tmp_path, text, message):
    path = tmp_path / 'r.urdf'
    path.write_text(text)
    with pytest.raises(SceneFileError, match=message):
        read_link_tree(path)


@pytest.mark.parametrize(
    ('inside', 'message'),
    [
        ('<origin xyz="0,0,0.5"/>', r"r.urdf:2: joint\[j\]: origin: xyz = '0,0,0.5' must be 3"),
        ('<axis xyz="0 0"/>', "axis: xyz = '0 0' must be 3 numbers"),
        ('<axis xyz="0 0 inf"/>', "axis: xyz = '0 0 inf' must be finite"),
        ('<limit upper="1 rad"/>', "limit: upper = '1 rad' must be a number"),
        ('<mimic multiplier="2"/>', 'mimic has no attribute `joint`'),
    ],
)
def test_numbers_of_a_joint_are_refused_with_its_line(tmp_path, inside, message):
    with pytest.raises(SceneFileError, match=message):
        read(tmp_path, 'ab', joint('j', 'a', 'b', inside, 'revolute'))


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(SceneFileError, match=r'none\.urdf: cannot be read'):
        read_link_tree(tmp_path / 'none.urdf')


def test_what_is_fixed_to_the_root_stands_with_it(tmp_path):
    tree = read(
        tmp_path,
        'abcd',
        joint('last', 'b', 'c', '<origin xyz="0 1 0"/>'),
        joint('first', 'a', 'b', '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>'),
        joint('turn', 'c', 'd', kind='continuous'),
    )
    assert root_links(tree.joints, tree.links) == ['a']
    poses = fixed_poses(tree.joints, 'a', RigidTransform([0, 0, 5]))
    assert set(poses) == {'a', 'b', 'c'}
    np.testing.assert_allclose(poses['c'].translation(), [0, 0, 5], rtol=0, atol=1e-15)


@pytest.mark.everything  # 70 s of a processor
@pytest.mark.parametrize('kind', ['fixed', 'revolute'])
@pytest.mark.parametrize('upwards', [False, True])
def test_a_long_chain_takes_seconds(tmp_path, kind, upwards):
    """Work that grows with the square of the links took minutes, and stopped a node."""
    count = 20_000
    links = ''.join(f'<link name="l{k}"/>' for k in range(count))
    joints = [
        f'<joint name="j{k}" type="{kind}"><parent link="l{k}"/><child link="l{k + 1}"/>'
        '<origin xyz="0 0 1"/></joint>'
        for k in range(count - 1)
    ]
    text = f'<robot name="r">{links}{"".join(joints[:: -1 if upwards else 1])}</robot>\n'
    scene = read_scene(text)
    assert len(scene.frames) == count
    (tmp_path / 'r.urdf').write_text(text)
    placed = fixed_poses(read_link_tree(tmp_path / 'r.urdf').joints, 'l0', RigidTransform())
    assert len(placed) == (count if kind == 'fixed' else 1)
