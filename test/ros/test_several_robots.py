"""Robots on topics of their own, beside one of the scene file that comes by topic, too."""

import pytest
from drake_geom_msgs import msg
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM
from ros.harness import LATCHED, start_node
from ros.scene_calls import place_of
from sensor_msgs.msg import JointState
from std_msgs.msg import String

pytestmark = pytest.mark.topics

DESCRIPTIONS = '{arm2: {namespace: /two, pose: {position: [0, 3, 0]}}}'


@pytest.fixture
def node(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    scene = f'robots: [{{name: arm1, urdf: {tmp_path}/arm.urdf, pose: {{}}}}]\n'
    (tmp_path / 'scene.yaml').write_text(scene)
    process = start_node(
        tmp_path / 'log',
        scene_file=tmp_path / 'scene.yaml',
        use_joint_states=True,
        robot_descriptions=f"'{DESCRIPTIONS}'",
    )
    yield process
    assert process.end() == 0, process.output()


def names(scene):
    return {source.name for source in scene.sources} - {'SceneGraphInternal'}


def test_each_robot_follows_its_joints_and_the_known_one_is_not_doubled(node, lone_client):
    client = lone_client
    scenes = client.listen(msg.Scene, 'scene', LATCHED)
    for topic in ('/robot_description', '/two/robot_description'):
        client.node.create_publisher(String, topic, LATCHED).publish(String(data=ARM))
    client.wait_for(lambda: scenes and names(scenes[-1]) == {'arm1', 'arm2'}, 'both robots')
    client.wait_for(lambda: "this is 'arm1' of the scene" in node.output(), 'the log to say so')
    senders = {
        topic: client.node.create_publisher(JointState, topic, 10)
        for topic in ('/joint_states', '/two/joint_states')
    }
    for sender in senders.values():
        client.wait_for(sender.get_subscription_count, 'the node to listen')

    def stands(topic, robot, shoulder, expected):
        def is_there():
            senders[topic].publish(JointState(name=JOINTS_OF_ARM, position=[shoulder, 0.0, 0.0]))
            return place_of(client, f'{robot}::hand') == pytest.approx(expected)

        return is_there

    quarter = 1.5707963267948966
    client.wait_for(stands('/joint_states', 'arm1', 0.0, [1.0, 0.0, 1.0]), 'arm1 by joint_states')
    client.wait_for(
        stands('/two/joint_states', 'arm2', quarter, [0.0, 4.0, 1.0]), 'arm2 by its own topic'
    )
    assert place_of(client, 'arm1::hand') == pytest.approx([1.0, 0.0, 1.0])
