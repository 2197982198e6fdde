"""The demo's scene: what it holds, that it rests where it should, and that the arms can meet."""

import dataclasses
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    HalfSpace,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene, read_scene, register

SCENES = Path(__file__).parents[2] / 'scenes'
TABLE_TOP = 0.40  # [m]
REACH = 0.855  # [m] of a Panda's wrist from its first axis (maker's data sheet)
FIXED_TO_TABLE = {'fence', 'post', 'dome', 'lamp', 'knob'}


@pytest.fixture(scope='module')
def description():
    return read_scene(SCENES / 'two_pandas.yaml')


@pytest.fixture(scope='module')
def loaded():
    scene_graph = SceneGraph()
    return scene_graph, load_scene(SCENES / 'two_pandas.yaml', scene_graph)


def lowest_point(shape, X_WG):
    """The least z [m] of a shape, from its support function along -z of the world."""
    x, y, z = X_WG.rotation().matrix()[2]
    if isinstance(shape, Sphere):
        depth = shape.radius()
    elif isinstance(shape, Box):
        depth = np.abs([x, y, z]) @ shape.size() / 2
    elif isinstance(shape, Capsule):
        depth = abs(z) * shape.length() / 2 + shape.radius()
    elif isinstance(shape, Cylinder):
        depth = abs(z) * shape.length() / 2 + np.hypot(x, y) * shape.radius()
    else:
        depth = np.linalg.norm([x * shape.a(), y * shape.b(), z * shape.c()])
    return X_WG.translation()[2] - depth


def objects(description):
    """(name, shape, X_WG) of all that stands on the table, what is fixed to it included."""
    X_WFs = {frame.name: frame.X_PF for frame in description.frames if frame.source == 'objects'}
    for geometry in description.geometries:
        if geometry.source == 'objects':
            X_WG = X_WFs[geometry.frame] @ geometry.X_FG
            yield f'{geometry.frame}/{geometry.name}', geometry.shape, X_WG
        elif geometry.name in FIXED_TO_TABLE:
            yield geometry.name, geometry.shape, geometry.X_FG


def test_both_arms_have_all_their_collision_shapes(description):
    counts = Counter(geometry.source for geometry in description.geometries)
    assert counts['left'] == counts['right'] == 39
    assert [robot.name for robot in description.robots] == ['left', 'right']


def test_a_dozen_objects_of_every_primitive_shape_stand_on_the_table(description):
    kinds = Counter(type(shape) for _, shape, _ in objects(description))
    assert set(kinds) == {Sphere, Box, Capsule, Cylinder, Ellipsoid}
    assert sum(kinds.values()) >= 12
    assert any(isinstance(geometry.shape, HalfSpace) for geometry in description.geometries)


def test_what_can_be_grasped_rests_on_the_table(description):
    lowest = {}
    for name, shape, X_WG in objects(description):
        frame = name.split('/')[0]
        lowest[frame] = min(lowest.get(frame, np.inf), lowest_point(shape, X_WG))
    for frame in description.frames:
        if frame.source == 'objects':
            assert lowest[frame.name] == pytest.approx(TABLE_TOP, abs=1e-12), frame.name


def test_everything_stands_within_the_table(description):
    (table,) = (g for g in description.geometries if g.name == 'table_top')
    assert table.X_FG.translation()[2] + table.shape.height() / 2 == pytest.approx(TABLE_TOP)
    half = np.array([table.shape.width(), table.shape.depth()]) / 2
    for name, _, X_WG in objects(description):
        assert (np.abs(X_WG.translation()[:2]) < half).all(), name


def test_the_workspaces_of_the_arms_overlap_over_the_table(description):
    feet = [robot.X_WB.translation() for robot in description.robots]
    frames = [frame for frame in description.frames if frame.source == 'objects']
    reached = [
        sum(np.linalg.norm(frame.X_PF.translation() - foot) < REACH for foot in feet)
        for frame in frames
    ]
    assert min(reached) >= 1
    assert reached.count(2) >= 6


def test_the_arms_face_each_other(description):
    left, right = (robot.X_WB for robot in description.robots)
    toward = right.translation() - left.translation()
    toward /= np.linalg.norm(toward)
    np.testing.assert_allclose(left.rotation().col(0), toward, rtol=0, atol=1e-12)
    np.testing.assert_allclose(right.rotation().col(0), -toward, rtol=0, atol=1e-12)


def test_nothing_but_the_arms_and_the_table_is_in_touch_at_first(description):
    """Arms are left out, for their poses come with their motion; the table, for it is lain on."""
    sources = {'objects', 'scenery'}
    still = dataclasses.replace(
        description,
        robots=(),
        sources=('objects', 'scenery'),
        frames=tuple(frame for frame in description.frames if frame.source in sources),
        geometries=tuple(
            geometry
            for geometry in description.geometries
            if geometry.source in sources and geometry.name != 'table_top'
        ),
        filters=(),
        cameras=(),
    )
    scene_graph = SceneGraph()
    loaded = register(scene_graph, still)
    context = scene_graph.CreateDefaultContext()
    port = scene_graph.get_source_pose_port(loaded.sources['objects'])
    port.FixValue(context, FramePoseVector(dict(loaded.X_PFs)))
    query_object = scene_graph.get_query_output_port().Eval(context)
    pairs = query_object.ComputeSignedDistancePairwiseClosestPoints(0.02)
    assert [(pair.id_A, pair.id_B) for pair in pairs] == []


@pytest.mark.parametrize(
    ('a', 'b', 'reason'),
    [
        (('left', 'panda_link1', 'collision_0'), ('left', 'panda_link2', 'collision_1'),
         'clique left: panda_link1 - panda_link2'),
        (('left', 'panda_link7', 'collision_0'), ('left', 'panda_hand', 'collision_0'),
         'clique left: fixed to panda_link7'),
        (('right', 'panda_link0', 'collision_0'), ('right', 'panda_link2', 'collision_0'),
         'persistent declaration'),
        (('objects', 'can', 'can'), ('scenery', 'world', 'table_top'), 'group lying things'),
        (('left', 'panda_link0', 'collision_0'), ('scenery', 'world', 'left_pedestal'),
         'persistent declaration'),
        (('left', 'panda_hand', 'collision_0'), ('right', 'panda_hand', 'collision_0'), None),
        (('left', 'panda_hand', 'collision_0'), ('objects', 'can', 'can'), None),
        (('left', 'panda_hand', 'collision_0'), ('scenery', 'world', 'table_top'), None),
        (('objects', 'bottle', 'body'), ('objects', 'brick', 'brick'), None),
    ],
)  # fmt: skip
def test_what_is_filtered_and_what_is_not(loaded, a, b, reason):
    scene_graph, scene = loaded
    reasons = scene_graph.collision_filter_manager().explain(
        scene.geometries[a], scene.geometries[b]
    )
    if reason is None:
        assert reasons == []
    else:
        assert any(each.startswith(reason) for each in reasons)


def test_the_first_poses_are_of_the_objects_and_of_all_links(loaded):
    scene_graph, scene = loaded
    inspector = scene_graph.model_inspector()
    names = {(inspector.GetOwningSourceName(f), inspector.GetName(f)) for f in scene.X_PFs}
    links = {name for name in names if name[0] != 'objects'}
    assert len(names) > len(links)
    assert links == {name for name in scene.frames if name[0] in ('left', 'right')}
    assert all(isinstance(X_PF, RigidTransform) for X_PF in scene.X_PFs.values())
