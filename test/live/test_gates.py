"""Gates of a parameter and of a scene file together."""

import pytest

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.gates import all_gates, gates_of_parameter
from drake_geom_ros.scene_files import Gate, read_scene

ONE = '{in: cmd_vel_in, out: cmd_vel, robot: base}'
SCENE = read_scene(f'sources: [base]\ngate: {ONE}\n')


def test_gates_of_both_are_open_and_one_that_both_have_is_one():
    assert gates_of_parameter(' ') == all_gates('', None) == ()
    assert all_gates(ONE, None) == all_gates('', SCENE) == all_gates(ONE, SCENE) == SCENE.gates
    other = Gate('other_in', 'other', 'base')
    assert all_gates('{in: other_in, out: other, robot: base}', SCENE) == (other, *SCENE.gates)


@pytest.mark.parametrize('other', ['{in: cmd_vel_in, out: x, robot: base}', ONE[:-5] + 'arm}'])
def test_two_gates_with_a_topic_in_common_are_refused(other):
    with pytest.raises(ArgumentError, match="has the topic 'cmd_vel"):
        all_gates(other, SCENE)
