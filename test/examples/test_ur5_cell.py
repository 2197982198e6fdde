"""The cell of examples/ur5_cell, run: it stops near the fence, on silence, and takes the part."""

import signal
import subprocess
import sys

import numpy as np
import pytest
from conventions.source_tree import ROOT
from ros.harness import LATCHED, PATIENCE, Process, environment
from ros.scene_calls import accepted
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from drake_geom_ros.client import SceneGraphClient
from drake_geom_ros.math import RigidTransform

pytestmark = pytest.mark.topics

CELL = ROOT / 'examples/ur5_cell'


class Cell:
    """The three processes of the cell, and what a test sees of them."""

    def __init__(self, folder, client):
        self.client = client
        params = ['--ros-args', '--params-file', str(CELL / 'cell_params.yaml')]
        scene = ['-p', f'scene_file:={CELL / "cell.yaml"}']
        player = ['-p', f'trajectory_file:={CELL / "motion.yaml"}', '-p', 'joint_states:=true']
        programs = ROOT / 'scripts'
        self.node = Process(folder / 'node', programs / 'scene_graph_node', *params, *scene)
        self.player = Process(
            folder / 'player', programs / 'pose_player', '--ros-args', *scene, *player
        )
        self.log = folder / 'monitor'
        with self.log.open('w') as log:
            self.monitor = subprocess.Popen(
                [sys.executable, str(CELL / 'stop_monitor.py'), *params],
                env=environment(),
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        client.server = '/stop_monitor'
        self.stops = client.listen(Bool, 'stop', LATCHED)

    def close(self):
        self.monitor.send_signal(signal.SIGINT)
        self.monitor.wait(20.0)
        codes = [self.player.end(), self.node.end()]
        assert codes == [0, 0], self.player.output() + self.node.output()
        assert 'Traceback' not in self.said() + self.node.output()

    def said(self):
        return self.log.read_text()

    def wait_until_said(self, *words):
        end = len(self.said())
        self.client.wait_for(
            lambda: all(each in self.said()[end:] for each in words), f'{words} of the monitor'
        )

    def do(self, name):
        return accepted(self.client.call(Trigger, name)).message


@pytest.fixture(scope='module')
def cell(tmp_path_factory):
    from ros.harness import Client

    client = Client()
    cell = Cell(tmp_path_factory.mktemp('cell'), client)
    try:
        yield cell
    finally:
        cell.close()
        client.close()


@pytest.fixture(scope='module')
def asking():
    with SceneGraphClient(patience=PATIENCE) as client:
        yield client


def test_it_stops_near_the_part_and_near_the_fence_and_goes_between(cell):
    cell.client.wait_for(lambda: cell.stops, 'a word of the monitor')
    cell.client.wait_for(lambda: 'go\n' in cell.said(), 'go')
    cell.wait_until_said(
        'hands off entered, near: cell::part/body to ur5::tool0/gripper: 0.0',
        *('stop: hands off: near\n', 'go\n', 'cell::world/fence: 0.0'),
    )
    assert {stop.data for stop in cell.stops} == {True, False}


def relative(asking):
    """Return where the part is, in the gripper, at one moment: both rest or move together."""
    X_WG, X_WP = (pose(asking, frame) for frame in ('ur5::tool0', 'cell::part'))
    return X_WG, X_WG.inverse() @ X_WP


def pose(asking, frame):
    p = (answer := asking.ask('get_pose', frame=frame).pose.pose).position
    q = answer.orientation
    return RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])


def at_rest(asking):
    """Return the gripper's pose and the part's in it while the arm rests."""
    before = relative(asking)
    after = relative(asking)
    return after if before[0].IsNearlyEqualTo(after[0], 1e-9) else None


def test_the_part_is_taken_and_put_down_without_a_fight(cell, asking):
    start = pose(asking, 'cell::part')
    assert cell.do('expect_contact') == 'ur5::tool0 may touch cell::part'
    reasons = asking.explain_filter('tool0/gripper', 'part/body')
    assert any('stop_monitor' in reason for reason in reasons), reasons

    # Taken while the arm rests at the part, 1 mm above it.
    def at_the_part():
        found = at_rest(asking)
        return found if found and np.linalg.norm(found[1].translation()) < 0.12 else None

    cell.client.wait_for(at_the_part, 'the arm at the part')
    assert cell.do('attach') == 'cell::part follows ur5::tool0'
    held = cell.client.wait_for(lambda: at_rest(asking), 'a rest')[1]

    def elsewhere():
        found = at_rest(asking)
        return found if found and found[0].translation()[2] > 0.25 else None

    X_WG, X_GP = cell.client.wait_for(elsewhere, 'the arm at rest elsewhere')
    assert X_GP.IsNearlyEqualTo(held, 1e-6)
    assert not (X_WG @ X_GP).IsNearlyEqualTo(start, 0.05)
    # The part is watched as the arm is.
    cell.wait_until_said('stop: ')
    assert cell.do('release') == 'cell::part stays where it is'
    cell.client.wait_for(
        lambda: not asking.explain_filter('tool0/gripper', 'part/body'), 'the lease to run out'
    )
    put_down = pose(asking, 'cell::part')  # seconds later: the transform has come by then
    for _ in range(3):
        cell.client.wait_for(
            lambda: not pose(asking, 'ur5::tool0').IsNearlyEqualTo(X_WG, 0.01), 'the arm elsewhere'
        )
        assert pose(asking, 'cell::part').IsNearlyEqualTo(put_down, 1e-12)
    assert 'in turn' not in cell.node.output()


def test_it_stops_when_the_poses_stop_and_when_the_results_do(cell):
    """Last: the player is gone then."""
    cell.client.wait_for(lambda: not cell.stops[-1].data, 'go')
    assert cell.player.end() == 0
    cell.client.wait_for(lambda: 'stop: hands off: stale' in cell.said().splitlines()[-1], 'stop')
    cell.stops.clear()  # what it said before may come after its line in the log
    cell.client.wait_for(
        lambda: len(cell.stops) > 10 and all(stop.data for stop in cell.stops[-10:]), 'stop'
    )
    cell.node.popen.send_signal(signal.SIGSTOP)
    try:
        cell.wait_until_said('stop: scene_graph is silent')
    finally:
        cell.node.popen.send_signal(signal.SIGCONT)
