"""Where rounding may have put bodies: what World says of it holds, and no bound is above truth."""

import numpy as np
import pytest
from oracles.poses import composed, length, mp
from oracles.worlds import bounded, geometry_table, random_rotations

from drake_geom_ros.geometry._proximity.kinds import BOX, HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import (
    separation_from_plane,
    separation_of_aabbs,
)
from drake_geom_ros.geometry._proximity.world.pose_rounding import (
    RADIUS,
    TILT,
    make_orthogonal,
    taken_roundings,
)
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World
from drake_geom_ros.math.batched import rotations_from_quaternions

HALF = [0.3, 0.2, 0.1]


class Chain:
    """A ball, a box and a half space on the last of some frames, and a ball on the world."""

    def __init__(self, depth, parents=None):
        parents = np.arange(-1, depth).clip(min=0) if parents is None else parents
        frames = FrameTable(np.arange(1, depth + 2), parents)
        table = geometry_table(
            [depth, depth, depth, 0],
            [SPHERE, BOX, HALF_SPACE, SPHERE],
            [[0.5], HALF, [], [0.25]],
        )
        self.world = World(frames, table)
        self.rows = np.arange(1, depth + 1)

    def pose(self, poses):
        """Pose the frames, and know exactly where the last one is."""
        poses = np.array(poses)
        Rs = rotations_from_quaternions(poses[:, 3:])
        self.world.set_poses(self.rows, Rs, poses[:, :3])
        self.world.update()
        self.R_WG, self.p_WG = composed(poses)

    def points(self, p_Gs):
        """Return points of the last frame in the world, exactly."""
        return [self.p_WG + self.R_WG * mp.matrix(p_G) for p_G in p_Gs]


def random_chain(rng, depth, link, returns):
    """Return poses (depth, 7) of frames; the last may lead back to the origin, nearly."""
    poses = np.hstack((link * rng.normal(size=(depth, 3)), rng.normal(size=(depth, 4))))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    if returns:
        R_WP, p_WP = composed(poses[:-1])
        poses[-1, :3] = [float(x) for x in -(R_WP.T * p_WP)]
    return poses


CASES = [(1, 1.0, False), (4, 1e3, True), (10, 10.0, False), (40, 1e6, True), (300, 0.3, False)]


@pytest.mark.parametrize(('depth', 'link', 'returns'), CASES)
def test_positions_and_rotations_are_as_near_as_they_say(depth, link, returns):
    for seed in range(3 if depth > 100 else 10):
        chain = Chain(depth)
        chain.pose(random_chain(np.random.default_rng(seed), depth, link, returns))
        world = chain.world
        shift = length(chain.p_WG - mp.matrix(world.p_WGs[0].tolist()))
        turn = mp.mnorm(chain.R_WG - mp.matrix(world.R_WGs[0].tolist()), 'f')
        assert shift <= world.roundings[0, RADIUS]
        assert shift + turn * world.outer_radii[1] <= world.roundings[1, RADIUS]
        assert shift <= world.roundings[2, RADIUS]
        assert turn <= world.roundings[2, TILT]
        assert world.roundings[:2, TILT].tolist() == [0.0, 0.0]
        # It is the worst case, and grows with the depth but no faster.
        assert world.roundings[2, TILT] <= 20 * depth * 2.0**-52


@pytest.mark.parametrize(('depth', 'link', 'returns'), CASES)
def test_boxes_and_gaps_hold_the_exact_bodies(depth, link, returns):
    corners = np.array(np.meshgrid(*([-h, h] for h in HALF))).reshape(3, -1).T
    for seed in range(3 if depth > 100 else 10):
        rng, chain = np.random.default_rng(seed), Chain(depth)
        chain.pose(random_chain(rng, depth, link, returns))
        world = chain.world
        p, half = world.p_WGs, world.half_extents
        for corner in chain.points(corners.tolist()):
            for k in range(3):
                assert abs(corner[k] - p[1, k]) <= half[1, k] * (1 + 2.0**-50)
        for k in range(3):
            assert abs(chain.p_WG[k] - p[0, k]) + 0.5 <= half[0, k]
        # A box stands upright on an axis, so that its gap is exact but for rounding.
        p[3] = [float(x) for x in chain.p_WG]
        p[3, 0] += 1.0
        gap = separation_of_aabbs(p, half, 0, 3)
        assert gap <= abs(mp.matrix(p[3].tolist())[0] - chain.p_WG[0]) - 0.75
        p[3] += 10.0 * link * rng.normal(size=3)
        height = (chain.R_WG.T * (mp.matrix(p[3].tolist()) - chain.p_WG))[2]
        assert separation_from_plane(2, 3, bounded(world)) <= height - 0.25


def test_no_body_is_farther_than_its_travels_and_roundings_tell():
    # Cached lower bounds rest on it: of bodies blown up by their roundings the distance falls by
    # no more than they travelled, and the exact bodies are within them.
    rng = np.random.default_rng(0)
    chain = Chain(3)
    p_WC = np.array([2.0, 0.0, 0.0])
    chain.pose(random_chain(rng, 3, 1.0, True))
    world = chain.world
    known = []
    for step in range(30):
        link = 10.0 ** rng.uniform(0.0, 8.0)
        apart = np.linalg.norm(world.p_WGs[0] - p_WC) * (1 - 1e-15)
        known.append(apart - world.roundings[0, RADIUS] + world.travels[0])
        chain.pose(random_chain(rng, 3, link, step % 2 == 0))
        exact = length(chain.p_WG - mp.matrix(p_WC.tolist()))
        for slack in known:
            assert slack - world.travels[0] <= exact
    assert len(set(known)) > 20


def test_what_is_made_of_zeros_and_ones_is_exact():
    rng = np.random.default_rng(0)
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    Rs = np.concatenate((np.eye(3)[None], quarter[None], random_rotations(rng, 2)))
    Rs = np.concatenate((Rs, Rs[:1]))
    Rs[4, 0, 1] = 1e-300
    assert (taken_roundings(Rs)[:, 0] > 0.0).tolist() == [False, False, True, True, True]
    chain = Chain(2)
    chain.world.set_poses(chain.rows, Rs[:2], np.array([[1.0, 2.0, 3.0], [0.0, 1.0, 0.0]]))
    chain.world.update()
    assert chain.world.roundings[2, TILT] == 0.0
    np.testing.assert_array_equal(chain.world.R_WFs[2], quarter)
    assert 0.0 < chain.world.roundings[0, RADIUS] < 2e-14


def test_what_is_almost_a_rotation_goes_to_the_one_nearest_to_it():
    rng = np.random.default_rng(9)
    for R in random_rotations(rng, 5):
        off = R @ (np.eye(3) + 1e-9 * rng.normal(size=(3, 3)))
        u, _, v = mp.svd_r(mp.matrix(off.tolist()))  # NumPy's is off by 2e-15
        nearest = np.array((u * v).tolist(), dtype=np.float64)
        matrices = np.stack((np.zeros((3, 3)), off, np.zeros((3, 3))))
        make_orthogonal(matrices, 1)
        np.testing.assert_allclose(matrices[1], nearest, rtol=0, atol=2e-16)
        assert not matrices[[0, 2]].any()
