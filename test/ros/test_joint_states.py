"""Joint states to a real node: no TF, no state publisher, and links stand where they should."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import srv
from drake_geom_msgs.msg import ProximityEvents, ProximityStates
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM, expected
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import Client, start_node
from ros.scene_calls import accepted, place_of
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from drake_geom_ros.math import RigidTransform

pytestmark = pytest.mark.topics

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SCENE = """
robots:
- {{name: arm, urdf: {0}/arm.urdf, pose: {{position: [1, 2, 3]}}}}
- {{name: twin, urdf: {0}/arm.urdf, pose: {{}}, joint_states: /twin/joint_states}}
geometries:
- {{name: post, pose: {{position: [50, 0, 0]}}, shape: {{type: sphere, radius: 0.1}}}}
proximity_rules:
- {{name: keep off, set_a: arm, set_b: post, level: stop, enter: 0.1, leave: 0.2}}
"""
X_WB = RigidTransform([1.0, 2.0, 3.0])


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp('joint_states')
    (folder / 'arm.urdf').write_text(ARM)
    (folder / 'cell.yaml').write_text(SCENE.format(folder))
    return folder


@pytest.fixture(scope='module')
def server():
    return '/joint_states_node'


@pytest.fixture(scope='module')
def node(folder, server):
    process = start_node(
        folder / 'log',
        name=server[1:],
        scene_file=folder / 'cell.yaml',
        use_joint_states=True,
        max_distance=10.0,
    )
    yield process
    assert process.end() == 0, process.output()


class Driver:
    """Sends joint values by name on a topic that the node listens to."""

    def __init__(self, client, topic='/joint_states', **positions):
        self.publisher = client.node.create_publisher(JointState, topic, 10)
        self.positions = positions
        client.wait_for(self.publisher.get_subscription_count, f'a listener to {topic}')
        self.clock = client.node.get_clock()

    def send(self, **positions):
        self.positions |= positions
        names, values = list(self.positions), list(map(float, self.positions.values()))
        message = JointState(name=names, position=values)
        message.header.stamp = self.clock.now().to_msg()
        self.publisher.publish(message)


def wait_until_it_stands(client, q, *drivers, robot='arm', base=X_WB):
    """Wait until all links stand as joints put them, drivers sending again and again."""
    for link, X_WL in expected(q, base).items():

        def is_there(link=link, place=X_WL[:3, 3]):
            for driver in drivers:
                driver.send()
            now = place_of(client, f'{robot}::{link}')
            return now is not None and np.allclose(now, place, rtol=0, atol=1e-12)

        client.wait_for(is_there, f'{robot}::{link} at {X_WL[:3, 3]}')


def status(client, listening):
    listening.clear()
    name = client.server.removeprefix('/')
    client.wait_for(
        lambda: any(name in each.status[0].name for each in listening), 'the diagnostics'
    )
    return next(each.status[0] for each in listening if name in each.status[0].name)


def test_joint_states_alone_pose_a_robot(node, client):
    assert place_of(client, 'arm::hand') is None
    driver = Driver(client, shoulder=0.5, wrist=-0.3, finger=0.02)
    wait_until_it_stands(client, [0.5, -0.3, 0.02], driver)


def test_two_drivers_with_a_part_of_the_joints_each_add_up(node, client):
    arm, gripper = Driver(client, shoulder=-0.4, wrist=0.9), Driver(client, finger=0.07)
    wait_until_it_stands(client, [-0.4, 0.9, 0.07], arm, gripper)


def test_a_robot_with_its_own_topic_hears_that_one_alone(node, client):
    everybodys = Driver(client, shoulder=0.1, wrist=0.1, finger=0.1)
    wait_until_it_stands(client, [0.1, 0.1, 0.1], everybodys)
    assert place_of(client, 'twin::hand') is None
    own = Driver(client, '/twin/joint_states', shoulder=0.2, wrist=0.3, finger=0.0)
    wait_until_it_stands(client, [0.2, 0.3, 0.0], own, robot='twin', base=RigidTransform())
    wait_until_it_stands(client, [0.1, 0.1, 0.1])


def test_two_publishers_of_the_same_joints_enter_a_stop_rule_and_are_named(node, client):
    """A leftover joint_state_publisher beside a driver: the arm flips between two places."""
    rules = client.listen(ProximityStates, 'proximity_states', LATCHED)
    heard = client.listen(DiagnosticArray, '/diagnostics')
    driver = Driver(client, shoulder=0.5, wrist=0.3, finger=0.02)
    leftover = Driver(client, shoulder=0.0, wrist=0.0, finger=0.0)

    def why(*senders):
        for sender in senders:
            sender.send()
        return rules[-1].why[0] if rules else None

    def is_reported():
        why(*both)
        return any(
            'are sent by two senders in turn' in status.message
            for each in heard
            for status in each.status
        )

    both = (driver, leftover)
    client.wait_for(lambda: why(driver) == 0, 'no reason to stop, far from the post')
    client.wait_for(lambda: why(*both) == ProximityEvents.TWO_SENDERS, 'a stop by two senders')
    client.wait_for(is_reported, 'the trouble in /diagnostics')
    client.wait_for(lambda: why(driver) == 0, 'one sender alone again')


def test_what_is_wrong_is_counted_and_told_and_nothing_moves(node, client):
    heard = client.listen(DiagnosticArray, '/diagnostics')
    driver = Driver(client, shoulder=5.0, wrist=0.1, finger=0.1)
    wait_until_it_stands(client, [5.0, 0.1, 0.1], driver)
    wrong = [
        JointState(name=['shoulder', 'wrist'], position=[0.0]),
        JointState(name=['shoulder'], position=[float('nan')]),
        JointState(name=['somebody'], position=[0.0]),
    ]

    def refused():
        for message in wrong:
            driver.publisher.publish(message)
        found = status(client, heard)
        values = {entry.key: entry.value for entry in found.values}
        told = all(any(why in key for key in values) for why in whys)
        counted = int(values.get('refused from joint_states', 0)) >= 3
        return found if told and counted else None

    whys = 'is nan; it must be finite', 'position holds 1 number for 2 names'
    found = client.wait_for(refused, 'three refusals')
    assert 'arm::shoulder [-1, 2]' in found.message
    wait_until_it_stands(client, [5.0, 0.1, 0.1])
    assert 'arm::shoulder [-1, 2]' in node.output()


def test_topics_of_robots_come_and_go_with_them(node, client, folder):
    other = SCENE.format(folder).replace('/twin/joint_states', '/other/joint_states')
    request = {'text': other, 'replace': True}
    accepted(client.call(srv.LoadScene, 'load_scene', **request))
    other = Driver(client, '/other/joint_states', shoulder=0.2, wrist=0.3, finger=0.0)
    wait_until_it_stands(client, [0.2, 0.3, 0.0], other, robot='twin', base=RigidTransform())
    client.wait_for(
        lambda: client.node.count_subscribers('/twin/joint_states') == 0, 'the topic to be left'
    )
    # What the arm was told before holds still: the next joint brings all of them.
    wait_until_it_stands(client, [5.0, 0.1, 0.03], Driver(client, finger=0.03))


def test_a_described_robot_needs_nothing_but_joint_states(tmp_path):
    server = '/described'
    process = start_node(
        tmp_path / 'log', name=server[1:], use_joint_states=True, world_frame='base'
    )
    client = Client(server)
    try:
        publisher = client.node.create_publisher(String, '/robot_description', LATCHED)
        publisher.publish(String(data=ARM))
        client.wait_for(lambda: 'arm::hand' in names_of(client), 'the robot')
        driver = Driver(client, shoulder=0.5, wrist=-0.3, finger=0.02)
        wait_until_it_stands(client, [0.5, -0.3, 0.02], driver, base=RigidTransform())
        for k, q in enumerate(np.linspace(0.0, 1.0, 20)):  # replaced in the midst of the stream
            if k == 10:
                publisher.publish(String(data=ARM.replace('xyz="1 0 0" rpy', 'xyz="1 0 1" rpy')))
            driver.send(**dict.fromkeys(JOINTS_OF_ARM, q))

        def moved():
            driver.send(**dict.fromkeys(JOINTS_OF_ARM, 0.0))
            now = place_of(client, 'arm::hand')
            return now is not None and np.allclose(now, [1, 0, 2], rtol=0, atol=1e-12)

        client.wait_for(moved, 'the other robot to follow')
    finally:
        client.close()
        assert process.end() == 0, process.output()


def names_of(client):
    answer = client.call(srv.GetPose, 'get_pose', frame='arm::hand')
    return '' if 'There is no frame' in answer.message else 'arm::hand'
