"""What the client asks by joints, on a real node: "what if", and many states in one call."""

import numpy as np
import pytest
from live.inputs.test_joint_input import JOINTS_OF_ARM
from live.services.test_states import BOUNDS, cell_in
from ros.harness import PATIENCE, start_node
from sensor_msgs.msg import JointState

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.client import RefusedError, SceneGraphClient, states
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

pytestmark = pytest.mark.topics

NAMES = [f'arm::{name}' for name in JOINTS_OF_ARM]


@pytest.fixture(scope='module')
def scene_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp('states')
    path = folder / 'cell.yaml'
    path.write_text(cell_in(folder))
    return path


@pytest.fixture(scope='module')
def asked(scene_file):
    process = start_node(
        scene_file.parent / 'log', name='planned', scene_file=scene_file, use_joint_states=True
    )
    with SceneGraphClient('/planned', patience=PATIENCE) as client:
        yield client
    assert process.end() == 0, process.output()


@pytest.fixture(scope='module')
def batch(scene_file):
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(scene_file, scene_graph), NAMES)
    return lambda rows, **fields: evaluate(scene_graph, states=rows, joints=joints, **fields)


@pytest.fixture
def rows():
    return np.random.default_rng(6).uniform(*BOUNDS, size=(500, 3))


def test_the_scene_tells_its_joints(asked):
    joints = asked.scene().joints
    assert [joint.full_name for joint in joints] == NAMES
    assert [joint.type for joint in joints] == ['revolute', 'continuous', 'prismatic']
    assert joints[0].limits == (-1.0, 2.0)
    assert joints[1].limits == (-np.inf, np.inf)
    assert joints[2].frame == ('arm', 'left')


def test_a_state_asked_alone_is_that_of_many_to_the_bit(asked, rows):
    found = asked.evaluate_states(JOINTS_OF_ARM, rows, 'least')
    for row in range(0, 500, 100):
        joints = dict(zip(JOINTS_OF_ARM, rows[row].tolist(), strict=True))
        pairs = asked.signed_distances(joints=joints)
        least = np.argmin(pairs.distance - pairs.error_bound)
        assert pairs.distance[least] == found.distance[row]
        ids = {int(pairs.id_a[least]), int(pairs.id_b[least])}
        assert ids == set(found.ids[row].tolist())
        assert all(name.startswith(('arm::', 'cell::')) for name in found.names(row))
        overlaps = asked.has_collisions(joints=joints)
        assert overlaps == bool(len(asked.penetrations(joints=joints)))
        assert overlaps <= (not found.free[row])


def test_many_parts_are_one_answer(asked, batch, rows, monkeypatch):
    monkeypatch.setattr(states, '_MOST_NUMBERS', 300)
    monkeypatch.setattr(states, '_MOST_OF_PAIRS', 70)
    done = []
    collides = batch(rows, want='collision', max_distance=0.05)
    found = asked.evaluate_states(
        NAMES, rows, clearance=0.05, progress=lambda *each: done.append(each)
    )
    assert done == [(100 * k, 500) for k in range(1, 6)]
    assert found.free.tolist() == (~collides).tolist()
    assert found.first_not_free == int(np.argmax(collides))
    # Nobody has posed the robot's links: their age is unknown, which a state's answer must tell.
    assert found.oldest_pose_age == np.inf
    near = asked.evaluate_states(NAMES, rows, 'near', max_distance=0.3)
    expected = batch(rows, want='within', max_distance=0.3)
    assert near.offsets.tolist() == expected.offsets.tolist()
    assert near.distance.tolist() == expected.distance.tolist()
    first = asked.evaluate_states(NAMES, rows, clearance=0.05, stop_at_first=True)
    assert first.free.tolist() == found.free[: found.first_not_free + 1].tolist()


def test_what_is_refused_is_told(asked, rows):
    with pytest.raises(RefusedError, match='there is no joint'):
        asked.evaluate_states(['elbow'], rows[:, :1])
    with pytest.raises(RefusedError, match="no joint 'elbow'"):
        asked.has_collisions(joints={'elbow': 1.0})
    with pytest.raises(RefusedError, match='nothing was heard of the joints'):
        asked.has_collisions(joints={'shoulder': 1.0})


def test_no_states_have_no_answers(asked):
    found = asked.evaluate_states(JOINTS_OF_ARM, np.zeros((0, 3)))
    assert len(found.free) == 0
    assert found.first_not_free == -1


def test_the_scene_tells_where_its_joints_are(asked):
    joints = {joint.name: joint for joint in asked.scene().joints}
    assert not any(joint.state.is_known for joint in joints.values())
    publisher = asked.node.create_publisher(JointState, '/joint_states', 10)
    asked.wait_for(publisher.get_subscription_count, 'a listener to joint states')

    def heard():
        message = JointState(name=['shoulder', 'wrist'], position=[0.5, -0.3], velocity=[0.1, 0.0])
        message.header.stamp = asked.node.get_clock().now().to_msg()
        publisher.publish(message)
        return asked.joint_states(['shoulder'])['arm::shoulder'].is_known

    asked.wait_for(heard, 'the joints')
    shoulder, wrist, finger = (joint.state for joint in asked.scene().joints)
    assert (shoulder.position, shoulder.velocity, wrist.position) == (0.5, 0.1, -0.3)
    assert 0.0 <= shoulder.age < 30.0
    assert not finger.is_known
    assert finger.age == np.inf
    with pytest.raises(RefusedError, match="no joint 'elbow'"):
        asked.joint_states(['elbow'])
