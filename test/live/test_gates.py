"""Gates of a parameter and of a scene file together, and what they pass of a base that brakes."""

import numpy as np
import pytest
from drake_geom_msgs import msg
from live.live_scenes import Clock, Topic, live_scene
from live.scene.test_scene_rules import TYPES

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.gates import all_gates, decide_gate, gates_of_parameter
from drake_geom_ros.live.outputs.rule_events import (
    PERIOD,
    RuleEvents,
    RuleSettings,
    RuleTopics,
    StopEffects,
)
from drake_geom_ros.live.velocity_gate import VelocityGate
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


BASE = """
<robot name="base"><link name="body"><collision><geometry><box size="0.6 0.4 0.4"/></geometry>
</collision></link><link name="wheel"/><joint name="wheel" type="continuous"><parent link="body"/>
<child link="wheel"/><axis xyz="0 1 0"/></joint></robot>
"""
BRAKES = 1.0  # [m/s^2]
REACTION, MARGIN = 0.1, 0.05
WALL = 2.0  # [m] its near side
FLOOR = """
name: floor
robots: [{{name: base, urdf: {urdf}, held_joints: {{wheel: 0}}}}]
geometries:
- {{name: wall, pose: {{position: [2.5, 0, 0]}}, shape: {{type: box, size: [1, 9, 1]}}}}
proximity_rules:
- name: can stop
  set_a: base
  level: stoppable
  decelerations: {{x: 1.0, y: 1.0, theta: 2.0}}
  reaction_time: 0.1
  margin: 0.05
"""


class Driven:
    """A base before a wall, a gate for its commands, and decisions as a node makes them."""

    def __init__(self, folder):
        (folder / 'base.urdf').write_text(BASE)
        self.clock = Clock()
        self.live = live_scene(FLOOR.format(urdf=folder / 'base.urdf'), self.clock)
        self.passed = []
        self.gate = VelocityGate(lambda twist, header: self.passed.append(twist), timeout=0.5)
        self.gate.open()
        settings = RuleSettings(stale_after=0.5)
        topics = RuleTopics(*(Topic() for _ in range(5)))
        self.effects = StopEffects.fresh()
        self.events = RuleEvents(
            topics, TYPES, lambda: settings, lambda pairs, seconds: None, self.effects
        )
        self.events.tell_gates = self._decide
        with self.live.editing() as scene:
            scene.poses.watch_motion(1.0)

    def _decide(self, scene):
        decide_gate(scene, 'base', self.gate, self.clock.now)

    def stand(self, x, yaw=0.0, command=(0.0,) * 6):
        """Stand at x [m] for two cycles with a command; return what passes (6,)."""
        for _ in range(2):
            self.clock.now += 0.02
            self.gate.take(np.array(command, dtype=float), self.clock.now)
            pose = msg.FramePoses(source='base', frame_names=['body'])
            turn = 0.0, 0.0, float(np.sin(yaw / 2)), float(np.cos(yaw / 2))
            pose.poses = [float(x), 0.0, 0.0, *turn]
            pose.header.stamp.sec = int(self.clock.now)
            pose.header.stamp.nanosec = round(self.clock.now % 1 * 1e9)
            with self.live.editing() as scene:
                scene.poses.take(pose)
                self.events.look_at(scene, None, 0.0)
        return self.passed[-1] if self.passed else np.zeros(6)


def shares(gap, speed):
    """Return the least and the greatest share of a speed that may pass by a gap [m]."""
    found = []
    for delay, resolution in ((PERIOD, 0.02), (0.0, 0.0)):
        t, a = REACTION + delay, 0.5 / BRAKES
        v = (-t + np.sqrt(t * t + 4 * a * max(gap - MARGIN, 0.0))) / (2 * a)
        found.append(min(1.0, v / speed) - resolution)
    return found


def test_a_base_goes_no_faster_than_it_can_stop_before_the_wall_along_its_command(tmp_path):
    driven, forward = Driven(tmp_path), (1.0, 0, 0, 0, 0, 0)
    driven.stand(-5.0)
    slow = 0
    for gap in (3.0, 0.6, 0.4, 0.2, 0.1):
        passed = driven.stand(WALL - 0.3 - gap, command=forward)
        low, high = shares(gap, 1.0)
        assert low <= passed[0] <= high + 1e-9
        assert not passed[1:].any()
        slow += passed[0] < 1.0
    assert slow >= 3
    at = WALL - 0.3 - 0.1
    assert driven.stand(at, command=(-1.0, 0, 0, 0, 0, 0))[0] == -1.0  # away from the wall
    assert driven.stand(at, np.pi, command=forward)[0] == 1.0  # in its own axes
    assert driven.stand(at, command=(0, 0.5, 0, 0, 0, 0))[1] == 0.5  # along the wall
    turned = driven.stand(WALL - 0.33, command=(0, 0, 0, 0, 0, 1.0))
    assert 0.0 <= turned[5] < 1.0  # its corner would touch the wall


def test_what_cannot_be_proved_of_a_command_does_not_pass(tmp_path):
    driven = Driven(tmp_path)
    driven.stand(-5.0)
    assert not driven.stand(-5.0, command=(1.0, 0, 0.1, 0, 0, 0)).any()
    assert 'only x, y and the turn' in driven.gate.allowed(driven.clock.now).why
    assert driven.stand(-5.0, command=(1.0, 0, 0, 0, 0, 0))[0] == 1.0
    driven.clock.now += 0.6  # of a stale base nothing is known
    with driven.live.reading() as scene:
        driven.events.look_again(scene)
    assert not driven.passed[-1].any()


def test_a_robot_whose_braking_no_rule_can_prove_does_not_move(tmp_path):
    driven = Driven(tmp_path)
    driven.stand(-5.0)
    with driven.live.reading() as scene:
        decide_gate(scene, 'body', driven.gate, driven.clock.now)
    assert 'is no robot whose braking' in driven.gate.allowed(driven.clock.now).why


def test_a_report_of_cycles_counts_what_proofs_look_at_and_leave_out(tmp_path):
    driven, forward = Driven(tmp_path), (1.0, 0, 0, 0, 0, 0)
    assert driven.effects.looked.take().reason == 'no rule of level stoppable'
    driven.stand(-9.0, command=forward)
    driven.stand(-8.98, command=forward)  # it moves, far from the wall
    looked, far_pairs, far_bodies, idle = (row.take() for row in driven.effects)
    assert (looked.count, looked.reason) == (0, '')
    assert min(far_pairs.count, far_bodies.count, idle.count) > 0
    driven.stand(WALL - 0.6)
    driven.effects.looked.take()
    driven.stand(WALL - 0.55)  # fast, beside it
    assert driven.effects.looked.take().count > 0
