"""Contact surfaces where faces lie just where pressures are equal: whichever is M, and close by.

Areas may jump there: then they are those of one side, or between them.
"""

import numpy as np
import pytest
from oracles.contact_scenes import Body, query_of

from truth.bodies.random_bodies import random_rotation
from truth.surfaces.nearby import HARDER, is_alone, numbers_of, poses_near

BOX, LONG = Body('Box', (1.0, 1.0, 1.0), 1e5), Body('Box', (2.0, 1.0, 1.0), 1e5)
CUBE = Body('Convex', tuple((x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)), 1e5)
UPRIGHT = np.eye(3)
# Two bodies, and where the second is in the first: turned, and shifted.
AXES = {
    'xyz': UPRIGHT,
    'yzx': np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    'xzy': np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
TIES = {
    'like boxes flush at four sides': (BOX, BOX, 'xyz', (0.0, 0.0, 0.7)),
    'like boxes flush at two sides': (BOX, BOX, 'xyz', (0.0, 0.25, 0.5)),
    'a box flush on a longer one': (BOX, LONG, 'xyz', (0.0, 0.0, 0.7)),
    'a box flush in a longer one': (BOX, LONG, 'xyz', (0.3, 0.0, 0.0)),
    'capsules': (
        Body('Capsule', (1.0, 1.0), 1e5, 4.0),
        Body('Capsule', (1.0, 1.0), 2e5, 4.0),
        'yzx',
        (0.5, 0.0, 0.0),
    ),
    'a cylinder in a cube': (CUBE, Body('Cylinder', (2.0, 2.0), 1e5, 4.0), 'yzx', (0.5, 0.0, 0.5)),
    'a ball in an ellipsoid': (
        Body('Ellipsoid', (0.5, 1.0, 1.0), 1e5, 0.5),
        Body('Sphere', (1.0,), 1e5, 0.5),
        'xzy',
        (-0.25, 0.0, -0.25),
    ),
    'like balls': (Body('Sphere', (1.0,), 1e5, 2.0),) * 2 + ('xzy', (0.5, 0.5, 0.0)),
}


def numbers(bodies, poses, order=(0, 1)):
    query = query_of(bodies, poses, order=order)[0]
    return numbers_of(query.ComputeContactSurfacesWithFallback()[0], 1.0, 1e5)


def placed(name, R, p):
    """Return two bodies, and their poses as they are in a tie, the first one at a pose."""
    first, second, turn, offset = TIES[name]
    return [first, second], [(R, p), (R @ AXES[turn], R @ np.array(offset) + p)]


def places():
    random = np.random.default_rng(7)
    yield UPRIGHT, np.zeros(3)
    for _ in range(4):
        yield random_rotation(random), random.normal(size=3)


@pytest.mark.parametrize('name', TIES)
def test_which_body_is_m_changes_nothing(name):
    for place in places():
        bodies, poses = placed(name, *place)
        mine, other = numbers(bodies, poses), numbers(bodies, poses, (1, 0))
        assert mine[0] > 0.0
        np.testing.assert_array_equal(np.concatenate((other[:4], -other[4:])), mine)


@pytest.mark.parametrize('name', TIES)
def test_a_surface_is_what_it_is_close_by(name):
    random = np.random.default_rng(8)
    for place in places():
        bodies, (first, second) = placed(name, *place)
        near = [(bodies, [first, each]) for each in poses_near(second, 1.0, random)]
        for factor in (1.0 - HARDER, 1.0 + HARDER):
            modulus = factor * bodies[0].modulus
            near.append(([bodies[0]._replace(modulus=modulus), bodies[1]], [first, second]))
        around = np.array([numbers(*each) for each in near])
        found = numbers(bodies, [first, second])
        assert not is_alone(found, around), (found, around.min(axis=0), around.max(axis=0))


def test_like_boxes_flush_at_four_sides_press_once():
    # From above the pressures are 2 E times the distance from the faces: 0.15 m at the middle, and
    # falling to 0 along the rim. On either side of the rim's wedges, in which both are the same,
    # the surface may go on, but not on both.
    d, modulus = 0.15, 1e5
    volume = (1.0 - 2.0 * d) ** 2 * d + (2.0 - 4.0 * d) * d**2 + 4.0 * d**3 / 3.0
    for R, p in places():
        force = modulus * numbers(*placed('like boxes flush at four sides', R, p))[4:7]
        expected = -2.0 * modulus * volume * R[:, 2]
        np.testing.assert_allclose(force, expected, rtol=0.0, atol=1e-9 * modulus)


def test_numbers_are_alone_only_out_of_the_range_around_them():
    around = np.array([np.zeros(10), np.ones(10)])
    assert not is_alone(np.full(10, 0.5), around)
    assert not is_alone(np.full(10, 1.0), around)
    assert is_alone(np.append(np.full(9, 0.5), 1.1), around)
    assert is_alone(np.append(np.full(9, 0.5), -0.1), around)
