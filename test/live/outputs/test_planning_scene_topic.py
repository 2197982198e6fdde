"""The scene as MoveIt's message: what another scene makes of it, and when it is published."""

from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from live.inputs.test_planning_scene import box
from live.live_scenes import Clock, Topic, live_scene
from live.moveit_messages import (
    attached_object,
    collision_object,
    octomap_of,
    planning_scene,
    pose,
)

from drake_geom_ros.live.inputs.planning_scene import PlanningSceneInput
from drake_geom_ros.live.outputs.planning_scene import PlanningSceneTopic, PlanningSceneTypes
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.attachment import attachment
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensed_maps import Cells

NODE = '/scene_graph'


def new_object(id='', operation=b'\0'):
    return collision_object(id, operation[0], frame='', primitives=[], meshes=[], planes=[])


def new_attached(object=None, link_name='', touch_links=()):
    return attached_object(link_name, object, touch_links)


def new_primitive(type=0, dimensions=()):
    return Plain(type=type, dimensions=list(dimensions))


new_primitive.BOX, new_primitive.SPHERE, new_primitive.CYLINDER = 1, 2, 3
TYPES = PlanningSceneTypes(
    planning_scene,
    new_object,
    new_attached,
    new_primitive,
    lambda vertices, triangles: Plain(vertices=vertices, triangles=triangles),
    lambda vertex_indices: Plain(vertex_indices=vertex_indices),
    lambda coef: Plain(coef=coef),
    pose,
    lambda x, y, z: Plain(x=x, y=y, z=z),
)
ROBOT = '<link name="{}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
SCENE = """
sources: [cell, other]
robots: [{{name: arm, urdf: {urdf}, pose: {{position: [0, 0, 3]}}}}]
frames:
- {{name: cart, source: cell, pose: {{position: [1, 2, 0.5], rpy: [0, 0.5, 0.3]}}}}
- {{name: rack, source: cell, parent: cart, pose: {{position: [0, 0, 1]}}}}
- {{name: cart, source: other, pose: {{position: [0, -2, 0]}}}}
- {{name: tool, source: other, pose: {{position: [0, 0, 3.5]}}}}
geometries:
- {{name: load, source: cell, frame: cart, shape: {{type: box, size: [1, 0.5, 0.25]}},
    pose: {{position: [0, 0, 1]}}}}
- {{name: wheel, source: cell, frame: cart, shape: {{type: cylinder, radius: 0.2, length: 0.6}}}}
- {{name: pill, source: other, frame: cart, shape: {{type: capsule, radius: 0.3, length: 0.8}}}}
- {{name: ball, source: cell, shape: {{type: sphere, radius: 0.3}}, pose: {{position: [4, 0, 0]}}}}
- {{name: floor, source: cell, shape: {{type: half_space}}, pose: {{position: [0, 0, -1]}}}}
- {{name: tool, source: other, frame: tool, shape: {{type: sphere, radius: 0.2}}}}
"""


@pytest.fixture
def live(tmp_path):
    joint = (
        '<joint name="j" type="fixed"><parent link="base"/><child link="hand"/>'
        '<origin xyz="0 0 1"/></joint>'
    )
    text = f'<robot name="arm">{ROBOT.format("base")}{ROBOT.format("hand")}{joint}</robot>'
    (tmp_path / 'arm.urdf').write_text(text)
    return live_scene(SCENE.format(urdf=tmp_path / 'arm.urdf'), Clock())


@pytest.fixture
def robot(tmp_path, live):
    """Return the scene of MoveIt: the robot alone, with what takes messages there."""
    text = f'robots: [{{name: arm, urdf: {tmp_path}/arm.urdf, pose: {{position: [0, 0, 3]}}}}]\n'
    other = live_scene(text, Clock())
    return other, PlanningSceneInput(other)


def topic_of(live, taken=(), listeners=1):
    publisher, told = Topic(listeners), []
    did = []
    parts = live, publisher, TYPES, NODE, lambda: set(taken)
    return PlanningSceneTopic(*parts, lambda *m: did.append(m), told.append), publisher, told


def depths(live, points):
    """Return the signed distance of points to the nearest body."""
    with live.reading() as scene:
        found = scene.query.ComputeSignedDistanceToPoint(points)
    least = np.full(len(points), np.inf)
    np.minimum.at(least, found.point_index, found.distance)
    return least


POINTS = np.random.default_rng(3).uniform([-3, -4, -2], [5, 4, 5], size=(2000, 3))


def test_another_scene_with_the_robot_has_the_same_bodies(live, robot):
    other, moveit = robot
    topic, publisher, told = topic_of(live)
    topic.publish()
    (message,) = publisher.published
    assert message.is_diff
    assert message.robot_state.is_diff
    assert not told
    moveit.take_scene(message)
    np.testing.assert_allclose(depths(other, POINTS), depths(live, POINTS), rtol=0, atol=1e-9)
    with other.reading() as scene:
        frames = set(scene.model.names.frame_names.values())
    named = {'cell::cart', 'other::cart', 'ball', 'floor', 'tool', 'cell::cart/rack'}
    assert {name.removeprefix('planning_scene::') for name in frames} - {'world'} >= named


