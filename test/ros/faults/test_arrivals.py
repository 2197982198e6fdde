"""Nothing that arrives holds cycles up: nothing is done for each geometry under the lock.

Milliseconds depend on the load of the machine, and are measured by ``bench.ros.arrivals``. How
often each function is called while the scene is held, when no cycle can run, does not: see
``counting_node``. The scene has a rule and thousands of geometries. So what is made for each of
them there (names, filters, pairs of rules, a copy of the scene, a description) calls some function
as often; nothing else does. A topic or a service without an entry fails the test.
"""

import array
import os
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Duration, Time
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Point, Pose, TransformStamped
from ros.harness import LATCHED, Process
from ros.scene_calls import accepted, exclude, place_of, poses
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2, PointField
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from drake_geom_ros.ros import topics
from drake_geom_ros.ros.services.table import SERVICES

pytestmark = [pytest.mark.topics, pytest.mark.timeout(900)]

COUNT = 1500
BODIES = [f'much::world/much{k}' for k in range(COUNT)]
SENSED = (
    '~/obstacles/points',
    '~/obstacles/depth/camera_info',
    '~/obstacles/depth/image_rect_raw',
)
ARM = """<robot name="{name}"><link name="l0"/>
<link name="l1"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="l2"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="j1" type="revolute"><parent link="l0"/><child link="l1"/><origin xyz="0 0 0.2"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0 0 0.2"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
SOFT = """roles: {proximity: {hydroelastic: {compliance_type: compliant,
   hydroelastic_modulus: 1.0e6, resolution_hint: 0.05}}}"""
SCENE = """
sources: [arm, mover, much]
robots:
- {name: arm, urdf: arm.urdf, pose: {position: [-5, 0, 0]}, configuration: {j1: 0, j2: 0}}
frames:
- {name: hand, source: mover, pose: {}}
- {name: part, source: mover, pose: {position: [0, -3, 0]}}
geometries:
- {name: ball, source: mover, frame: hand, shape: {type: sphere, radius: 0.1}, SOFT}
- {name: box, source: mover, frame: part, shape: {type: box, size: [0.1, 0.1, 0.1]}, SOFT}
""".replace('SOFT', SOFT)
RULE = """proximity_rules:
- {name: near, set_a: mover, level: stop, enter: 0.05, leave: 0.1}
"""
BALL = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.05])


def bodies(source, height=0.0, count=COUNT):
    """Return the lines of a scene file about bodies that stand in the world."""
    return ''.join(
        f'- {{name: {source}{k}, source: {source}, shape: {{type: sphere, radius: 0.05}}, '
        f'pose: {{position: [{3.0 + k % 50}, {k // 50}, {height}]}}}}\n'
        for k in range(count)
    )


@pytest.fixture(scope='module')
def node(tmp_path_factory):
    pytest.importorskip('octomap_msgs')
    pytest.importorskip('moveit_msgs')
    folder = tmp_path_factory.mktemp('arrivals')
    (folder / 'arm.urdf').write_text(ARM.format(name='arm'))
    (folder / 'scene.yaml').write_text(SCENE + bodies('much') + RULE)
    parameters = {
        'scene_file': folder / 'scene.yaml',
        'max_distance': 0.3,
        'use_tf': 'true',
        'use_joint_states': 'true',
        'closing_speeds': 'true',
        'obstacles': '[octomap, points, depth]',
        'obstacle_self_filter': 'none',
        'use_planning_scene': 'true',
    }
    arguments = ['--ros-args', '-r', '__ns:=/counted']
    for name, value in parameters.items():
        arguments += ['-p', f'{name}:={value}']
    with pytest.MonkeyPatch.context() as patch:
        paths = [str(Path(__file__).parent), os.environ.get('PYTHONPATH', '')]
        patch.setenv('PYTHONPATH', os.pathsep.join(paths))
        patch.setenv('MOST_CALLS_UNDER_THE_LOCK', str(COUNT))
        process = Process(folder / 'log', 'counting_node', *arguments)
    process.folder = folder
    yield process
    assert process.end() == 0, process.output()


class Site:
    """A client of the node, with what the arrivals have made so far."""

    def __init__(self, client, folder):
        client.server = '/counted/scene_graph'
        self.client, self.folder = client, folder
        self.sway = 0.001  # [m]
        self.results = client.listen(msg.SignedDistancePairs, 'signed_distances')
        self.reports = client.listen(msg.CycleReport, 'cycle_report')
        self.publishers = {}

    def call(self, name, /, **fields):
        kind = next(kind for each, kind, _ in SERVICES if each == name)
        return accepted(self.client.call(kind, name, **fields))

    def until(self, send, fact, what):
        """Send until something is a fact: by best effort a message may be lost."""

        def came():
            send()
            return fact()

        return self.client.wait_for(came, what)

    def publisher(self, kind, topic, qos=10):
        key = kind, topic
        if key not in self.publishers:
            name = topic.replace('~', self.client.server)
            self.publishers[key] = self.client.node.create_publisher(kind, name, qos)
        return self.publishers[key]

    def header(self):
        return Header(stamp=self.client.node.get_clock().now().to_msg(), frame_id='world')

    def cells(self, name):
        """Return the number of cells of a map, as the last report says."""
        last = self.reports[-1] if self.reports else msg.CycleReport()
        return dict(zip(last.maps, last.map_cells, strict=True)).get(name, 0)

    def cycle(self):
        """Pose the hand, and wait for a cycle of that pose or of a later one."""
        stamp = self.header().stamp
        self.sway = -self.sway
        message = poses(['mover::hand'], [(self.sway, 0, 0)])
        message.header.stamp = stamp
        publisher = self.publisher(msg.FramePoses, '~/frame_poses')

        def came():
            last = self.results[-1].header.stamp if self.results else Time()
            return (last.sec, last.nanosec) >= (stamp.sec, stamp.nanosec)

        self.until(lambda: publisher.publish(message), came, 'a cycle')
        del self.results[:-1]


def twists(site):
    twist = msg.FrameTwists(frame_names=['mover::hand'], twists=[0.0] * 6)
    twist.header.stamp = site.header().stamp
    site.publisher(msg.FrameTwists, '~/frame_twists').publish(twist)
    site.cycle()


def cloud(site, points):
    rows = np.array(points, dtype='<f4')
    fields = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in enumerate('xyz')]
    return PointCloud2(
        header=site.header(), width=len(rows), height=1, point_step=12,
        row_step=12 * len(rows), fields=fields, data=array.array('B', rows.tobytes()),
    )  # fmt: skip


def query_points(site):
    answers = site.client.listen(msg.PointDistances, 'point_distances')
    publisher = site.publisher(PointCloud2, '~/query_points')
    site.until(lambda: publisher.publish(cloud(site, [[0, 0, 0]])), lambda: answers, 'distances')


def robot(site):
    # With a joint of another name: it would be taken for the arm of the scene else.
    text = String(data=ARM.format(name='guest').replace('"j1"', '"h1"'))
    publisher = site.publisher(String, '/counted/robot_description', LATCHED)
    publisher.publish(text)
    site.client.wait_for(lambda: has_joint(site, 'guest::h1'), 'the robot')
    other = text.data.replace('"h1"', '"k1"')
    publisher.publish(String(data=other))
    site.client.wait_for(lambda: has_joint(site, 'guest::k1'), 'another robot in its place')


def has_joint(site, name):
    answer = site.client.call(srv.GetJointPositions, 'get_joint_positions', names=[name])
    return answer.success


def semantics(site):
    pair = '<disable_collisions link1="l1" link2="l2" reason="Never"/>'
    text = String(data=f'<robot name="guest">{pair}</robot>')
    site.publisher(String, '/counted/robot_description_semantic', LATCHED).publish(text)
    names = {'geometry_a': 'guest::l1/collision_0', 'geometry_b': 'guest::l2/collision_0'}
    site.client.wait_for(lambda: site.call('explain_filter', **names).reasons, 'the SRDF')
    site.call('remove_source', source='guest')  # whose links would wait for poses


def joint_states(site):
    publisher = site.publisher(JointState, '/counted/joint_states')
    state = JointState(name=['arm::j1', 'arm::j2'], position=[0.25, 0.5])

    def send():
        state.header.stamp = site.header().stamp
        publisher.publish(state)

    def came():
        return site.call('get_joint_positions', names=['arm::j1']).positions[0] == 0.25

    site.until(send, came, 'joint values')


def transform(site, topic, qos):
    from tf2_msgs.msg import TFMessage

    entry = TransformStamped(header=site.header(), child_frame_id='part')
    entry.transform.translation.x = float(len(topic))
    entry.transform.rotation.w = 1.0
    publisher = site.publisher(TFMessage, topic, qos)

    def came():
        return place_of(site.client, 'mover::part')[0] == len(topic)

    site.until(lambda: publisher.publish(TFMessage(transforms=[entry])), came, topic)


def octomap(site):
    from octomap_msgs.msg import Octomap

    from drake_geom_ros.sensed_maps.cells import Cells
    from drake_geom_ros.sensed_maps.octree import binary_of_cells

    tree = binary_of_cells(Cells.of_points([[1.0, 0.05, 0.05], [1.0, 0.5, 0.05]], 0.1)).data
    publisher = site.publisher(Octomap, '~/obstacles/octomap')

    def send():
        publisher.publish(
            Octomap(
                header=site.header(), binary=True, id='OcTree', resolution=0.1,
                data=array.array('b', tree),
            )
        )  # fmt: skip
        site.cycle()

    site.until(send, lambda: site.cells('octomap'), 'the map of an OctoMap')


def points(site):
    publisher = site.publisher(PointCloud2, '~/obstacles/points')
    rows = np.random.default_rng(0).uniform([1, 0, 0], [1.1, 0.3, 0.1], (5000, 3))

    def send():
        publisher.publish(cloud(site, rows))
        site.cycle()

    site.until(send, lambda: site.cells('points'), 'the map of a cloud')


def depth(site):
    width, height = 40, 30
    depths = np.full((height, width), 1.5, dtype='<f4')
    info = CameraInfo(width=width, height=height)
    info.k = [30.0, 0.0, 20.0, 0.0, 30.0, 15.0, 0.0, 0.0, 1.0]
    info.p = [30.0, 0.0, 20.0, 0.0, 0.0, 30.0, 15.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    infos, images = (
        site.publisher(kind, topic)
        for kind, topic in zip((CameraInfo, Image), SENSED[1:], strict=True)
    )

    def send():
        info.header = site.header()
        image = Image(
            header=info.header, width=width, height=height, encoding='32FC1',
            step=4 * width, data=array.array('B', depths.tobytes()),
        )  # fmt: skip
        infos.publish(info)
        images.publish(image)
        site.cycle()

    site.until(send, lambda: site.cells('depth'), 'the map of a depth image')


def tracked(site):
    site.cycle()
    message = msg.TrackedObjects(
        names=['person'], shapes=[BALL], poses=[-9.0, 0, 0, 0, 0, 0, 1.0], lifetimes=[0.5]
    )
    publisher = site.publisher(msg.TrackedObjects, '~/tracked_objects')

    def send():
        message.header = site.header()
        publisher.publish(message)

    def came():
        return site.client.call(srv.GetPose, 'get_pose', frame='tracked::person').success

    site.until(send, came, 'a tracked body')


def planning_object(name, x):
    """Return a ball of MoveIt's, somewhere far away."""
    from moveit_msgs.msg import CollisionObject
    from shape_msgs.msg import SolidPrimitive

    ball = CollisionObject(id=name, operation=CollisionObject.ADD)
    ball.primitives = [SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.05])]
    ball.primitive_poses = [Pose(position=Point(x=x, y=-30.0))]
    ball.header.frame_id = 'world'
    return ball


