"""The key ``pose`` of a robot in a scene file: where its base stands until somebody poses it."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import TransformStamped
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import Client, start_node
from ros.scene_calls import accepted, place_of, poses, refused
from std_msgs.msg import String

pytestmark = pytest.mark.topics

tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='`./run test` builds it where it is missing')

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
# The mount is fixed to the base, turned by a quarter in the words of URDF 1.1.
ARM = f"""<robot name="arm" version="1.1">
<link name="base">{BALL}</link><link name="mount">{BALL}</link><link name="hand">{BALL}</link>
<joint name="screw" type="fixed"><parent link="base"/><child link="mount"/>
  <origin xyz="0 1 0" quat_xyzw="0 0 0.70710678118654752 0.70710678118654752"/></joint>
<joint name="turn" type="continuous"><parent link="mount"/><child link="hand"/></joint>
</robot>"""
# A robot with other links: that of the scene file would be recognised, and not come once more.
OF_TOPIC = ARM.replace('"hand"', '"gripper"')
SCENE = """
robots:
- {{name: {0}, urdf: {1}/arm.urdf, pose: {{position: [0, 0, {2}]}}}}
geometries:
- {{name: post of {0}, source: {0}, shape: {{type: box, size: [0.2, 0.2, 0.2]}}}}
"""


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp('robot_pose')
    (folder / 'arm.urdf').write_text(ARM)
    (folder / 'cell.yaml').write_text(SCENE.format('left', folder, 2))
    return folder


@pytest.fixture(scope='module')
def server():
    return '/robot_pose'


@pytest.fixture(scope='module')
def node(folder, server):
    process = start_node(
        folder / 'log',
        name=server[1:],
        scene_file=folder / 'cell.yaml',
        max_distance=10.0,
        use_tf=True,
    )
    yield process
    assert process.end() == 0, process.output()


def distance(client, one, other):
    """Return the signed distance of two geometries as the node answers it now."""
    request = {'geometry_a': one, 'geometry_b': other}
    answer = client.call(srv.ComputeSignedDistancePair, 'compute_signed_distance_pair', **request)
    return accepted(answer).result.distance[0]


def send(client, parent, child, x, *, static=False):
    topic, profile = ('/tf_static', LATCHED) if static else ('/tf', QoSProfile(depth=10))
    publisher = client.node.create_publisher(tf2_msgs.TFMessage, topic, profile)
    client.wait_for(publisher.get_subscription_count, f'a listener to {topic}')
    entry = TransformStamped(child_frame_id=child)
    entry.header.frame_id = parent
    entry.transform.translation.x = float(x)
    publisher.publish(tf2_msgs.TFMessage(transforms=[entry]))


def wait_until_at(client, frame, *place):
    def is_there():
        now = place_of(client, frame)
        return now is not None and now == pytest.approx(place, abs=1e-12)

    client.wait_for(is_there, f'{frame} at {place}')


def test_the_base_and_what_is_fixed_to_it_stand_where_the_scene_file_says(client):
    assert place_of(client, 'left::base') == (0, 0, 2)
    assert place_of(client, 'left::mount') == pytest.approx((0, 1, 2), abs=1e-15)
    assert place_of(client, 'left::hand') is None
    base = 'left::base/collision_0'
    assert distance(client, base, 'left::world/post of left') == pytest.approx(1.8, abs=1e-12)


def test_links_that_tf_poses_relative_to_the_base_stand_on_it(client):
    send(client, 'left/mount', 'left/hand', 1)
    wait_until_at(client, 'left::hand', 0, 2, 2)


def test_a_loaded_scene_does_the_same_until_messages_or_tf_pose_the_base(client, folder):
    text = SCENE.format('right', folder, 3)
    answer = accepted(client.call(srv.LoadScene, 'load_scene', text=text))
    assert (answer.frames, answer.message) == (3, '')
    assert place_of(client, 'right::base') == (0, 0, 3)
    send(client, 'right/base', 'right/hand', 1, static=True)
    wait_until_at(client, 'right::hand', 1, 0, 3)
    # A pose of the base counts from then on, and what hangs on it by TF goes with it at once.
    publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def is_posed():
        # Best effort: what is sent before the node has found who sends is lost.
        publisher.publish(poses(['base'], [(0, 5, 0)], 'right'))
        return place_of(client, 'right::base') == (0, 5, 0)

    client.wait_for(is_posed, 'the pose of the base')
    assert place_of(client, 'right::hand') == pytest.approx((1, 5, 0), abs=1e-12)
    # They are taken in order, so after another one none of them is left.
    publisher.publish(poses(['base'], [(0, 6, 0)], 'right'))
    client.wait_for(lambda: place_of(client, 'right::base') == (0, 6, 0), 'the last message')
    send(client, 'world', 'right/base', 7, static=True)
    wait_until_at(client, 'right::base', 7, 0, 0)
    assert place_of(client, 'right::hand') == pytest.approx((8, 0, 0), abs=1e-12)


def is_known(client, frame):
    """Return whether the scene has a frame, posed or not."""
    answer = client.call(srv.GetPose, 'get_pose', frame=frame)
    return answer.success or 'never had a pose' in answer.message


def refusals(client):
    """Return how many robots the node has refused so far."""
    heard = client.listen(DiagnosticArray, '/diagnostics')

    def told():
        return [d.status[0] for d in heard if d.status[0].name == client.server]

    values = {v.key: v.value for v in client.wait_for(told, 'diagnostics')[-1].values}
    return int(values.get('refused from robot_description', 0))


@pytest.mark.parametrize(
    ('bad', 'why'),
    [
        ('<robot name="foo"></robot>', 'no links; a robot has at least one'),
        (ARM.replace('name="turn"', 'name="screw"'), "joint 'screw' is listed twice"),
        (ARM.replace('parent link="base"', 'parent link="hand"'), 'joints form a ring'),
        (ARM.replace('child link="hand"', 'child link="mount"'), "'mount' has two parents"),
        ('<robot name="foo">', 'not XML'),
        ('', 'empty'),
    ],
    ids=['no links', 'one name', 'ring', 'two parents', 'cut off', 'nothing'],
)
def test_a_robot_that_cannot_be_is_refused_and_the_robot_stays(client, bad, why):
    publisher = client.node.create_publisher(String, '/robot_description', LATCHED)
    client.wait_for(publisher.get_subscription_count, 'a listener to robot_description')
    publisher.publish(String(data=OF_TOPIC))
    client.wait_for(lambda: is_known(client, 'arm::base'), 'the robot of the topic')
    before = refusals(client)
    request = {'text': bad, 'format': 'urdf', 'replace': True}
    refused(client.call(srv.LoadScene, 'load_scene', **request), why)
    publisher.publish(String(data=bad))
    client.wait_for(lambda: refusals(client) > before, 'the refusal')
    assert is_known(client, 'arm::base')
    assert place_of(client, 'left::mount') is not None


def test_what_is_not_understood_is_logged_once_and_said_by_the_service(client, node, folder):
    (folder / 'odd.urdf').write_text(
        ARM.replace('<link name="hand">', '<link name="hand"><glue/>')
    )
    text = SCENE.format('odd', folder, 4).replace('arm.urdf', 'odd.urdf')
    answer = accepted(client.call(srv.LoadScene, 'load_scene', text=text))
    assert answer.message == (
        f'{folder}/odd.urdf:2: link[hand].glue: <glue> in <link> is not understood. It is left out'
    )
    client.wait_for(lambda: answer.message in node.output(), 'the warning')
    assert node.output().count(answer.message) == 1


def test_the_link_that_is_the_world_by_its_name_is_not_posed_elsewhere(folder, tmp_path):
    """The parameter world_frame names a link: what hangs on it by TF would stand elsewhere."""
    process = start_node(
        tmp_path / 'log', name='base_is_world', scene_file=folder / 'cell.yaml', world_frame='base'
    )
    client = Client('/base_is_world')
    try:
        assert place_of(client, 'left::base') == (0, 0, 0)
        client.wait_for(lambda: "'left::base' is called as" in process.output(), 'the warning')
    finally:
        client.close()
        assert process.end() == 0, process.output()
