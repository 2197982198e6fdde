"""What fixed joints hold to the link ``world`` counts as anchored, until it is posed elsewhere."""

import pytest
from live.live_scenes import Clock, live_scene

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene, save_scene


def link(name):
    return (
        f'<link name="{name}"><collision><geometry><sphere radius="0.1"/></geometry></collision>'
        '</link>'
    )


def joint(parent, child, kind):
    return (
        f'<joint name="{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        '</joint>'
    )


URDF = (
    '<robot name="arm"><link name="world"/>'
    + ''.join(map(link, ('base', 'plate', 'upper')))
    + joint('world', 'base', 'fixed')
    + joint('base', 'plate', 'fixed')
    + joint('plate', 'upper', 'revolute')
    + '</robot>'
)
FLOOR = 'geometries: [{name: floor, shape: {type: half_space}}]'


@pytest.fixture
def scene_graph():
    scene_graph = SceneGraph()
    load_scene(URDF, scene_graph)
    load_scene(f'{FLOOR}\n', scene_graph)
    return scene_graph


def named(scene_graph):
    inspector = scene_graph.model_inspector()
    return {inspector.GetName(inspector.GetFrameId(g)): g for g in inspector.GetAllGeometryIds()}


def reasons(scene_graph, link, context=None):
    ids = named(scene_graph)
    return scene_graph.collision_filter_manager(context).explain(ids[link], ids['world'])


def pose(scene_graph, context, x):
    inspector = scene_graph.model_inspector()
    frames = {inspector.GetName(f): f for f in inspector.GetAllFrameIds()}
    context.UpdateFramePoses(FramePoseVector({frames['base']: RigidTransform([x, 0, 0])}))


def test_what_is_welded_is_anchored_for_what_comes_later_too(scene_graph):
    assert reasons(scene_graph, 'base') == ['anchored']
    assert reasons(scene_graph, 'plate') == ['anchored']
    assert reasons(scene_graph, 'upper') == []


def test_it_stays_so_where_it_is_saved_and_loaded(scene_graph):
    again = SceneGraph()
    text = save_scene(scene_graph)
    assert text.count('welded: true') == 2
    load_scene(text, again)
    assert reasons(again, 'base') == ['anchored']
    assert save_scene(again) == text


def test_adjacent_links_that_are_kept_are_not_welded(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    scene_graph = SceneGraph()
    robots = f'robots: [{{name: arm, urdf: {tmp_path}/arm.urdf, adjacent_links: kept}}]'
    load_scene(f'{robots}\n{FLOOR}\n', scene_graph)
    assert reasons(scene_graph, 'base') == []


def test_a_pose_elsewhere_ends_the_weld_in_that_context(scene_graph):
    context = scene_graph.CreateDefaultContext()
    pose(scene_graph, context, 3.0)  # the first pose says where it is
    pose(scene_graph, context, 3.0 + 1e-9)
    assert reasons(scene_graph, 'base', context) == ['anchored']
    what_if = context.what_if()
    pose(scene_graph, what_if, 3.1)
    assert reasons(scene_graph, 'base', what_if) == []
    assert reasons(scene_graph, 'plate', what_if) == ['anchored']
    assert reasons(scene_graph, 'base', context) == ['anchored']
    pose(scene_graph, context, 3.0 + 1e-5)
    assert reasons(scene_graph, 'base', context) == []


def test_only_frames_on_the_world_can_be_welded(scene_graph):
    text = 'name: s\nframes: [{name: a}, {name: b, parent: a, welded: true}]'
    with pytest.raises(RuntimeError, match='must be the world'):
        load_scene(text, scene_graph)


def test_by_topic_and_a_node_tells_of_one_that_is_moved():
    live = live_scene(f'{FLOOR}\n', Clock())
    RobotInput(live).take(URDF)
    with live.editing() as scene:
        frame = scene.model.names.frame('arm::base')
        assert reasons(scene.model.scene_graph, 'base') == ['anchored']
        for x in (0.0, 1.0):
            scene.poses.pose(FramePoseVector({frame: RigidTransform([x, 0, 0])}), {}, None, 'TF')
        assert reasons(scene.model.scene_graph, 'base') == []
        _, warning = scene.log.warnings  # the first is about a joint without limits
    assert 'arm::base: welded to the world' in warning


def test_a_later_floor_is_anchored_too(scene_graph):
    floor = GeometryInstance(RigidTransform(), HalfSpace(), 'later')
    floor.set_proximity_properties(ProximityProperties())
    later = scene_graph.RegisterAnchoredGeometry(scene_graph.RegisterSource('s'), floor)
    base = named(scene_graph)['base']
    assert scene_graph.collision_filter_manager().explain(base, later) == ['anchored']
