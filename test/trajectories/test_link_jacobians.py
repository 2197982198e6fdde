"""Link Jacobians, and distances of a robot by its joints."""

import numpy as np
import pytest
from oracles import panda

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Capsule,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.trajectories.kinematics import Kinematics


@pytest.fixture(scope='module')
def arm():
    return Kinematics(str(panda.URDF))


def test_they_are_differences_of_the_transforms(arm):
    rng, h = np.random.default_rng(4), 1e-6
    X_WB = np.array([[0.0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    q = rng.uniform(arm.lower, arm.upper, (2, 3, len(arm.lower)))
    Js, X_WLs = arm.link_jacobians(q, X_WB), arm.link_transforms(q, X_WB)
    assert Js.shape == (2, 3, 13, 6, 8)
    for joint in range(8):
        step = h * np.eye(8)[joint]
        ahead, behind = arm.link_transforms(q + step, X_WB), arm.link_transforms(q - step, X_WB)
        rate = (ahead - behind) / (2 * h)
        v = rate[..., :3, 3]
        W = rate[..., :3, :3] @ np.swapaxes(X_WLs[..., :3, :3], -1, -2)
        w = np.stack((W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]), axis=-1)
        np.testing.assert_allclose(
            Js[..., joint], np.concatenate((w, v), axis=-1), rtol=0, atol=1e-9
        )


class Cell:
    """A capsule on each link of the arm, and a box that stands in the world."""

    def __init__(self, arm):
        self.arm, self.graph = arm, SceneGraph()
        source = self.graph.RegisterSource('arm')
        self.frames = {}
        for name in arm.link_names:
            self.frames[name] = self.graph.RegisterFrame(source, GeometryFrame(name))
            self.add(source, self.frames[name], Capsule(0.04, 0.08), [0, 0, 0.02], name)
        self.add(source, self.graph.world_frame_id(), Box(0.4, 0.4, 0.2), [0.6, 0.3, 0.3], 'box')
        self.context = self.graph.CreateDefaultContext()
        self.query = self.graph.get_query_output_port().Eval(self.context)

    def add(self, source, frame, shape, p_FG, name):
        instance = GeometryInstance(RigidTransform(p_FG), shape, name)
        instance.set_proximity_properties(ProximityProperties())
        self.graph.RegisterGeometry(source, frame, instance)

    def ask(self, q):
        X_WLs = self.arm.link_transforms(q)
        poses = zip(self.frames.values(), map(RigidTransform, X_WLs), strict=True)
        self.context.UpdateFramePoses(FramePoseVector(dict(poses)))
        return self.query.ComputeSignedDistancePairwiseClosestPoints()


def test_distances_by_joints_foretell_what_the_joints_do(arm):
    cell, h = Cell(arm), 1e-6
    q = np.array([0.3, 0.4, -0.2, -1.9, 0.3, 1.7, 0.5, 0.02])
    found = cell.ask(q)
    Js = dict(zip(cell.frames.values(), arm.link_jacobians(q), strict=True))
    by_joints = found.jacobian_by_frames(Js)
    assert by_joints.shape == (len(found), 8)
    # The box stands still, so its Jacobian is none: the same as one of zeros.
    of = {frame.get_value(): J for frame, J in Js.items()}
    J_As, J_Bs = (
        np.array([of.get(frame, np.zeros((6, 8))) for frame in frames.tolist()])
        for frames in (found.frame_id_A, found.frame_id_B)
    )
    np.testing.assert_array_equal(by_joints, found.distance_jacobian(J_As, J_Bs))
    there = found.is_gradient_unique
    assert there.mean() > 0.5
    for joint in range(8):
        step = h * np.eye(8)[joint]
        rates = (cell.ask(q + step).distance - cell.ask(q - step).distance) / (2 * h)
        np.testing.assert_allclose(by_joints[there, joint], rates[there], rtol=0, atol=1e-7)


def test_what_is_no_jacobian_is_refused(arm):
    cell = Cell(arm)
    found = cell.ask(np.zeros(8) + 0.1)
    frame, other = list(cell.frames.values())[:2]
    for wrong in ({}, {frame: np.zeros(6)}, {frame: np.zeros((6, 2)), other: np.zeros((6, 3))}):
        with pytest.raises(ArgumentError, match='jacobian_by_frames'):
            found.jacobian_by_frames(wrong)
