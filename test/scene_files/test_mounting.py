"""A robot on a frame of another one: it moves along, in scene graphs, batches and motions."""

import numpy as np
import pytest
from live.inputs.test_joint_input import ARM, BALL, JOINTS_OF_ARM

from drake_geom_ros.batch import Checker, Joints, evaluate
from drake_geom_ros.geometry import (
    FrameId,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import SceneFileError, describe, load_scene, read_scene, to_yaml
from drake_geom_ros.trajectories import Kinematics
from drake_geom_ros.trajectories.motion_file import load_motion

SCENE = """
robots:
- {name: tool, urdf: arm.urdf, mounted_on: big::left, pose: {position: [0, 0, 0.2]}, MORE}
- {name: big, urdf: arm.urdf, mounted_on: cart, pose: {position: [0.5, 0, 0]}}
frames:
- {name: cart, source: cell, pose: {position: [1, 2, 3], rpy: [0, 0, 0.7]}}
geometries:
- {name: post, source: cell, shape: {type: sphere, radius: 0.3}, pose: {position: [2, 3, 4]}}
"""
NAMES = [f'{robot}::{joint}' for robot in ('big', 'tool') for joint in JOINTS_OF_ARM]


@pytest.fixture
def path(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    path = tmp_path / 'cell.yaml'
    path.write_text(SCENE.replace(', MORE', ''))
    return path


@pytest.fixture
def states():
    rng = np.random.default_rng(3)
    return rng.uniform([-1, -3, 0, -1, -3, 0], [2, 3, 0.1, 2, 3, 0.1], (40, 6))


@pytest.fixture
def loaded(path):
    scene_graph = SceneGraph()
    return scene_graph, load_scene(path, scene_graph)


def in_world(q, X_WC):
    """Return X_WL by robot and link where forward kinematics alone puts them; C is the cart."""
    kinematics = Kinematics(read_scene(f'{ARM}\n', 'urdf').robots[0].tree)
    big = kinematics.link_transforms(q[:3], (X_WC @ RigidTransform([0.5, 0, 0])).GetAsMatrix4())
    X_WM = big[kinematics.link_names.index('left')] @ RigidTransform([0, 0, 0.2]).GetAsMatrix4()
    tool = kinematics.link_transforms(q[3:], X_WM)
    return {
        (robot, link): X
        for robot, X_WLs in (('big', big), ('tool', tool))
        for link, X in zip(kinematics.link_names, X_WLs, strict=True)
    }


def test_links_move_with_what_carries_their_robot(loaded, states):
    scene_graph, scene = loaded
    joints = Joints.of(scene, NAMES)
    context = scene_graph.CreateDefaultContext()
    query = scene_graph.get_query_output_port()
    cart = scene.frames['cell', 'cart']
    for q, poses in zip(states, joints.poses(states), strict=True):
        context.UpdateFramePoses(FramePoseVector.FromArrays(joints.frame_ids, poses))
        X_WC = RigidTransform([*q[:3]])
        context.UpdateFramePoses(FramePoseVector({cart: X_WC}))
        for frame, X_WL in in_world(q, X_WC).items():
            found = query.Eval(context).X_WF(scene.frames[frame])
            np.testing.assert_allclose(found.GetAsMatrix4(), X_WL, rtol=0, atol=1e-13)


def test_batches_answer_as_contexts_do_to_the_bit(loaded, states):
    scene_graph, scene = loaded
    joints = Joints.of(scene, NAMES)
    found = evaluate(scene_graph, states=states, joints=joints, want='least')
    collides = evaluate(scene_graph, states=states, joints=joints, want='collision')
    checker = Checker(scene_graph, joints)
    for k, poses in enumerate(joints.poses(states)):
        context = scene_graph.CreateDefaultContext()
        context.UpdateFramePoses(FramePoseVector.FromArrays(joints.frame_ids, poses))
        query = scene_graph.get_query_output_port().Eval(context)
        pairs = query.ComputeSignedDistancePairwiseClosestPoints()
        assert found.distance[k] == pairs.distance.min()
        assert collides[k] == query.HasCollisions()
        assert checker.free(states[k]) == (not collides[k])


def test_gradients_by_joints_reach_through_the_mount(loaded, states):
    scene_graph, scene = loaded
    joints, step = Joints.of(scene, NAMES), 1e-6
    asked = {'joints': joints, 'want': 'within', 'max_distance': 3.0}
    found = evaluate(scene_graph, states=states[:8], by_joints=True, **asked)
    between = 0
    for k, q in enumerate(states[:8]):
        rows = slice(found.offsets[k], found.offsets[k + 1])
        pairs = dict(
            zip(
                zip(found.id_A[rows], found.id_B[rows], strict=True),
                found.joint_gradient[rows],
                strict=True,
            )
        )
        for joint in range(6):
            ends = np.array([q, q])
            ends[:, joint] += [-step, step]
            sides = evaluate(scene_graph, states=ends, **asked)
            low, high = (
                {
                    (sides.id_A[i], sides.id_B[i]): sides.distance[i]
                    for i in range(sides.offsets[s], sides.offsets[s + 1])
                }
                for s in (0, 1)
            )
            for pair in pairs.keys() & low.keys() & high.keys():
                slope = (high[pair] - low[pair]) / (2.0 * step)
                assert abs(slope - pairs[pair][joint]) < 1e-6
                between += joint < 3 and abs(slope) > 0.1
    assert between > 100


def test_what_is_fixed_to_both_sides_of_a_mount_does_not_collide(path, loaded):
    scene_graph, scene = loaded
    manager = scene_graph.collision_filter_manager()
    geometries = scene.geometries
    base, left = (
        geometries['tool', 'base', 'collision_0'],
        geometries['big', 'left', 'collision_0'],
    )
    assert 'clique tool: mounted on big::left' in manager.explain(base, left)
    assert not manager.explain(geometries['tool', 'upper', 'collision_0'], left)
    path.write_text(SCENE.replace('MORE', 'adjacent_links: kept'))
    other = SceneGraph()
    geometries = load_scene(path, other).geometries
    manager = other.collision_filter_manager()
    pair = geometries['tool', 'base', 'collision_0'], geometries['big', 'left', 'collision_0']
    assert not manager.explain(*pair)


def test_a_saved_scene_is_mounted_as_before(loaded):
    scene_graph, scene = loaded
    text = to_yaml(describe(scene_graph, scene.X_PFs, scene.robots.values(), scene.static))
    again = SceneGraph()
    reloaded = load_scene(text, again)
    assert reloaded.robots['tool'].mounted_on == scene.robots['tool'].mounted_on
    for frame, id in scene.frames.items():
        inspector, other = scene_graph.model_inspector(), again.model_inspector()
        assert inspector.full_name(inspector.GetParentFrame(id)) == other.full_name(
            other.GetParentFrame(reloaded.frames[frame])
        )
    assert (
        to_yaml(describe(again, reloaded.X_PFs, reloaded.robots.values(), reloaded.static)) == text
    )


def test_a_motion_tells_poses_in_what_carries_a_robot(path):
    motion = load_motion(None, read_scene(path))
    rows = motion.poses(0.0)['tool'][motion.frame_names['tool'].index('base')]
    np.testing.assert_allclose(rows[:3], [0, 0, 0.2], rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        (('big::left', 'big::lift'), "robots[0].mounted_on: 'big::lift' is neither a frame"),
        (('big::left', 'world'), 'must be a frame that is not the world'),
        (('big::left', 'tool::hand'), "'hand' is a frame of the robot itself"),
        (('on: cart', 'on: tool::hand'), 'which cannot follow it'),
    ],
)
def test_what_cannot_carry_a_robot_is_refused(path, change, words):
    path.write_text(SCENE.replace(', MORE', '').replace(*change))
    with pytest.raises(SceneFileError) as told:
        load_scene(path, SceneGraph())
    assert words in str(told.value)


def test_a_robot_that_is_the_world_is_carried_by_nothing(path):
    world = ARM.replace('"base"', '"world"')
    world = world.replace(f'<link name="world">{BALL}', '<link name="world">')
    (path.parent / 'arm.urdf').write_text(world)
    with pytest.raises(SceneFileError, match="has a link 'world', which is the world"):
        read_scene(path)


def test_a_source_does_not_go_while_it_carries_a_robot(loaded):
    scene_graph, scene = loaded
    with pytest.raises(GeometryError, match="6 frames of 'tool' are mounted on its frames"):
        scene_graph.RemoveSource(scene.sources['big'])
    scene_graph.RemoveSource(scene.sources['tool'])
    scene_graph.RemoveSource(scene.sources['big'])


def test_only_frames_that_are_free_are_mounted():
    scene_graph = SceneGraph()
    s, t = scene_graph.RegisterSource('s'), scene_graph.RegisterSource('t')
    a = scene_graph.RegisterFrame(s, GeometryFrame('a'))
    b = scene_graph.RegisterFrame(t, GeometryFrame('b'))
    scene_graph.MountFrame(t, b, a)
    assert scene_graph.model_inspector().GetHomeFrame(b) == a
    assert not scene_graph.model_inspector().IsAttached(b)
    for source, frame, parent, words in (
        (s, a, b, 'hangs on'),
        (s, b, a, 'belong'),
        (t, b, FrameId.get_new_id(), 'not a frame of this scene'),
    ):
        with pytest.raises(RuntimeError, match=words):
            scene_graph.MountFrame(source, frame, parent)
    scene_graph.AttachFrame(t, b, a, RigidTransform())
    with pytest.raises(GeometryError, match='is attached to a frame; detach it first'):
        scene_graph.MountFrame(t, b, a)
