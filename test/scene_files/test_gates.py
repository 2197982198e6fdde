"""Gates in scene files: read, refused with a line, written down and read again."""

from dataclasses import replace

import pytest

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import (
    Gate,
    SceneFileError,
    gates_of_text,
    load_scene,
    read_scene,
    to_yaml,
)
from drake_geom_ros.scene_files.urdf_writer import to_urdf

FLOOR = 'geometries: [{name: floor, shape: {type: half_space}}]\n'
ONE = FLOOR + 'gate: {in: cmd_vel_in, out: cmd_vel, robot: base}\n'
TWO = FLOOR + (
    'gate:\n- {in: /a/in, out: /a/out, robot: a, type: TwistStamped, timeout: 0.2}\n'
    '- {in: /b/in, out: /a/in, robot: "b*"}\n'
)


def test_each_key_is_read():
    assert read_scene(ONE).gates == (Gate('cmd_vel_in', 'cmd_vel', 'base'),)
    assert read_scene(TWO).gates == (
        Gate('/a/in', '/a/out', 'a', 'TwistStamped', 0.2),
        Gate('/b/in', '/a/in', 'b*'),
    )
    assert read_scene(FLOOR).gates == ()


@pytest.mark.parametrize('text', [ONE, TWO])
def test_gates_are_written_down_and_read_again(text):
    described = read_scene(text)
    assert read_scene(to_yaml(described)).gates == described.gates


@pytest.mark.parametrize(
    ('gate', 'told'),
    [
        ('{in: a, out: a, robot: r}', "in and out are both 'a'"),
        ('{in: a, out: b}', 'robot'),
        ('{in: a, out: b, robot: r, type: Pose}', 'Twist'),
        ('{in: a, out: b, robot: r, timeout: 0}', '0'),
        ('{in: a, out: b, robot: r, speed: 1}', 'speed'),
        ('[]', 'gate'),
        ('[{in: a, out: b, robot: r}, {in: a, out: c, robot: s}]', "'a' is a topic of another"),
        ('[{in: a, out: b, robot: r}, {in: c, out: b, robot: s}]', "'b' is a topic of another"),
    ],
)
def test_what_cannot_be_a_gate_is_refused_with_its_line(gate, told):
    with pytest.raises(SceneFileError, match=told) as error:
        read_scene(f'{FLOOR}gate: {gate}\n')
    assert ':2' in str(error.value)
    with pytest.raises(SceneFileError, match=told):
        gates_of_text(gate, 'gate')


def test_where_no_node_is_a_gate_is_warned_of():
    with pytest.warns(UserWarning, match=r'2: gate: gate cmd_vel_in -> cmd_vel: a node'):
        load_scene(ONE, SceneGraph())


def test_a_urdf_cannot_hold_a_gate():
    robot = '<robot name="r"><link name="base"/></robot>'
    described = read_scene(robot, format='urdf')
    with pytest.raises(SceneFileError, match='cannot hold gates: gate a -> b'):
        to_urdf(replace(described, gates=(Gate('a', 'b', 'r'),)))
