"""Matrices that are almost rotations: an answer is about the rotations nearest to them."""

import numpy as np
import pytest
from oracles.poses import box_distance, nearest_rotation, vector
from oracles.small_scene import instance
from scipy.spatial.transform import Rotation

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryFrame,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix

HALF = np.array([0.3, 0.2, 0.1])


def stretched(rng, size):
    """Return a rotation whose columns are off unit length and right angles by ``size``."""
    E = rng.uniform(-1.0, 1.0, (3, 3))
    return Rotation.random(random_state=rng).as_matrix() @ (np.eye(3) + 0.25 * size * (E + E.T))


def pair(first, second):
    """Return the answer for two bodies, each a shape, R and p."""
    scene, ids = SceneGraph(), []
    source = scene.RegisterSource('pair')
    frame = scene.RegisterFrame(source, GeometryFrame('moving'))
    for k, (shape, R, p) in enumerate((first, second)):
        body = instance(f'body {k}', shape)
        body.set_pose(RigidTransform(RotationMatrix(R), p))
        on = (scene.world_frame_id(), frame)[k]
        ids.append(scene.RegisterGeometry(source, on, body))
    context = scene.CreateDefaultContext()
    context.UpdateFramePoses(FramePoseVector({frame: RigidTransform()}))
    query = scene.get_query_output_port().Eval(context)
    return query.ComputeSignedDistancePairClosestPoints(*ids)


@pytest.mark.parametrize('size', [1e-12, 3e-11])
@pytest.mark.parametrize('apart', [0.5, 1e3])
def test_the_distance_is_that_of_the_nearest_rotation(size, apart):
    rng = np.random.default_rng(0)
    for _ in range(50):
        R = stretched(rng, size)
        p = apart * rng.normal(size=3)
        answer = pair((Box(*(2 * HALF)), R, p), (Sphere(0.1), np.eye(3), np.zeros(3)))
        truth = box_distance(HALF, -(nearest_rotation(R).T * vector(p))) - 0.1
        assert abs(answer.distance - truth) <= answer.error_bound


@pytest.mark.parametrize(
    'shapes',
    [
        (Box(*(2 * HALF)), Box(0.5, 0.3, 0.1)),
        (Box(*(2 * HALF)), Cylinder(0.2, 0.5)),
        (Capsule(0.1, 0.5), Ellipsoid(0.3, 0.2, 0.1)),
    ],
)
def test_both_orders_agree(shapes):
    rng = np.random.default_rng(1)
    for _ in range(50):
        poses = [(stretched(rng, 1e-12), 30.0 * rng.normal(size=3)) for _ in range(2)]
        A, B = ((shape, *pose) for shape, pose in zip(shapes, poses, strict=True))
        one, other = pair(A, B), pair(B, A)
        assert abs(one.distance - other.distance) <= one.error_bound + other.error_bound
