"""Stoppable rules about sensed maps count what sensors see beside bodies, and what none sees."""

import numpy as np
from live.inputs.sensing_node import Node, cloud
from live.scene.test_scene_stopping import CYCLE, ROD, TYPES, Topic, joint_state

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.outputs.rule_events import RuleEvents, RuleSettings, RuleTopics

SCENE = """
sources: [rod, s]
robots: [{{name: rod, urdf: {urdf}, pose: {{}}}}]
frames: [{{name: mast, source: s, pose: {{position: [0.5, 0, 2]}}, static: true}}]
proximity_rules:
- {{name: stop, set_a: rod, set_b: obstacles, level: stoppable, decelerations: 2.0,
   reaction_time: 0.05, margin: 0.005}}
"""
MAST = np.array([0.5, 0.0, 2.0])
FAR = np.array([[0.5, 3.0, 0.0], [0.5, -3.0, 0.0]])
AHEAD = np.array([1.0, 0.0, 0.0])
SIDE = 0.01  # [m] half the rod's width


def beside(gap):
    """Return points beside the rod's end, at a gap [m]."""
    steps = np.linspace(0.0, 0.005, 3)
    grid = np.stack(np.meshgrid(0.95 + steps, SIDE + gap + steps, steps), axis=-1)
    return grid.reshape(-1, 3)


class Cell:
    """A node with a rod that turns, and a sensor above it."""

    def __init__(self, folder, **changes):
        (folder / 'rod.urdf').write_text(ROD)
        usual = {'resolution': 0.01, 'self_filter': 'scene', 'padding': 0.05, 'noise': 0.001}
        scene = SCENE.format(urdf=folder / 'rod.urdf')
        self.node = Node(scene=scene, **{**usual, **changes})
        self.joints = JointInput(self.node.live.clocks, 1.0, by_default=True)
        self.topics = RuleTopics(*(Topic() for _ in range(5)))
        self.events = RuleEvents(self.topics, TYPES, lambda: RuleSettings(1.0), lambda *_: None)

    def see(self, *parts, speed):
        """Take a cloud and joint values; return what ~/stopping says, and its place."""
        clock = self.node.clock
        clock.now += CYCLE
        with self.node.live.editing() as scene:
            self.joints.take(scene, joint_state(0.0, clock.now, speed), 0.0)
        self.node.taker.take_cloud(cloud(np.concatenate(parts) - MAST, 'mast', clock.now))
        with self.node.live.editing() as scene:
            self.events.look_at(scene, None, 0.0)
        return self.topics.stopping.published[-1]


def test_what_a_sensor_sees_beside_a_rod_slows_it(tmp_path):
    cell = Cell(tmp_path)
    cell.see(FAR, speed=0.5)
    clear = cell.see(FAR, speed=0.5)
    assert (list(clear.clear), list(clear.scale)) == ([True], [1.0])
    scales = []
    for gap in (0.04, 0.03, 0.02, 0.012):
        told = cell.see(FAR, beside(gap), speed=0.5)
        with cell.node.live.reading() as scene:
            ((_, shell),) = scene.maps.shells()
        assert len(shell.centres), 'the map holds them, and not the shell'
        assert not told.clear[0]
        assert {told.geometry_a[0], told.geometry_b[0]} >= {'rod::rod/collision_0'}
        scales.append(told.scale[0])
    assert 1.0 > scales[0] > scales[-1] >= 0.0
    assert scales == sorted(scales, reverse=True)
    stands = cell.see(FAR, beside(0.012), speed=0.0)
    assert stands.clear[0], 'what stands needs no stop'


def test_a_rod_out_of_the_sight_of_all_sensors_proves_no_stop(tmp_path):
    for box, is_seen in (((2.0, -4.0, -1.0, 4.0, 4.0, 1.0), False), ((), True)):
        cell = Cell(tmp_path, box=box)
        cell.see(FAR + 2.0 * AHEAD, speed=0.2)
        told = cell.see(FAR + 2.0 * AHEAD, speed=0.2)
        assert told.clear[0] == is_seen
        assert ('out of the sight' in told.trouble[0]) == (not is_seen)
        assert (told.scale[0] == 1.0) == is_seen
        assert cell.topics.speed_scale.published[-1].data == told.scale[0]
