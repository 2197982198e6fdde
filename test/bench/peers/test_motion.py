"""Random walks stay where they may walk."""

import numpy as np
import pytest

from bench.peers.motion import PACES, ROBOT_STEP, Walk, reflected, swinging
from truth.bodies.arms import APART, BENT, LENGTHS


def test_mirrors_keep_values_inside_and_leave_those_that_are():
    values = np.linspace(-7.0, 9.0, 161)
    folded = reflected(values, np.array(-1.0), np.array(2.0))
    assert folded.min() >= -1.0
    assert folded.max() <= 2.0
    inside = (values >= -1.0) & (values <= 2.0)
    np.testing.assert_allclose(folded[inside], values[inside], rtol=0, atol=1e-12)
    np.testing.assert_allclose(reflected(np.array([2.5, -1.5]), -1.0, 2.0), [1.5, -0.5])


def test_a_walk_stays_in_its_box():
    lower, upper = np.full((20, 3), -0.1), np.full((20, 3), 0.2)
    p = Walk(lower, upper, step=np.full(20, 0.05)).poses(300, seed=3)[..., :3]
    assert (p >= lower).all()
    assert (p <= upper).all()
    assert np.ptp(p, axis=0).min() > 0.2


def test_at_robot_speed_a_body_moves_10_mm_and_at_jumps_everywhere():
    lower, upper = np.full((50, 3), -0.5), np.full((50, 3), 0.5)
    walk = Walk(lower, upper, step=np.full(50, 1e-3))
    steps = {pace: np.diff(walk.poses(100, 3, pace)[..., :3], axis=0).std() for pace in PACES}
    assert steps['slow'] < 1e-3
    np.testing.assert_allclose(steps['robot'], ROBOT_STEP, rtol=0.05)
    np.testing.assert_allclose(steps['jump'], np.sqrt(1.0 / 6.0), rtol=0.05)


@pytest.mark.parametrize('pace', PACES)
def test_links_stay_joined(pace):
    """The end of each link is where the next one begins, in every cycle."""
    from scipy.spatial.transform import Rotation

    poses = swinging(BENT).poses(10, 3, pace)
    half = 0.5 * np.array([*LENGTHS, *LENGTHS])
    for cycle in poses:
        along = Rotation.from_quat(cycle[:, 3:]).apply([0.0, 0.0, 1.0]) * half[:, None]
        ends, starts = cycle[:, :3] + along, cycle[:, :3] - along
        joined = [k for k in range(13) if k != 6]
        np.testing.assert_allclose(
            ends[joined], starts[[k + 1 for k in joined]], rtol=0, atol=1e-12
        )


@pytest.mark.parametrize('pace', PACES)
def test_of_an_arm_a_tenth_is_one_link(pace):
    poses = swinging(APART).tenth().poses(10, 3, pace)
    assert (np.ptp(poses, axis=0) != 0.0).any(axis=1).nonzero()[0].tolist() == [6]
