"""MoveIt's objects on their topics, where there are messages of them, and what is said without."""

import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg
from geometry_msgs.msg import Point, Pose
from ros.harness import LATCHED, run_python, start_node
from ros.scene_calls import place_of

pytestmark = pytest.mark.topics

SCENE = """
sources: [arm]
frames: [{name: hand, source: arm, pose: {position: [0, 0, 1]}, static: true}]
geometries:
- {name: hand, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
"""


def test_the_parameter_without_the_messages_is_refused_at_the_start():
    code = (
        'import importlib.util as u, sys; find = u.find_spec; '
        "u.find_spec = lambda name, *a: None if name == 'moveit_msgs' else find(name, *a); "
        'from drake_geom_ros.ros.scene_graph_node import main; '
        "sys.exit(main(['--ros-args', '-p', 'use_planning_scene:=true']))"
    )
    done = run_python('-c', code)
    assert done.returncode == 2
    assert 'moveit_msgs' in done.stderr


@pytest.fixture(scope='module')
def moveit():
    """Return the messages of MoveIt and of its shapes."""
    reason = '`./run test` builds it where it is missing'
    messages = pytest.importorskip('moveit_msgs.msg', reason=reason)
    return messages, pytest.importorskip('shape_msgs.msg', reason=reason)


@pytest.fixture
def node(tmp_path, moveit):
    (tmp_path / 'scene.yaml').write_text(SCENE)
    process = start_node(
        tmp_path / 'log', scene_file=tmp_path / 'scene.yaml', use_planning_scene=True,
        max_distance=10.0,
    )  # fmt: skip
    yield process
    assert process.end() == 0, process.output()


def at(x):
    return Pose(position=Point(x=float(x)))


def test_objects_come_are_attached_and_go(node, lone_client, moveit):
    client, (messages, shapes) = lone_client, moveit
    scenes = client.listen(msg.Scene, 'scene', LATCHED)
    results = client.listen(msg.SignedDistancePairs, 'signed_distances')
    troubles = client.listen(DiagnosticArray, '/diagnostics')
    objects = client.node.create_publisher(messages.CollisionObject, '/collision_object', 10)
    attached = client.node.create_publisher(
        messages.AttachedCollisionObject, '/attached_collision_object', 10
    )
    for publisher in (objects, attached):
        client.wait_for(publisher.get_subscription_count, 'the node to listen')

    def message(operation, x=0.0):
        given = messages.CollisionObject(id='ball', operation=operation, pose=at(x))
        given.header.frame_id = 'hand'
        return given

    def frames():
        return {frame.name for frame in scenes[-1].frames} if scenes else set()

    add = message(messages.CollisionObject.ADD, 2.0)
    add.primitives = [shapes.SolidPrimitive(type=shapes.SolidPrimitive.SPHERE, dimensions=[0.5])]
    add.primitive_poses = [at(0.0)]
    objects.publish(add)
    client.wait_for(lambda: 'ball' in str(frames()), 'the ball')
    assert place_of(client, 'ball')[:3] == pytest.approx([2.0, 0.0, 1.0])

    def measured():
        objects.publish(message(messages.CollisionObject.MOVE, 2.0))  # a cycle, without poses
        client.spin_until(time.monotonic() + 0.05)
        return results and len(results[-1].distance)

    client.wait_for(measured, 'a distance to the ball')
    assert list(results[-1].distance) == pytest.approx([1.4])

    bare = message(messages.CollisionObject.ADD)
    attached.publish(messages.AttachedCollisionObject(link_name='hand', object=bare))
    client.wait_for(lambda: results and not len(results[-1].distance), 'hand and ball to touch')

    valid = pytest.importorskip('moveit_msgs.srv').GetStateValidity
    assert client.call(valid, 'check_state_validity').valid
    typo = messages.RobotState()
    typo.joint_state.name, typo.joint_state.position = ['elbow'], [0.0]
    assert not client.call(valid, 'check_state_validity', robot_state=typo).valid
    assert "no joint 'elbow'" in node.output()

    wrong = message(messages.CollisionObject.MOVE)
    objects.publish(wrong)

    def refusal():
        values = [v for each in troubles for s in each.status for v in s.values]
        return [v.value for v in values if 'collision_object' in v.key + v.value]

    client.wait_for(refusal, 'a refusal in /diagnostics')
    assert "object 'ball': it is attached to 'arm::hand'" in node.output()

    remove = message(messages.CollisionObject.REMOVE)
    attached.publish(messages.AttachedCollisionObject(object=remove))
    client.wait_for(lambda: len(results[-1].distance), 'the ball in the world again')
    objects.publish(remove)
    client.wait_for(lambda: 'ball' not in str(frames()), 'no ball')


@pytest.fixture
def services(moveit):
    """Return the services of MoveIt."""
    return pytest.importorskip('moveit_msgs.srv')


def test_moveit_is_asked_at_the_start_and_its_scene_is_monitored(
    tmp_path, lone_client, moveit, services
):
    client, (messages, shapes) = lone_client, moveit
    asked = []

    def sphere(name, x, radius=0.5):
        kind = shapes.SolidPrimitive.SPHERE
        given = messages.CollisionObject(id=name, pose=at(x))
        given.header.frame_id = 'world'
        given.primitives = [shapes.SolidPrimitive(type=kind, dimensions=[radius])]
        given.primitive_poses = [at(0.0)]
        return given

    def answer(request, response):
        asked.append(request.components.components)
        response.scene.world.collision_objects = [sphere('shelf', 3.0)]
        return response

    service = client.node.create_service(services.GetPlanningScene, '/get_planning_scene', answer)
    (tmp_path / 'scene.yaml').write_text(SCENE)
    node = start_node(
        tmp_path / 'log', scene_file=tmp_path / 'scene.yaml', use_planning_scene=True
    )
    try:
        scenes = client.listen(msg.Scene, 'scene', LATCHED)
        shown = client.listen(messages.PlanningScene, 'planning_scene', LATCHED)
        monitored = client.node.create_publisher(
            messages.PlanningScene, '/monitored_planning_scene', 10
        )

        def frames():
            return {frame.name for frame in scenes[-1].frames} if scenes else set()

        client.wait_for(lambda: 'shelf' in frames(), 'the object that MoveIt answered')
        assert len(asked) == 1
        assert asked[0] & messages.PlanningSceneComponents.OCTOMAP
        client.wait_for(monitored.get_subscription_count, 'the node to listen')
        diff = messages.PlanningScene(is_diff=True)
        diff.world.collision_objects = [sphere('mug', -3.0)]
        monitored.publish(diff)
        client.wait_for(lambda: 'mug' in frames(), 'the monitored object')
        assert 'shelf' in frames()
        client.wait_for(lambda: len(shown), 'the scene as MoveIt has it')
        (hand,) = shown[-1].world.collision_objects
        assert (hand.id, shown[-1].is_diff) == ('hand', True)
        assert list(hand.primitives[0].dimensions) == [0.1]
        assert hand.pose.position.z == 1.0
    finally:
        client.node.destroy_service(service)
        assert node.end() == 0, node.output()
