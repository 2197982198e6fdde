"""URDF as Drake's and Gazebo's users write it, beside pydrake."""

import re

import pytest
from oracles.like_drake import compared

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene, read_scene
from drake_geom_ros.scene_files.errors import SceneFileError

INERTIA = (
    '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    '</inertial>'
)
BALL = '<collision><geometry><sphere radius="0.2"/></geometry></collision>'
AXIS = '<axis xyz="0 0 1"/>'


def robot(*joints, more=''):
    links = [name for name in 'abc' if f'link="{name}"' in ''.join(joints)]
    bodies = ''.join(f'<link name="{name}">{INERTIA}{BALL}</link>' for name in links)
    return f'<robot name="r" xmlns:drake="http://drake.mit.edu">{bodies}{more}{"".join(joints)}</robot>'


def joint(kind, ends='ab', inside='', tag='joint', name='j'):
    parent, child = ('world', ends[1:]) if ends[0] == 'w' else ends
    return (
        f'<{tag} name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.5 0 0" rpy="0.1 0.2 0.3"/>{inside}</{tag}>'
    )


WORLD = f'<link name="world">{BALL}</link>'
CASES = {
    'a world that is no link, a fixed joint': robot(joint('fixed', 'wa')),
    'a world that is no link, a moving joint': robot(
        joint('continuous', 'wa', AXIS), joint('fixed', 'ab', name='k')
    ),
    'shapes of the world': robot(
        joint('continuous', 'wa', AXIS), joint('fixed', 'ab', name='k'), more=WORLD
    ),
    'shapes of the world and a fixed link': robot(
        joint('fixed', 'wa'), joint('continuous', 'ab', AXIS, name='k'), more=WORLD
    ),
    **{
        f'a {kind} joint of Drake': robot(
            joint(kind, 'ab', tag='drake:joint'), joint('continuous', 'bc', AXIS, name='k')
        )
        for kind in ('ball', 'planar', 'universal')
    },
    'a screw joint of Drake': robot(
        joint(
            'screw',
            'ab',
            AXIS + '<drake:screw_thread_pitch value="0.4"/>',
            'drake:joint',
        ),
        joint('continuous', 'bc', AXIS, name='k'),
    ),
}


@pytest.mark.parametrize('text', CASES.values(), ids=CASES.keys())
def test_robots_are_those_of_pydrake(text):
    pytest.importorskip('pydrake.multibody.parsing', exc_type=ImportError)
    assert not compared('', text=text, kind='urdf')


def test_an_implicit_world_is_reported_and_anchors_what_it_holds():
    scene_graph = SceneGraph()
    with pytest.warns(UserWarning, match=r"<text>:1: the parent 'world' of a joint is no link"):
        loaded = load_scene(CASES['a world that is no link, a fixed joint'], scene_graph)
    welded = scene_graph.collision_filter_manager().welded_frames()
    assert welded == [loaded.frames['r', 'a']]


def test_geometries_of_the_world_are_anchored():
    scene = read_scene(CASES['shapes of the world'] + '\n')
    assert [g.frame for g in scene.geometries].count('world') == 1
    assert 'world' not in [frame.name for frame in scene.frames]


def test_a_curvilinear_joint_is_reported():
    text = robot(joint('curvilinear', 'ab', tag='drake:joint'))
    warnings = '\n'.join(read_scene(text + '\n').warnings)
    assert re.search(r"no joint value moves a curvilinear joint: send poses of 'b'", warnings)


@pytest.mark.parametrize(
    ('text', 'fault'),
    [
        (robot(joint('hinge', 'ab', tag='drake:joint')), r"type 'hinge' is none of <drake:joint>"),
        (robot(joint('screw', 'ab', tag='drake:joint')), r'one <drake:screw_thread_pitch'),
        (
            robot(
                joint('screw', 'ab', '<drake:screw_thread_pitch value="x"/>', tag='drake:joint')
            ),
            r"value = 'x' must be a number",
        ),
    ],
)
def test_a_faulty_joint_of_drake_is_refused(text, fault):
    with pytest.raises(SceneFileError, match=fault):
        read_scene(text + '\n')