def has_frame(site, name):
    return site.client.call(srv.GetPose, 'get_pose', frame=name).success


def collision_object(site):
    ball = planning_object('thing', -30.0)
    publisher = site.publisher(type(ball), '/collision_object')
    came = partial(has_frame, site, 'planning_scene::thing')
    site.until(lambda: publisher.publish(ball), came, 'an object')


def attached_collision_object(site):
    """Attach the object, and take it back with the filter of what it may touch."""
    from moveit_msgs.msg import AttachedCollisionObject, CollisionObject

    message = AttachedCollisionObject(link_name='arm::l2')
    message.object.id, message.object.operation = 'thing', CollisionObject.ADD
    publisher = site.publisher(AttachedCollisionObject, '/attached_collision_object')

    def is_attached(wanted):
        return bool(site.call('get_filters').active_filter_ids) == wanted

    site.until(lambda: publisher.publish(message), lambda: is_attached(True), 'an attachment')
    message.object.operation = CollisionObject.REMOVE
    site.until(lambda: publisher.publish(message), lambda: is_attached(False), 'its end')


def planning_scene(site, topic='/planning_scene'):
    """Take a scene, and remove all objects."""
    from moveit_msgs.msg import CollisionObject, PlanningScene

    message = PlanningScene(is_diff=True)
    message.robot_state.is_diff = True
    message.world.collision_objects = [planning_object('other', -31.0)]
    publisher = site.publisher(PlanningScene, topic)
    came = partial(has_frame, site, 'planning_scene::other')
    site.until(lambda: publisher.publish(message), came, 'a planning scene')
    everything = CollisionObject(operation=CollisionObject.REMOVE)
    remove = site.publisher(CollisionObject, '/collision_object')
    site.until(lambda: remove.publish(everything), lambda: not came(), 'an empty world')


