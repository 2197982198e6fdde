"""What is certified of a sensed map over a half space, at every level: the truth is within."""

import numpy as np
import pytest
from oracles.sensed_maps import KINDS, awkward_maps, cells_of, grid
from oracles.shape_scenes import ShapeScene

from drake_geom_ros import batch
from drake_geom_ros.geometry import (
    Box,
    FramePoseVector,
    HalfSpace,
    Mesh,
    MeshData,
    ProximityProperties,
    RoleAssign,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix
from truth.bodies.random_bodies import random_rotation

MAPS = awkward_maps(np.random.default_rng(1))
LEVELS = ('bound', 'fast', 'balanced', 'exact')


def random_pose(rng, reach):
    return RigidTransform(RotationMatrix(random_rotation(rng)), rng.uniform(-reach, reach, 3))


def height_above(shape, X_WM, X_WH):
    """Return the signed distance of a map from a half space, cell by cell."""
    cell, centres = cells_of(shape)
    X_HM = X_WH.inverse() @ X_WM
    heights = (X_HM.rotation().matrix() @ centres.T)[2] + X_HM.translation()[2]
    if isinstance(cell, Box):
        return heights.min() - 0.5 * shape.resolution() * np.abs(X_HM.rotation().matrix()[2]).sum()
    return heights.min() - cell.radius()


@pytest.mark.parametrize('is_map_first', [True, False])
@pytest.mark.parametrize('kind', KINDS)
def test_the_truth_is_within_the_bound_of_every_level(kind, is_map_first):
    rng = np.random.default_rng(5)
    for name, centres in MAPS.items():
        shape, reach = kind(0.1, 0.1 * centres), 0.1 * np.abs(centres).max() + 0.5
        scene = ShapeScene(*((shape, HalfSpace()) if is_map_first else (HalfSpace(), shape)))
        for _ in range(4):
            poses = random_pose(rng, reach), random_pose(rng, reach)
            truth = height_above(shape, *(poses if is_map_first else poses[::-1]))
            for level in LEVELS:
                query = scene.posed(*poses).query
                (found,) = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
                assert abs(found.distance - truth) <= found.error_bound + 1e-14, (name, level)
                assert found.error_bound < 1e-12 or level == 'bound'


@pytest.mark.parametrize('padding', [0.0, 0.02])
@pytest.mark.parametrize('kind', KINDS)
def test_a_map_whose_box_reaches_into_the_floor_is_no_contact(kind, padding):
    shape = kind(0.1, [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0]])
    scene = ShapeScene(shape, HalfSpace())
    properties = ProximityProperties()
    properties.AddProperty('proximity', 'padding', padding)
    scene.graph.AssignRole(
        scene.context, scene.source, scene.ids[0], properties, RoleAssign.kReplace
    )
    turn = RotationMatrix(RollPitchYaw(0.0, np.pi / 4, 0.0))
    above, below = RigidTransform(turn, [0.0, 0.0, 0.3]), RigidTransform(turn, [0.0, 0.0, 0.0])
    query = scene.posed(RigidTransform(turn, [0.0, 0.0, 1.5]), RigidTransform()).query
    least = height_above(shape, above, RigidTransform()) - padding

    def moved(X_WM, level):
        end = FramePoseVector({scene.frames[0]: X_WM, scene.frames[1]: RigidTransform()})
        return query.CheckMotion(end, accuracy=level)

    assert moved(above, 'exact').outcome == 'clear'
    assert moved(above, 'bound').outcome in ('clear', 'unknown')
    assert moved(below, 'bound').outcome in ('contact', 'unknown')
    assert moved(below, 'exact').outcome == 'contact'
    states = np.zeros((1, 1, 7))
    states[0, 0] = (*above.translation(), *np.roll(turn.ToQuaternion().wxyz(), -1))
    for level in LEVELS:
        found = batch.evaluate(
            scene.context, [scene.frames[0]], states, want='least', accuracy=level
        )
        assert abs(found.distance[0] - least) <= found.error_bound[0]


def test_bounds_of_solids_over_a_half_space_are_exact():
    """The hull of a solid reaches as far into a half space as the solid itself."""
    rng = np.random.default_rng(6)
    corners = 0.1 * grid(2, 2, 2) + [0.3, 0.0, 0.1]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    scene = ShapeScene(Mesh.FromMeshData(MeshData(corners, triangles)), HalfSpace())
    for _ in range(10):
        X_WM, X_WH = random_pose(rng, 1.0), random_pose(rng, 1.0)
        truth = ((X_WH.inverse() @ X_WM).multiply(corners.T)[2]).min()
        (found,) = scene.posed(X_WM, X_WH).query.ComputeSignedDistancePairwiseClosestPoints(
            accuracy='bound'
        )
        assert abs(found.distance - truth) <= found.error_bound <= 1e-13
