"""``watch_trajectory`` by the client, on a real node: a controller runs, and a ball is pushed."""

import threading
import time

import numpy as np
import pytest
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM
from live.watching.test_trajectory_watch import IN_THE_WAY, ROWS, STILL
from live.watching.watched_arm import SCENE
from ros.harness import PATIENCE, start_node
from sensor_msgs.msg import JointState

from drake_geom_ros.client import RefusedError, SceneGraphClient
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

pytestmark = pytest.mark.topics

TIMES = (0.0, 20.0, 40.0)  # [s] slow, so that a loaded machine pushes the ball in time
WAY = {'joint_names': JOINTS_OF_ARM, 'path': ROWS, 'times': TIMES, 'velocities': STILL}
FAR = RigidTransform([9.0, 9.0, 9.0])


@pytest.fixture(scope='module')
def asked(tmp_path_factory):
    folder = tmp_path_factory.mktemp('watched')
    (folder / 'arm.urdf').write_text(ARM)
    (folder / 'cell.yaml').write_text(SCENE.format(folder=folder))
    process = start_node(
        folder / 'log',
        name='watching',
        scene_file=folder / 'cell.yaml',
        use_joint_states=True,
        stale_after=5.0,
    )
    with SceneGraphClient('/watching', patience=PATIENCE) as client:
        yield client
    assert process.end() == 0, process.output()


class Controller:
    """Follows the trajectory, and keeps the ball where it is pushed."""

    def __init__(self, client):
        self.client = client
        self.publisher = client.node.create_publisher(JointState, '/joint_states', 10)
        client.wait_for(self.publisher.get_subscription_count, 'a listener to joint states')
        self.spline = JointSpline(JointTrajectory(TIMES, ROWS, STILL))
        self.ball, self.off = FAR, np.zeros(3)
        self.start = client.node.get_clock().now()
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self._thread.start()
        state = self.client.joint_states
        self.client.wait_for(lambda: not np.isnan(state()['arm::finger'].position), 'its values')
        return self

    def __exit__(self, *raised):
        self._done.set()
        self._thread.join()

    def _run(self):
        while not self._done.is_set():
            now = self.client.node.get_clock().now()
            q = self.spline.value((now - self.start).nanoseconds * 1e-9) + self.off
            message = JointState(name=list(JOINTS_OF_ARM), position=q.tolist())
            message.header.stamp = now.to_msg()
            self.publisher.publish(message)
            self.client.publish_poses({'free': self.ball})
            time.sleep(0.02)


def outcome_of(client, name):
    state = client.trajectory_states().get(name)
    return '' if state is None else state.outcome


def test_a_ball_is_pushed_into_a_way_that_runs(asked):
    with Controller(asked) as controller:
        start = controller.start.nanoseconds * 1e-9
        name = asked.watch_trajectory(**WAY, start=start, name='way')
        assert name == 'way'
        asked.wait_for(lambda: outcome_of(asked, name) == 'clear', 'a clear way')
        state = asked.trajectory_states()[name]
        assert not state.ended
        assert abs(state.start - start) < 1e-6
        with pytest.raises(TypeError, match='neither true nor false'):
            bool(state)
        controller.ball = RigidTransform(IN_THE_WAY)
        asked.wait_for(lambda: outcome_of(asked, name) == 'contact', 'the ball to be told of')
        state = asked.trajectory_states()[name]
        assert 'cell::free/ball' in state.names
        assert state.now < state.last_free <= state.times[1] < TIMES[-1]
        controller.ball = FAR
        asked.wait_for(lambda: outcome_of(asked, name) == 'clear', 'a clear way again')
        controller.off = np.array([0.2, 0.0, 0.0])
        asked.wait_for(lambda: asked.trajectory_states()[name].deviates, 'the deviation')
        state = asked.trajectory_states()[name]
        assert (state.outcome, state.deviating_joint) == ('unknown', 'shoulder')
        asked.unwatch_trajectory(name)
        asked.wait_for(lambda: not asked.trajectory_states(), 'nothing to be watched')
        with pytest.raises(RefusedError, match="no trajectory 'way' is watched"):
            asked.unwatch_trajectory(name)


def test_a_trajectory_that_is_over_or_unknown_is_refused(asked):
    with pytest.raises(RefusedError, match='nothing of it is left'):
        asked.watch_trajectory(**WAY, start=time.time() - 100.0)
    with pytest.raises(RefusedError, match="no joint 'elbow'"):
        asked.watch_trajectory(['elbow'], [[0.0], [1.0]], [0.0, 1.0])
