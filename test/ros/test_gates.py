"""Gates on the middleware: what a base hears of the commands that are sent to it."""

import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Twist, TwistStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from ros.harness import Client, start_node
from ros.scene_calls import accepted, poses, refused

pytestmark = pytest.mark.topics

SCENE = """
name: floor
sources: [base]
frames:
- {name: base_link, source: base, static: false}
geometries:
- {name: body, source: base, frame: base_link, shape: {type: sphere, radius: 0.1}}
- {name: post, shape: {type: sphere, radius: 0.1}}
proximity_rules:
- {name: stand, set_a: base, level: stop, enter: 0.05, leave: 0.1}
- {name: go slowly, set_a: base, level: slow, enter: 0.3, leave: 0.45}
gate: {in: cmd_vel_in, out: cmd_vel, robot: base}
"""
FAR, SLOW, NEAR = 1.2, 0.45, 0.24  # [m] of the base from the post, centre to centre


class Base:
    """A base, its driver, and who commands it."""

    def __init__(self, client, kind):
        self._client, self._kind = client, kind
        self.heard = client.listen(kind, '/cmd_vel')
        self._commands = client.node.create_publisher(kind, '/cmd_vel_in', 10)
        self._poses = client.publisher(msg.FramePoses, 'frame_poses')
        self.place = None
        self.is_commanded = True

    @property
    def speed(self):
        """The last speed (forward, about z) that the base heard; None: none."""
        if not self.heard:
            return None
        twist = self.heard[-1].twist if self._kind is TwistStamped else self.heard[-1]
        return round(twist.linear.x, 6), round(twist.angular.z, 6)

    def until(self, fact, what):
        """Command it, and pose it, until a fact holds."""
        due = 0.0

        def holds():
            nonlocal due
            if time.monotonic() > due:
                due = time.monotonic() + 0.05
                self._send()
            return fact()

        return self._client.wait_for(holds, what, 60.0)

    def _send(self):
        stamp = self._client.node.get_clock().now().to_msg()
        if self.place is not None:
            message = poses(['base_link'], [(self.place, 0, 0)], source='base')
            message.header.stamp = stamp
            self._poses.publish(message)
        if self.is_commanded:
            command = self._kind()
            twist = command.twist if self._kind is TwistStamped else command
            twist.linear.x, twist.angular.z = 0.8, -0.4
            if self._kind is TwistStamped:
                command.header.stamp, command.header.frame_id = stamp, 'base_link'
            self._commands.publish(command)


@pytest.fixture
def gated(tmp_path):
    (tmp_path / 'floor.yaml').write_text(SCENE)
    process = start_node(
        tmp_path / 'log', name='gated', scene_file=tmp_path / 'floor.yaml', stale_after=0.6
    )
    client = Client('/gated')
    yield client
    client.close()
    assert process.end() == 0, process.output()


@pytest.mark.parametrize('kind', [Twist, TwistStamped])
def test_a_base_goes_as_fast_as_its_rules_let_it(gated, kind):
    base = Base(gated, kind)
    base.until(lambda: base.speed == (0.0, 0.0), 'rest, before the first pose')
    base.place = FAR
    base.until(lambda: base.speed == (0.8, -0.4), 'full speed')
    base.place = SLOW
    base.until(lambda: base.speed == (0.4, -0.2), 'half of it')
    base.place = NEAR
    base.until(lambda: base.speed == (0.0, 0.0), 'a stop')
    base.place = FAR
    base.until(lambda: base.speed == (0.8, -0.4), 'full speed again')
    if kind is TwistStamped:
        assert base.heard[-1].header.frame_id == 'base_link'
    base.is_commanded = False
    base.until(lambda: base.speed == (0.0, 0.0), 'a stop for want of commands')
    base.is_commanded = True
    base.until(lambda: base.speed == (0.8, -0.4), 'full speed once more')
    base.place = None
    base.until(lambda: base.speed == (0.0, 0.0), 'a stop for a stale pose')
    base.place = FAR
    base.until(lambda: base.speed == (0.8, -0.4), 'full speed with poses')
    transition = Transition(id=Transition.TRANSITION_DEACTIVATE)
    assert gated.call(ChangeState, 'change_state', transition=transition).success
    gated.wait_for(lambda: base.speed == (0.0, 0.0), 'a stop of the node')


def test_diagnostics_name_the_gate_and_who_goes_around_it(gated):
    base = Base(gated, Twist)
    base.place = SLOW
    base.until(lambda: base.speed == (0.4, -0.2), 'half speed')
    told = gated.listen(DiagnosticArray, '/diagnostics')

    def status():
        values = {v.key: v.value for v in told[-1].status[0].values} if told else {}
        return values.get('gate /cmd_vel_in -> /cmd_vel', '')

    base.until(lambda: status().startswith('scale 0.5'), 'the scale')
    assert "proximity rule 'go slowly'" in status()
    gated.node.create_publisher(Twist, '/cmd_vel', 10)
    base.until(
        lambda: '1 more publish on /cmd_vel' in told[-1].status[0].message, 'who goes around it'
    )


def test_a_scene_with_another_gate_is_refused_and_that_of_the_node_is_saved(gated):
    saved = accepted(gated.call(srv.SaveScene, 'save_scene')).text
    assert 'gate: {in: cmd_vel_in, out: cmd_vel, robot: base}' in saved
    accepted(gated.call(srv.LoadScene, 'load_scene', text=saved, replace=True))
    other = SCENE.replace('out: cmd_vel', 'out: other')
    answer = gated.call(srv.LoadScene, 'load_scene', text=other, replace=True)
    refused(answer, 'gate cmd_vel_in -> other')


def test_a_second_gate_on_the_same_topics_is_refused_at_the_start(tmp_path):
    (tmp_path / 'floor.yaml').write_text(SCENE)
    second = "'{in: joystick, out: cmd_vel, robot: base}'"
    process = start_node(
        tmp_path / 'log', name='twice', scene_file=tmp_path / 'floor.yaml', gate=second
    )
    client = Client('/twice')
    try:
        client.wait_for(lambda: 'the node is not configured' in process.output(), 'a refusal', 60)
        told = "gate: the gate cmd_vel_in -> cmd_vel has the topic 'cmd_vel' of the gate joystick"
        assert told in process.output()
    finally:
        client.close()
        process.end()