def test_it_is_published_when_somebody_listens_and_something_changed(live):
    topic, publisher, _ = topic_of(live, listeners=0)
    topic.publish()
    assert publisher.published == []
    publisher.listeners = 1
    topic.publish()
    topic.publish()
    assert len(publisher.published) == 1
    with live.editing() as scene:
        scene.poses.put({('cell', 'cart'): RigidTransform([1.0, 2.0, 3.0])})
    topic.publish()
    topic.publish()
    assert len(publisher.published) == 2
    publisher.listeners = 0
    topic.publish()
    publisher.listeners = 1
    topic.publish()
    assert len(publisher.published) == 3, 'whoever comes gets it as it is then'


def test_what_is_attached_detached_and_removed_is_so_in_the_other_scene(live, robot):
    other, moveit = robot
    topic, publisher, _ = topic_of(live)
    topic.publish()
    moveit.take_scene(publisher.published[-1])

    def same():
        topic.publish()
        moveit.take_scene(publisher.published[-1])
        np.testing.assert_allclose(depths(other, POINTS), depths(live, POINTS), rtol=0, atol=1e-9)
        with other.reading() as scene:
            names, inspector = scene.model.names, scene.model.inspector
            return {
                name.removeprefix('planning_scene::'): inspector.IsAttached(frame)
                for frame, name in names.frame_names.items()
                if name.startswith('planning_scene::')
            }

    with live.editing() as scene:
        names = scene.model.names
        frame, link = names.frame('other::tool'), names.frame('arm::hand')
        touching = scene.model.inspector.GetGeometries(names.frame('arm::base'))
        X_LF = RigidTransform([0.3, 0.0, 0.0])
        change = attachment(scene, frame, link, X_LF, touching=touching)
    live.change(change)
    held = same()
    assert held['tool']
    assert not held['ball']
    (tool,) = publisher.published[-1].robot_state.attached_collision_objects
    assert (tool.link_name, tool.touch_links) == ('hand', ['hand', 'base'])
    with live.editing() as scene:
        source = scene.model.names.source('cell')
    live.change(removal(source))
    assert set(same()) == {'cart', 'tool'}


def removal(source):
    def on(graph, context):
        return graph.RemoveSource(context=context, source_id=source)

    def then(scene, frames):
        scene.forget_source('cell', frames)

    return Change(on, then=then, gone=['cell'])


def test_objects_of_moveit_are_left_to_it_and_ours_do_not_come_back(live):
    moveit = PlanningSceneInput(live, node=NODE)
    moveit.take_object(box('mug', 9.0))
    topic, publisher, _ = topic_of(live, moveit.taken)
    topic.publish()
    message = publisher.published[-1]
    ids = {each.id for each in message.world.collision_objects}
    assert 'mug' not in ids
    assert 'ball' in ids
    with live.reading() as scene:
        version = scene.model.version
    moveit.take_scene(message)
    for each in message.world.collision_objects:
        assert moveit.take_object(each) == ''
    with live.reading() as scene:
        assert scene.model.version == version
    PlanningSceneInput(live, node='/another').take_object(message.world.collision_objects[0])
    with live.reading() as scene:
        assert scene.model.version > version


def test_what_moveit_has_no_type_for_is_reported(live):
    moveit = PlanningSceneInput(live)
    cells = Cells.of_points([[1.0, 1.0, 1.0]], 0.5)
    moveit.take_scene(planning_scene(octomap=octomap_of(cells)))
    topic, publisher, told = topic_of(live)
    topic.publish()
    assert 'obstacles::planning_scene' in told[0]
    topic.publish()
    assert len(told) == 1
    assert len(publisher.published) == 1


@settings(max_examples=15, deadline=None)
@given(
    axes=st.tuples(*[st.floats(0.05, 1.0)] * 3),
    seed=st.integers(0, 10**6),
)
def test_an_ellipsoid_is_within_the_polyhedron_around_it(axes, seed):
    live = live_scene(
        f'geometries:\n- {{name: egg, shape: {{type: ellipsoid, semi_axes: {list(axes)}}}}}\n',
        Clock(),
    )
    topic, publisher, told = topic_of(live)
    topic.publish()
    other = live_scene('sources: [cell]\n', Clock())
    PlanningSceneInput(other).take_scene(publisher.published[0])
    points = np.random.default_rng(seed).normal(size=(500, 3))
    points *= np.array(axes) / np.linalg.norm(points, axis=1, keepdims=True)
    assert (depths(other, points) <= 1e-12).all()
    assert (depths(other, 1.02 * points) > -0.02 * max(axes)).all()
    assert not told