TOPICS = {
    '~/frame_poses': Site.cycle,
    '~/frame_twists': twists,
    '~/query_points': query_points,
    '{robot_description_topic}': robot,
    '{robot_description_semantic_topic}': semantics,
    'joint_states': joint_states,
    '~/tracked_objects': tracked,
    '/collision_object': collision_object,
    '/attached_collision_object': attached_collision_object,
    '/planning_scene': planning_scene,
    '/monitored_planning_scene': partial(planning_scene, topic='/monitored_planning_scene'),
    '/tf': lambda site: transform(site, '/tf', 10),
    '/tf_static': lambda site: transform(site, '/tf_static', LATCHED),
    '~/obstacles/octomap': octomap,
    SENSED[0]: points,
    SENSED[1]: depth,
    SENSED[2]: depth,
}


def declaration():
    return {'declaration': exclude(*BODIES)}


def load_scene(site):
    site.call('load_scene', text='sources: [more]\ngeometries:\n' + bodies('more', 2.0))
    text = 'sources: [more]\ngeometries:\n' + bodies('more', 3.0)
    site.call('load_scene', text=text, replaced_sources=['more'])


def register_geometries(site):
    geometry = msg.NewGeometry(frame='world', name='g1', shape=BALL, roles=[msg.Role(role=1)])
    site.call('register_geometries', source='new', geometries=[geometry])


