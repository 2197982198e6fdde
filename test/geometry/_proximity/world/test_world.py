"""Posing: chains of frames, what moves and what does not, bounds that hold the shapes."""

import numpy as np
import pytest
from oracles.worlds import geometry_table, random_rotations, random_world, shuffle
from scipy.spatial.transform import Rotation

from drake_geom_ros.geometry._proximity.world.world import FrameTable, World
from truth.bodies.random_bodies import random_directions


def chain(rng, depth=4):
    """Return a world of nested frames, each with a sphere, and its random poses."""
    ids = np.arange(1, depth + 2)
    parents = np.array([0, *range(depth)])
    table = geometry_table(range(1, depth + 1), [1] * depth, [[0.1]] * depth)
    world = World(FrameTable(ids, parents), table)
    Rs, ps = random_rotations(rng, depth), rng.normal(size=(depth, 3))
    world.set_poses(np.arange(1, depth + 1), Rs, ps)
    return world, Rs, ps


def test_nested_frames_compose():
    world, Rs, ps = chain(np.random.default_rng(1))
    world.update()
    X_WF = np.eye(4)
    for k in range(len(Rs)):
        X = np.eye(4)
        X[:3, :3], X[:3, 3] = Rs[k], ps[k]
        X_WF = X_WF @ X
        np.testing.assert_allclose(world.R_WFs[k + 1], X_WF[:3, :3], rtol=0, atol=1e-14)
        np.testing.assert_allclose(world.p_WFs[k + 1], X_WF[:3, 3], rtol=0, atol=1e-14)
        np.testing.assert_allclose(world.p_WGs[k], X_WF[:3, 3], rtol=0, atol=1e-14)


def test_only_what_moved_is_updated():
    world, Rs, ps = chain(np.random.default_rng(2))
    assert world.update() == (4, 4)
    assert world.update() == (0, 0)
    assert (world.stamps == 1).all()
    # The same pose again is not a move; the third of four frames carries the fourth along.
    world.set_poses(np.arange(1, 5), Rs, ps)
    assert world.update() == (0, 0)
    world.set_poses(np.array([3]), Rs[:1], ps[:1])
    assert world.update() == (2, 2)
    assert world.stamps.tolist() == [1, 1, world.revision, world.revision]


def test_copy_and_original_are_independent():
    rng = np.random.default_rng(3)
    world = random_world(rng, 6)
    copy = world.copy()
    before = copy.p_WGs.copy()
    shuffle(rng, world)
    copy.update()
    np.testing.assert_array_equal(copy.p_WGs, before)
    assert not np.array_equal(world.p_WGs, before)


def test_rebuilding_keeps_the_poses_of_frames_that_stay():
    world, Rs, ps = chain(np.random.default_rng(4))
    frames = FrameTable(np.array([1, 3, 2, 99]), np.array([0, 0, 0, 0]))
    other = world.rebuilt(frames, geometry_table([1, 3], [1, 1], [[0.1], [0.1]]))
    other.update()
    np.testing.assert_array_equal(other.R_PFs[1], Rs[1])
    np.testing.assert_array_equal(other.p_PFs[2], ps[0])
    np.testing.assert_array_equal(other.p_WGs[1], np.zeros(3))


@pytest.mark.parametrize('kind', [1, 2, 3, 4, 5])
def test_no_point_comes_farther_than_its_body_travels(kind):
    rng = np.random.default_rng(kind)
    world = random_world(rng, 8, types=(kind,))
    directions = random_directions(rng, 3000)
    frames, table = np.arange(1, 9), world.geometries
    assert not world.travels.any()
    for length in (1e-9, 1e-3, 0.1, 10.0):
        before, R_before, p_before = world.travels.copy(), world.R_WGs.copy(), world.p_WGs.copy()
        steps = Rotation.from_rotvec(length * random_directions(rng, 8)).as_matrix()
        turned = world.R_PFs[frames] @ steps
        world.set_poses(frames, turned, world.p_PFs[frames] + length * rng.normal(size=(8, 3)))
        world.update()
        for g in range(8):
            surface_G = surface_points(
                kind, table.pool[table.starts[g] : table.starts[g + 1]], directions
            )
            after = surface_G @ world.R_WGs[g].T + world.p_WGs[g]
            ways = np.linalg.norm(after - surface_G @ R_before[g].T - p_before[g], axis=1)
            if kind == 1:  # as a set it only moves with its centre
                ways = np.linalg.norm(world.p_WGs[g] - p_before[g])
            travelled = world.travels[g] - before[g]
            assert ways.max() <= travelled
            assert travelled <= 3.0 * (ways.max() + length)
            assert world.paces[g] >= travelled * (1 - 1e-12)


@pytest.mark.parametrize('kind', [1, 2, 3, 4, 5])
def test_bounds_hold_the_surface_and_are_tight(kind):
    rng = np.random.default_rng(kind)
    world = random_world(rng, 8, types=(kind,))
    directions = random_directions(rng, 20_000)
    table = world.geometries
    for g in range(8):
        shape = table.pool[table.starts[g] : table.starts[g + 1]]
        surface_G = surface_points(kind, shape, directions)
        surface_W = surface_G @ world.R_WGs[g].T
        reach = np.abs(surface_W).max(axis=0)
        assert (reach <= world.half_extents[g] * (1 + 1e-14)).all()
        assert (reach >= world.half_extents[g] * 0.97).all()
        radii = np.linalg.norm(surface_G, axis=1)
        assert radii.max() <= world.outer_radii[g] * (1 + 1e-14)
        assert radii.max() >= world.outer_radii[g] * 0.97
        assert radii.min() >= world.inner_radii[g] * (1 - 1e-14)


def surface_points(kind, shape, directions):
    """Return points of a shape's surface from directions (m, 3), each by its definition."""
    if kind == 1:
        return shape[0] * directions
    if kind == 2:
        scaled = directions / np.abs(directions).max(axis=1)[:, None]
        return scaled * shape
    if kind == 5:
        return directions * shape
    if kind == 3:
        ends = np.where(directions[:, 2:] > 0, 1.0, -1.0) * [0.0, 0.0, shape[1]]
        return shape[0] * directions + ends
    flat = directions[:, :2] / np.linalg.norm(directions[:, :2], axis=1)[:, None]
    side = np.column_stack((shape[0] * flat, shape[1] * directions[:, 2]))
    rims = side.copy()
    rims[:, 2] = np.sign(side[:, 2]) * shape[1]
    return np.vstack((side, rims))
