"""Conversions with plain objects: no message class, no ROS."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.ros import conversions
from drake_geom_ros.ros.names import NameTable


def plain_pose():
    return Plain(
        position=Plain(x=0.0, y=0.0, z=0.0), orientation=Plain(x=0.0, y=0.0, z=0.0, w=1.0)
    )


def plain_poses(names=(), ids=(), rows=(), source=''):
    flat = [float(x) for row in rows for x in row]
    return Plain(source=source, frame_names=list(names), frame_ids=list(ids), poses=flat)


@pytest.fixture
def scene():
    """Return a scene of two sources with a frame `arm` each, and a ball on each frame."""
    scene_graph = SceneGraph()
    for source_name in ('left', 'right'):
        source = scene_graph.RegisterSource(source_name)
        frame = scene_graph.RegisterFrame(source, GeometryFrame('arm'))
        ball = GeometryInstance(RigidTransform(), Sphere(0.1), 'ball')
        ball = scene_graph.RegisterGeometry(source, frame, ball)
        scene_graph.AssignRole(source, ball, ProximityProperties())
    scene_graph.RegisterFrame(source, GeometryFrame('hand'))
    return scene_graph


@pytest.fixture
def names(scene):
    return NameTable(scene.model_inspector())


@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_poses_there_and_back(numbers):
    X = RigidTransform(RollPitchYaw(*numbers[:3]), numbers[3:])
    message = plain_pose()
    conversions.fill_pose(message, X)
    assert conversions.pose_from_message(message).IsNearlyEqualTo(X, 1e-14)


def test_a_pose_that_is_none_is_refused():
    message = plain_pose()
    message.orientation.w = 0.5
    with pytest.raises(RuntimeError, match=r'norm 0\.5'):
        conversions.pose_from_message(message)


def test_frame_poses_by_name_and_by_id(scene, names):
    reader = conversions.FramePosesReader(names)
    row = [1, 2, 3, 0, 0, 0, 1]
    left = names.frame('left::arm')
    for message in (
        plain_poses(['left::arm'], rows=[row]),
        plain_poses(['arm'], rows=[row], source='left'),
        plain_poses(['hand'], rows=[row]),
        plain_poses(ids=[left.get_value()], rows=[row]),
        plain_poses(ids=[left.get_value()], rows=[row], source='left'),
    ):
        for _ in range(2):  # The second time the names are known.
            poses = reader.read(message)
            assert isinstance(poses, FramePoseVector)
            assert poses.value(poses.ids()[0]).translation().tolist() == [1, 2, 3]
    assert len(reader.read(plain_poses())) == 0


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (plain_poses(['arm'], rows=[[0] * 7]), "borne by 2: 'left::arm'"),
        (plain_poses(['nobody'], rows=[[0] * 7]), "no frame 'nobody'"),
        (plain_poses(['n' * 10**6], rows=[[0] * 7]), r'nnn\.\.\.'),
        (plain_poses(['hand'], rows=[[0] * 7], source='nobody'), "no source 'nobody'"),
        (plain_poses(['hand'], rows=[[0] * 7], source='left'), "no frame 'left::hand'"),
        (plain_poses(['right::hand'], rows=[[0] * 7], source='left'), 'does not belong'),
        (plain_poses(['hand'], rows=[[0] * 6]), '6 numbers for 1 frames'),
        (plain_poses(rows=[[0] * 7]), '7 numbers for 0 frames'),
        (plain_poses(['hand'], [3], rows=[[0] * 7]), 'both given'),
        (plain_poses(['hand', 'right::hand'], rows=[[0] * 7] * 2), 'named twice'),
        (plain_poses(['world'], rows=[[0] * 7]), 'world frame'),
        (plain_poses(ids=[10**15], rows=[[0] * 7]), '#1000000000000000'),
        (plain_poses(['hand'], rows=[[0, 0, math.inf, 0, 0, 0, 1]]), 'not finite'),
        (plain_poses(['hand'], rows=[[0, 0, 0, 0, 0, 0, 1.01]]), 'norm 1.01'),
    ],
)
def test_frame_poses_that_are_none_are_refused(names, message, words):
    with pytest.raises(RuntimeError, match=words):
        conversions.FramePosesReader(names).read(message)


def test_memory_of_names_is_bounded(names):
    reader = conversions.FramePosesReader(names)
    hand = names.frame('hand').get_value()
    for k in range(1000):
        with pytest.raises(RuntimeError):
            reader.read(plain_poses(ids=[hand, 10**6 + k], rows=[[0, 0, 0, 0, 0, 0, 1]] * 2))
        reader.read(plain_poses(['right::hand'], rows=[[0, 0, 0, 0, 0, 0, 1]]))
    assert len(reader._known) <= 64


def test_declarations(scene, names):
    everything = {'frames': [], 'geometries': [], 'frame_ids': [], 'geometry_ids': []}
    both = Plain(**{**everything, 'geometries': ['left::arm/ball', 'right::arm/ball']})
    nothing = Plain(**everything)
    statement = Plain(operation=1, set_a=both, set_b=nothing)
    declaration = conversions.declaration_from_message(Plain(statements=[statement]), names)
    manager = scene.collision_filter_manager()
    a, b = names.geometry('left::arm/ball'), names.geometry('right::arm/ball')
    manager.Apply(declaration)
    assert scene.model_inspector().CollisionFiltered(a, b)
    statement.operation = 3
    manager.Apply(conversions.declaration_from_message(Plain(statements=[statement]), names))
    assert not scene.model_inspector().CollisionFiltered(a, b)
    by_frame = Plain(**{**everything, 'frames': ['left::arm']})
    other = Plain(**{**everything, 'geometry_ids': [b.get_value()]})
    statement = Plain(operation=2, set_a=by_frame, set_b=other)
    manager.Apply(conversions.declaration_from_message(Plain(statements=[statement]), names))
    assert scene.model_inspector().CollisionFiltered(a, b)
    statement.operation = 9
    with pytest.raises(RuntimeError, match=r'statements\[0\].operation is 9'):
        conversions.declaration_from_message(Plain(statements=[statement]), names)
    statement.set_a = Plain(**{**everything, 'frame_ids': [10**9]})
    with pytest.raises(RuntimeError, match=r'statements\[0\]: .*#1000000000'):
        conversions.declaration_from_message(Plain(statements=[statement]), names)


def posed(scene, names, x):
    """Return a query object with the balls x apart."""
    context = scene.CreateDefaultContext()
    frames = [names.frame('left::arm'), names.frame('right::arm')]
    rows = np.array([[0, 0, 0, 0, 0, 0, 1], [x, 0, 0, 0, 0, 0, 1.0]])
    context.UpdateFramePoses(FramePoseVector.FromArrays(frames, rows))
    return scene.get_query_output_port().Eval(context)


def test_results_fill_flat_arrays(scene, names):
    distances = posed(scene, names, 0.5).ComputeSignedDistancePairwiseClosestPoints()
    message = Plain()
    conversions.fill_signed_distances(message, distances, math.inf)
    a, b = names.geometry('left::arm/ball'), names.geometry('right::arm/ball')
    assert list(message.id_a) == [a.get_value()]
    assert list(message.id_b) == [b.get_value()]
    assert message.distance[0] == pytest.approx(0.3, abs=1e-15)
    assert list(message.p_aca) == pytest.approx([0.1, 0, 0])
    assert list(message.p_bcb) == pytest.approx([-0.1, 0, 0])
    assert list(message.nhat_ba_w) == [-1.0, 0.0, 0.0]
    assert message.is_nhat_ba_w_unique == [True]
    assert list(message.method) == [1]
    assert [x.typecode for x in (message.id_a, message.distance, message.method)] == list('QdB')
    contact = posed(scene, names, 0.15)
    message = Plain()
    conversions.fill_penetrations(message, contact.ComputePointPairPenetration())
    assert message.depth[0] == pytest.approx(0.05, abs=1e-15)
    assert list(message.p_wca) == pytest.approx([0.1, 0, 0])
    assert list(message.p_wcb) == pytest.approx([0.05, 0, 0])
    message = Plain()
    points = contact.ComputeSignedDistanceToPoint([[0, 0, 0.3], [9, 9, 9]], 1.0)
    conversions.fill_point_distances(message, [points], 1.0, [np.arange(len(points))])
    assert list(message.point_index) == [0, 0]
    assert list(message.id_g) == [a.get_value(), b.get_value()]
    assert message.distance[0] == pytest.approx(0.2, abs=1e-15)
    assert list(message.p_gn)[:3] == pytest.approx([0, 0, 0.1])
    assert list(message.grad_w)[:3] == pytest.approx([0, 0, 1])


def test_an_empty_result_fills_empty_arrays(scene, names):
    message = Plain()
    results = posed(scene, names, 5.0).ComputePointPairPenetration()
    conversions.fill_penetrations(message, results)
    assert [len(v) for v in vars(message).values()] == [0] * 8


def test_a_geometry_set_is_the_union_of_all_it_names(scene, names):
    a, b = names.geometry('left::arm/ball'), names.geometry('right::arm/ball')
    frame = names.frame('left::arm')
    message = Plain(
        frames=['left::arm'], frame_ids=[], geometries=[f'#{b.get_value()}'], geometry_ids=[]
    )
    found = conversions.geometry_set_from_message(message, names)
    assert isinstance(found, GeometrySet)
    assert scene._model.resolve(found) == [a, b]
    assert frame