def register_geometry(site):
    site.call(
        'register_geometry', source='new', frame='world', name='g0', shape=BALL,
        roles=[msg.Role(role=1)],
    )  # fmt: skip


def transient(site):
    answer = site.call('apply_transient_filter', lease=600.0, **declaration())
    site.filter_id = answer.filter_id


def add_rule(site):
    rule = msg.ProximityRule(
        name='more', set_a=['much'], set_b=['mover'], level=3, enter=100.0, leave=101.0
    )
    rule.acknowledge = True
    site.call('add_proximity_rule', rule=rule)


def acknowledge_rule(site):
    """Acknowledge the rule that was added, once it is entered."""

    def is_acknowledged():
        states = site.call('list_proximity_rules').states
        event = states.entered_sequence[states.rules.name.index('more')]
        fields = {'name': 'more', 'sequence': event}
        return site.client.call(srv.AcknowledgeRule, 'acknowledge_rule', **fields).success

    site.until(site.cycle, is_acknowledged, 'the rule to be acknowledged')


def check_motion(site):
    rows = [JointTrajectoryPoint(positions=[value, 0.0]) for value in (0.0, 0.2)]
    path = JointTrajectory(joint_names=['arm::j1', 'arm::j2'], points=rows)
    site.call('check_motion', path=path)


def watch_trajectory(site):
    """Watch a trajectory that the changes of the others have judged again."""
    points = [
        JointTrajectoryPoint(positions=[value, 0.0], time_from_start=Duration(sec=seconds))
        for value, seconds in ((0.0, 0), (0.2, 3600))
    ]
    path = JointTrajectory(joint_names=['arm::j1', 'arm::j2'], points=points)
    site.call('watch_trajectory', name='way', path=path)


def states(site):
    names = ['arm::j1', 'arm::j2']
    site.call('evaluate_states', joint_names=names, positions=[0.0] * 200, want='collision')


def add_obstacle_source(site):
    settings = '{type: laser_scan, topic: /counted/scan, required: false}'
    site.call('add_obstacle_source', name='front', settings=settings)


def camera():
    return msg.Camera(name='eye', frame='mover::hand', width=8, height=8, fov_y=1.0)


def pair():
    return {'geometry_a': 'mover::hand/ball', 'geometry_b': BODIES[0]}


