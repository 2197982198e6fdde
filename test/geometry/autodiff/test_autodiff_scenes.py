"""Scenes of AutoDiffXd: registration, nested frames, and the same script under pydrake."""

import importlib.util

import numpy as np
import pytest

import drake_geom_ros.autodiffutils
import drake_geom_ros.geometry
import drake_geom_ros.math
from drake_geom_ros.autodiffutils import AutoDiffXd, ExtractGradient, InitializeAutoDiff
from drake_geom_ros.geometry import (
    FramePoseVector_,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    QueryObject_,
    SceneGraph_,
    SceneGraphInspector_,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RigidTransform_, RollPitchYaw_, RotationMatrix_

WITHOUT = importlib.util.find_spec('pydrake') is None
AT = np.array([0.2, -0.3, 0.4, 0.5, 0.6, 0.7])


def instance(shape, p_FG, name):
    made = GeometryInstance(RigidTransform(p_FG), shape, name)
    made.set_proximity_properties(ProximityProperties())
    return made


def test_frames_on_frames_carry_derivatives_on():
    graph = SceneGraph_[AutoDiffXd]()
    assert type(graph.model_inspector()) is SceneGraphInspector_[AutoDiffXd]
    source = graph.RegisterSource('s')
    arm = graph.RegisterFrame(source, GeometryFrame('arm'))
    hand = graph.RegisterFrame(source, arm, GeometryFrame('hand'))
    ball = graph.RegisterGeometry(source, hand, instance(Sphere(0.1), [0, 0, 0.2], 'ball'))
    anchor = instance(Sphere(0.3), [2.0, 0, 0], 'anchored')
    graph.RegisterAnchoredGeometry(source, anchor)

    def asked(numbers, rpy, R, X):
        context = graph.CreateDefaultContext()
        X_WA = X(R(rpy(*numbers[:3])), [0.1, 0.2, 0.3])
        X_AH = X(R.MakeXRotation(numbers[3]), np.array([numbers[4], 1.0, numbers[5]]))
        poses = FramePoseVector_[AutoDiffXd]({arm: X_WA, hand: X_AH})
        graph.get_source_pose_port(source).FixValue(context, poses)
        query = graph.get_query_output_port().Eval(context)
        (pair,) = query.ComputeSignedDistancePairwiseClosestPoints()
        return query.X_WG(ball).translation(), pair.distance

    types = (T[AutoDiffXd] for T in (RollPitchYaw_, RotationMatrix_, RigidTransform_))
    types = tuple(types)
    position, distance = asked(InitializeAutoDiff(AT)[:, 0], *types)
    found = np.vstack((ExtractGradient(position), distance.derivatives()))
    for k, step in enumerate(1e-6 * np.eye(6)):
        ahead, behind = (
            asked(InitializeAutoDiff(AT + s * step)[:, 0], *types) for s in (1.0, -1.0)
        )
        rates = [*(a.value() - b.value() for a, b in zip(ahead[0], behind[0], strict=True))]
        rates.append(ahead[1].value() - behind[1].value())
        np.testing.assert_allclose(found[:, k], np.array(rates) / 2e-6, rtol=0, atol=1e-8)


def test_poses_of_different_variables_are_refused():
    graph = SceneGraph_[AutoDiffXd]()
    source = graph.RegisterSource('s')
    frames = [graph.RegisterFrame(source, GeometryFrame(name)) for name in 'ab']
    for frame in frames:
        graph.RegisterGeometry(source, frame, instance(Sphere(0.1), [0, 0, 0], 'ball'))
    context, X = graph.CreateDefaultContext(), RigidTransform_[AutoDiffXd]
    poses = FramePoseVector_[AutoDiffXd]()
    for k, frame in enumerate(frames):
        poses.set_value(frame, X(InitializeAutoDiff([k, 1.0, 0.0], 3 + k)))
    graph.get_source_pose_port(source).FixValue(context, poses)
    query = graph.get_query_output_port().Eval(context)
    with pytest.raises(RuntimeError, match=r'\[3, 4\] variables'):
        query.ComputeSignedDistancePairwiseClosestPoints()


def script(geometry, math, autodiffutils):
    """Return distances, point distances and derivatives: what pydrake supports, by its calls."""
    number = autodiffutils.AutoDiffXd
    graph = geometry.SceneGraph_[number]()
    source = graph.RegisterSource('s')
    frames = []
    for name, shape in (('ball', geometry.Sphere(0.2)), ('box', geometry.Box(0.3, 0.4, 0.5))):
        frames.append(graph.RegisterFrame(source, geometry.GeometryFrame(name)))
        made = geometry.GeometryInstance(math.RigidTransform([0.05, 0.1, 0.0]), shape, name)
        made.set_proximity_properties(geometry.ProximityProperties())
        graph.RegisterGeometry(source, frames[-1], made)
    context = graph.CreateDefaultContext()
    x = autodiffutils.InitializeAutoDiff(AT)[:, 0]
    R = math.RotationMatrix_[number].MakeZRotation(x[0])
    X_WB = math.RigidTransform_[number](R, np.array([x[3], 1.0 + x[1], 0.1 * x[2]]))
    X_WS = math.RigidTransform_[number](np.array([x[4], x[5] * x[1], 0.1 * x[5]]))
    poses = geometry.FramePoseVector_[number]()
    poses.set_value(frames[0], X_WS)
    poses.set_value(frames[1], X_WB)
    graph.get_source_pose_port(source).FixValue(context, poses)
    query = graph.get_query_output_port().Eval(context)
    (pair,) = query.ComputeSignedDistancePairwiseClosestPoints()
    points = query.ComputeSignedDistanceToPoint(np.array([x[0], x[1], 1.0 + x[2]]))
    points.sort(key=lambda each: each.distance.value())
    rows = [pair.distance, *pair.nhat_BA_W.ravel(), *pair.p_ACa.ravel(), *pair.p_BCb.ravel()]
    for each in points:
        rows += [each.distance, *each.p_GN.ravel(), *each.grad_W.ravel()]
    rows = np.array(rows, dtype=object)
    return autodiffutils.ExtractValue(rows), autodiffutils.ExtractGradient(rows)


def ours():
    return drake_geom_ros.geometry, drake_geom_ros.math, drake_geom_ros.autodiffutils


def test_a_script_of_pydrakes_calls_runs():
    values, gradients = script(*ours())
    assert values.shape == (24, 1)
    assert gradients.shape == (24, 6)


@pytest.mark.skipif(WITHOUT, reason='no pydrake')
def test_it_says_what_pydrake_says():
    import pydrake.autodiffutils
    import pydrake.geometry
    import pydrake.math

    of_pydrake = script(pydrake.geometry, pydrake.math, pydrake.autodiffutils)
    for mine, its in zip(script(*ours()), of_pydrake, strict=True):
        np.testing.assert_allclose(mine, its, rtol=0, atol=1e-12)


@pytest.mark.skipif(WITHOUT, reason='no pydrake')
def test_pydrakes_numbers_and_poses_are_taken_and_given_back():
    import pydrake.autodiffutils
    import pydrake.math

    geometry = drake_geom_ros.geometry

    class Mixed:
        """Our math but for what carries derivatives, which is pydrake's."""

        RigidTransform = drake_geom_ros.math.RigidTransform
        RigidTransform_ = pydrake.math.RigidTransform_
        RotationMatrix_ = pydrake.math.RotationMatrix_

    values, gradients = script(geometry, Mixed, pydrake.autodiffutils)
    expected = script(*ours())
    np.testing.assert_allclose(values, expected[0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(gradients, expected[1], rtol=0, atol=1e-14)


@pytest.mark.parametrize('name', ['ComputeContactSurfaces', 'ComputeContactSurfacesWithFallback'])
def test_what_has_no_derivatives_says_where_to_look(name):
    query = QueryObject_[AutoDiffXd]()
    with pytest.raises(AttributeError, match=f'{name}.*differences_from_pydrake'):
        getattr(query, name)()
