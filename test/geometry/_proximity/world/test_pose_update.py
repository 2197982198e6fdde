"""Where bodies are posed, and what a step is told to have moved them by, at most."""

import math

import numpy as np
import pytest
from oracles.worlds import geometry_table, random_rotations

from drake_geom_ros.geometry._proximity.kinds import BOX
from drake_geom_ros.geometry._proximity.tolerances import ROTATION_DEFECT
from drake_geom_ros.geometry._proximity.world import pose_update as posing
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World
from truth.bodies.random_bodies import box_corners


@pytest.mark.parametrize('angle', [0.0, 1e-15, 1e-9, 0.3, math.pi])
@pytest.mark.parametrize('radius', [0.0, 0.5, 1e6])
@pytest.mark.parametrize('moved', [0.0, 2.0])
def test_a_way_is_no_shorter_than_that_of_any_point(angle, radius, moved):
    """A point at right angles to the axis goes 2 sin(angle / 2) of its distance from it.

    The rotations that are meant are next to their matrices, both by as much as the defect.
    """
    turned = 2.0 * (2.0 * math.sin(0.5 * angle)) ** 2  # the squared Frobenius norm
    told = posing._way(turned, moved**2, radius)
    truth = moved + radius * 2.0 * math.sin(0.5 * angle)
    noise = 2.0 * radius * ROTATION_DEFECT if angle > 0.0 else 0.0
    assert truth + noise <= told <= (truth + 1.001 * noise) * (1.0 + 1e-14)


def test_the_frobenius_norm_of_a_turn_is_that_of_its_sine():
    c, s = math.cos(0.3), math.sin(0.3)
    R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    turned = np.linalg.norm(R - np.eye(3)) ** 2
    assert turned == pytest.approx(2.0 * (2.0 * math.sin(0.15)) ** 2, rel=1e-14)


def test_bodies_on_frames_that_moved_are_posed_and_their_ways_add_up():
    """One at the origin of its frame and one beside it, moved without a turn, then turned."""
    rng = np.random.default_rng(1)
    (R_FG,), p_FG = random_rotations(rng, 1), np.array([0.1, -0.2, 0.3])
    frames = FrameTable(np.arange(1, 4), np.zeros(3, dtype=np.int64))
    R_FGs, p_FGs = np.stack((np.eye(3), R_FG)), np.stack((np.zeros(3), p_FG))
    table = geometry_table([1, 2], [BOX, BOX], [[0.3, 0.2, 0.1]] * 2, R_FGs, p_FGs)
    world = World(frames, table)
    Rs, ps = random_rotations(rng, 2), rng.normal(size=(2, 3))
    total, pace = 0.0, 0.0
    for step in (0.0, 2.0, 0.5, 0.25):
        ps = ps + step * np.array([0.6, 0.0, 0.8])
        world.set_poses(np.array([1, 2]), Rs, ps)
        assert world.update() == (2, 2)
        assert world.update() == (0, 0)
        total, pace = total + step, max(step, posing.FADING * pace)
        np.testing.assert_allclose(world.p_WGs, ps + np.stack((np.zeros(3), Rs[1] @ p_FG)))
        np.testing.assert_allclose(
            world.R_WGs, np.stack((Rs[0], Rs[1] @ R_FG)), rtol=0, atol=1e-15
        )
        np.testing.assert_allclose(world.travels, total, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(world.paces, pace, rtol=1e-12, atol=1e-14)
    corners = box_corners((0.6, 0.4, 0.2))
    before = [p + corners @ R.T for R, p in zip(world.R_WGs, world.p_WGs, strict=True)]
    world.set_poses(np.array([1, 2]), random_rotations(rng, 2), ps)
    world.update()
    for g, (R, p) in enumerate(zip(world.R_WGs, world.p_WGs, strict=True)):
        way = np.linalg.norm(p + corners @ R.T - before[g], axis=1).max()
        assert total + way <= world.travels[g] <= total + 2.0 * way + 1.0
