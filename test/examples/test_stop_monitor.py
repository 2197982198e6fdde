"""The monitor of examples/ur5_cell says stop while its robot is not there, and goes once it is."""

import signal
import subprocess
import sys
import time

import pytest
from conventions.source_tree import ROOT
from drake_geom_msgs import msg, srv
from ros.harness import LATCHED, environment, start_node
from ros.scene_calls import accepted, poses
from std_msgs.msg import Bool

pytestmark = pytest.mark.topics

SCENE = """
sources: [cell, {robot}]
frames:
- {{name: cart, source: cell, pose: {{position: [5, 0, 0]}}}}
- {{name: 'arm::hand', source: {robot}}}
geometries:
- {{name: block, source: cell, shape: {{type: box, size: [1, 1, 1]}}}}
- {{name: load, source: cell, frame: cart, shape: {{type: box, size: [1, 1, 1]}}}}
- {{name: ball, source: {robot}, frame: 'arm::hand', shape: {{type: sphere, radius: 0.1}}}}
proximity_rules:
- {{name: hands off, set_a: {watched}, level: stop, enter: 0.05, leave: 0.06}}
"""


class Watched:
    """A node, and a monitor of the rule that watches ``robot``."""

    def __init__(self, folder, client, robot):
        self.client, self.at, self.watched = client, None, robot
        self.node = start_node(folder / 'node', max_distance=0.5, stale_after=5.0)
        self.log = folder / 'monitor'
        with self.log.open('w') as log:
            self.monitor = subprocess.Popen(
                [sys.executable, str(ROOT / 'examples/ur5_cell/stop_monitor.py')],
                env=environment(),
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        self.stops = client.listen(Bool, '/stop_monitor/stop', LATCHED)
        self._poses = client.publisher(msg.FramePoses, 'frame_poses')

    def load(self, robot):
        """Load the scene with a robot of that name, which has no pose yet."""
        text = SCENE.format(robot=robot, watched=self.watched)
        accepted(self.client.call(srv.LoadScene, 'load_scene', text=text, replace=True))
        self.robot, self.at = robot, None

    def move(self):
        """Send the poses of now."""
        frames, places = ['cell::cart'], [(5, 0, 0)]
        if self.at is not None:
            frames, places = [*frames, f'{self.robot}::arm::hand'], [*places, self.at]
        self._poses.publish(poses(frames, places))

    def says(self, words):
        """Wait until the monitor says something, which is its last word then."""

        def said():
            self.move()
            lines = self.log.read_text().splitlines()
            return lines and words in lines[-1]

        try:
            self.client.wait_for(said, f'{words!r} of the monitor')
        except AssertionError as error:
            raise AssertionError(f'{error}, which says:\n{self.log.read_text()}') from None

    def stays(self, stop, seconds=1.5):
        """Wait a while, in which the monitor must not change its mind."""
        self.client.wait_for(lambda: self.stops and self.stops[-1].data == stop, f'stop: {stop}')
        self.stops.clear()
        end = time.monotonic() + seconds

        def waited():
            self.move()
            return time.monotonic() > end and len(self.stops) > 10

        self.client.wait_for(waited, 'ten words of the monitor')
        assert {word.data for word in self.stops} == {stop}

    def close(self):
        self.monitor.send_signal(signal.SIGINT)
        assert self.monitor.wait(20.0) == 0
        self.client.wait_for(lambda: self.stops and self.stops[-1].data, 'stop as its last word')
        assert self.node.end() == 0, self.node.output()
        assert 'Traceback' not in self.log.read_text()


@pytest.fixture
def watch(tmp_path, lone_client):
    """Return a function that starts a node, and a monitor of a rule about a robot."""
    started = []

    def start(robot):
        started.append(Watched(tmp_path, lone_client, robot))
        return started[0]

    yield start
    for each in started:
        each.close()


def test_a_misspelt_robot_is_stopped_for_ever_and_the_nearest_name_is_told(watch):
    watched = watch('rigth')
    watched.load('right')
    watched.at = (0.0, 0.0, 0.0)  # right in the block: the robot that was meant
    watched.says("'rigth' stands for no geometry")
    assert "nearest: 'right'" in watched.log.read_text()
    watched.at = (0.0, 0.0, 3.0)
    watched.stays(stop=True)


def test_it_goes_once_its_robot_is_there_and_posed_and_stops_when_it_is_gone(watch):
    watched = watch('right')
    watched.says("there is no proximity rule 'hands off'")
    watched.load('other')
    watched.says("'right' stands for no geometry")
    watched.stays(stop=True)
    watched.load('right')
    watched.says('stop: hands off: no pose')
    watched.stays(stop=True)
    watched.at = (0.0, 0.0, 3.0)
    watched.says('go')
    watched.stays(stop=False)
    watched.at = (0.0, 0.0, 0.62)
    watched.says('stop: hands off: near')
    pair = 'hands off entered, near: cell::world/block to right::arm::hand/ball: 0.0200 m'
    assert pair in watched.log.read_text()
    watched.load('other')
    watched.at = (0.0, 0.0, 3.0)
    watched.says("'right' stands for no geometry")
    watched.load('right')
    watched.at = (0.0, 0.0, 3.0)
    watched.says('go')