# In this order: queries of states need all frames posed, and later changes take back earlier ones.
CALLS = {
    'compute_point_pair_penetration': lambda site: site.call('compute_point_pair_penetration'),
    'compute_signed_distance_pairwise': lambda site: site.call(
        'compute_signed_distance_pairwise', max_distance=0.1
    ),
    'compute_signed_distance_pair': lambda site: site.call(
        'compute_signed_distance_pair', **pair()
    ),
    'compute_signed_distance_to_point': lambda site: site.call(
        'compute_signed_distance_to_point', points=[0.0, 0.0, 0.0], threshold=1.0
    ),
    'find_collision_candidates': lambda site: site.call('find_collision_candidates'),
    'has_collisions': lambda site: site.call('has_collisions'),
    'get_pose': lambda site: site.call('get_pose', frame='mover::hand'),
    'get_pose_ages': lambda site: site.call('get_pose_ages'),
    'get_joint_positions': lambda site: site.call('get_joint_positions'),
    'evaluate_states': states,
    'compute_contact_surfaces': lambda site: site.call(
        'compute_contact_surfaces', with_fallback=True
    ),
    'check_motion': check_motion,
    'watch_trajectory': watch_trajectory,
    'register_source': lambda site: site.call('register_source', name='new'),
    'register_frame': lambda site: site.call('register_frame', source='new', name='f'),
    'register_geometry': register_geometry,
    'register_geometries': register_geometries,
    'assign_role': lambda site: site.call(
        'assign_role', geometry='new::world/g0', role=msg.Role(role=2)
    ),
    'change_shape': lambda site: site.call(
        'change_shape', geometry='new::world/g0', shape=msg.Shape(type=1, dimensions=[0.1])
    ),
    'remove_role': lambda site: site.call('remove_role', geometry='new::world/g0', role=2),
    'remove_geometry': lambda site: site.call('remove_geometry', geometry='new::world/g0'),
    'load_scene': load_scene,
    'remove_source': lambda site: site.call('remove_source', source='more'),
    'attach': lambda site: site.call('attach', frame='mover::part', parent='mover::hand'),
    'detach': lambda site: site.call('detach', frame='mover::part'),
    'apply_filter': lambda site: site.call('apply_filter', **declaration()),
    'apply_transient_filter': transient,
    'get_filters': lambda site: site.call('get_filters'),
    'explain_filter': lambda site: site.call('explain_filter', **pair()),
    'renew_filter': lambda site: site.call('renew_filter', filter_id=site.filter_id, lease=600.0),
    'remove_filter': lambda site: site.call('remove_filter', filter_id=site.filter_id),
    'flatten_filters': lambda site: accepted(site.client.call(Trigger, 'flatten_filters')),
    'add_proximity_rule': add_rule,
    'list_proximity_rules': lambda site: site.call('list_proximity_rules'),
    'acknowledge_rule': acknowledge_rule,
    'remove_proximity_rule': lambda site: site.call('remove_proximity_rule', name='more'),
    'add_camera': lambda site: site.call('add_camera', camera=camera()),
    'list_cameras': lambda site: site.call('list_cameras'),
    'render_image': lambda site: site.call('render_image', camera='eye', images=['depth']),
    'remove_camera': lambda site: site.call('remove_camera', name='eye'),
    'save_scene': lambda site: site.call('save_scene'),
    'save_obstacles': lambda site: site.call(
        'save_obstacles', path=str(site.folder / 'seen.bt'), map='octomap'
    ),
    'load_obstacles': lambda site: site.call('load_obstacles', path=str(site.folder / 'seen.bt')),
    'clear_obstacles': lambda site: site.call('clear_obstacles'),
    'add_obstacle_source': add_obstacle_source,
    'list_obstacle_sources': lambda site: site.call('list_obstacle_sources'),
    'remove_obstacle_source': lambda site: site.call('remove_obstacle_source', name='front'),
    'unwatch_trajectory': lambda site: site.call('unwatch_trajectory', name='way'),
}


@pytest.fixture
def site(node, lone_client):
    return Site(lone_client, node.folder)


def test_every_topic_and_every_service_has_an_entry():
    assert set(TOPICS) == {row.topic for row in topics.INPUTS} | set(SENSED)
    assert set(CALLS) == {name for name, _, _ in SERVICES}


def test_no_arrival_does_anything_for_each_geometry_while_it_has_the_scene(node, site):
    site.cycle()
    site.client.wait_for(lambda: 'configured' in node.output(), 'the log of the node')
    found = {}
    for name, send in {**TOPICS, **CALLS}.items():
        node.forget_output()
        send(site)
        site.cycle()  # and the cycle after it finds all made
        if lines := re.findall(r'under the lock, .*', node.output()):
            found[name] = lines
    assert not found, '\n'.join(f'{name}: {line}' for name in found for line in found[name])
