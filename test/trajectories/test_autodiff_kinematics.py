"""Kinematics of AutoDiffXd: derivatives that are those of differences, up to a query."""

from pathlib import Path

import numpy as np
import pytest

from drake_geom_ros.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)
from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import FramePoseVector_, SceneGraph
from drake_geom_ros.math import RigidTransform, RigidTransform_, RollPitchYaw
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.trajectories import Kinematics

BATCH = Path(__file__).parents[1] / 'batch'
Q = [0.3, -0.7, 0.4, 0.05]


@pytest.fixture(scope='module')
def kinematics():
    return Kinematics(str(BATCH / 'arm.urdf'))


def test_the_derivatives_are_differences(kinematics):
    q = InitializeAutoDiff(Q)[:, 0]
    X_WB = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [0.4, 0.5, 0.6]).GetAsMatrix4()
    X_WLs = kinematics.link_transforms(q, X_WB)
    assert X_WLs.shape == (len(kinematics.link_names), 4, 4)
    step = 1e-6
    for link, X_WL in enumerate(X_WLs):
        np.testing.assert_array_equal(
            ExtractValue(X_WL), kinematics.link_transforms(Q, X_WB)[link]
        )
        gradient = ExtractGradient(X_WL).reshape(4, 4, 4)  # column, row, joint
        for joint in range(4):
            ends = np.array([Q, Q])
            ends[:, joint] += [-step, step]
            low, high = kinematics.link_transforms(ends, X_WB)[:, link]
            slope = (high - low) / (2.0 * step)
            np.testing.assert_allclose(gradient[:, :, joint].T, slope, rtol=0, atol=1e-8)


def test_a_query_of_them_gives_the_gradient_by_joints(kinematics):
    scene_graph = SceneGraph()
    loaded = load_scene(BATCH / 'cell.yaml', scene_graph)
    arm = loaded.robots['arm']
    X_WLs = kinematics.link_transforms(InitializeAutoDiff(Q)[:, 0], arm.X_WB.GetAsMatrix4())
    poses = FramePoseVector_[AutoDiffXd]()
    for link, X_WL in zip(kinematics.link_names, X_WLs, strict=True):
        poses.set_value(loaded.frames['arm', link], RigidTransform_[AutoDiffXd](X_WL))
    other = scene_graph.ToAutoDiffXd()
    context = other.CreateDefaultContext()
    other.get_source_pose_port(loaded.sources['arm']).FixValue(context, poses)
    pairs = (
        other.get_query_output_port().Eval(context).ComputeSignedDistancePairwiseClosestPoints()
    )
    by_joints = evaluate(
        scene_graph, want='within', states=[Q], joints=Joints.of(loaded), by_joints=True
    )
    assert len(pairs) == len(by_joints.distance)
    for pair, gradient in zip(pairs, by_joints.joint_gradient, strict=True):
        found = ExtractGradient(np.array([pair.distance]), 4)[0]
        np.testing.assert_allclose(found, gradient, rtol=0, atol=1e-12)


def test_what_is_not_taken_names_the_way_round(kinematics):
    q = InitializeAutoDiff(Q)
    with pytest.raises(ValueError, match=r'shape \(4,\), one configuration; got \(4, 1\)'):
        kinematics.link_transforms(q)
    with pytest.raises(ValueError, match=r'ExtractValue\(q\)'):
        kinematics.link_jacobians(q[:, 0])
    with pytest.raises(ValueError, match='X_WB must be of numbers'):
        kinematics.link_transforms(Q, InitializeAutoDiff(np.eye(4)))
