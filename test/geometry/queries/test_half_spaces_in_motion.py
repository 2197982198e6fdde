"""Motions of half spaces: what is called clear is clear at all times."""

import math

import numpy as np
import pytest
from geometry.queries.moving_bodies import Moving, pose
from oracles.planes import OVERTURNED, UPRIGHT, Planes

from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometrySet,
    HalfSpace,
    Sphere,
)

PLANES = HalfSpace(), HalfSpace()
WITH_BALL = *PLANES, Sphere(0.1)
X, Z = (1, 0, 0), (0, 0, 1)
FLOOR, ASIDE = pose(), pose(x=3.0, z=2.0)
CEILING = pose(z=4.0, axis=X, angle=np.pi)


def ceiling(z, turn=0.0, axis=Z):
    """Return an overturned half space at a height, turned further about an axis of the world."""
    half = 0.5 * turn
    x, y, z_axis = (math.sin(half) * np.array(axis)).tolist()
    # The quaternion of the half turn about x is (1, 0, 0, 0): the product in closed form.
    return [0.0, 0.0, z, math.cos(half), z_axis, -y, -x]


def check(start, end, shapes=WITH_BALL, **asked):
    return Moving(shapes).check(start, end, **asked)


def test_the_helper_turns_ceilings():
    moving = Moving(PLANES)
    for end, height in (
        (ceiling(4.0), 4.0),
        (ceiling(4.0, 1.0), 4.0),
        (ceiling(4.0, 1.0, X), -np.inf),
    ):
        assert moving.query([FLOOR, end]).half_space_gaps().distance[0] == pytest.approx(height)


@pytest.mark.parametrize('interpolation', ['slerp', 'screw'])
def test_a_motion_of_others_is_clear_between_floor_and_ceiling(interpolation):
    ends = [FLOOR, CEILING, pose(x=4.0, z=2.0, axis=Z, angle=1.0)]
    for standing in (True, False):
        moving = Moving(WITH_BALL)
        query = moving.query([FLOOR, CEILING, ASIDE])
        if standing:  # the two stay, and the motion names them not
            end = FramePoseVector.FromArrays(moving.ids[2:], np.array(ends[2:], float))
            found = query.CheckMotion(end, interpolation=interpolation)
            assert (found.outcome, found.lower_bound > 0.5) == ('clear', True)
        else:  # frames turn, and nobody says that these do not
            found = moving.check([FLOOR, CEILING, ASIDE], ends, interpolation=interpolation)
            assert found.outcome == 'unknown'
    straight = [FLOOR, CEILING, pose(x=4.0, z=2.0)]
    found = check([FLOOR, CEILING, ASIDE], straight, interpolation=interpolation)
    assert found.outcome == 'clear'


def test_a_pair_that_overlaps_at_the_start_is_a_contact_then():
    for second in (pose(z=-1.0), pose(axis=X, angle=1.0), ceiling(-0.5)):
        found = check([FLOOR, second], [FLOOR, pose(z=5.0)], PLANES)
        assert (found.outcome, found.times, found.time) == ('contact', (0.0, 0.0), 0.0)
        assert (found.id_A, found.id_B) == tuple(sorted((found.id_A, found.id_B)))
        assert found.distance + found.error_bound <= 0.0
        assert np.isnan(found.p_WCa).all()
        moving = Moving(PLANES)
        assert moving.query([FLOOR, second]).HasCollisions()


def test_planes_that_touch_within_rounding_are_not_known():
    touching = [pose(axis=X, angle=np.pi / 2), pose(x=5.0, axis=X, angle=-np.pi / 2)]
    found = check(touching, touching, PLANES)
    assert (found.outcome, found.times) == ('unknown', (0.0, 1.0))
    assert 0.0 <= abs(found.distance) <= found.error_bound < 1e-13
    # Where nothing is rounded a distance of 0 is one.
    assert check([FLOOR, ceiling(0.0)], [FLOOR, ceiling(0.0)], PLANES).outcome == 'contact'


@pytest.mark.parametrize('turn', [1e-12, 1e-3, 1.0, np.pi])
@pytest.mark.parametrize('axis', [X, Z])
def test_planes_that_turn_are_never_called_clear(turn, axis):
    found = check([FLOOR, ceiling(4.0)], [FLOOR, ceiling(4.0, turn, axis)], PLANES)
    assert (found.outcome, found.times) == ('unknown', (0.0, 1.0))
    assert found.distance == pytest.approx(4.0)


def test_planes_that_turn_until_they_are_opposed_again_are_never_called_clear():
    over = pose(z=4.0, axis=X, angle=-np.pi + 1e-9)  # a turn of the whole circle, nearly
    for end in (ceiling(4.0), over):
        found = check([pose(), ceiling(4.0, 0.5, X), ASIDE], [FLOOR, end, ASIDE])
        assert found.outcome == 'contact'
        found = check([FLOOR, CEILING, ASIDE], [pose(axis=X, angle=1.0), end, ASIDE])
        assert found.outcome == 'unknown'


def test_a_press_is_clear_while_its_planes_are_farther_apart_than_was_asked():
    start = [FLOOR, ceiling(4.0)]
    for height, asked, outcome in (
        (3.0, 0.0, 'clear'),
        (3.0, 3.5, 'unknown'),
        (0.001, 0.0, 'clear'),
        (0.0, 0.0, 'unknown'),
        (-0.5, 0.0, 'unknown'),
        (3.0, 5.0, 'contact'),
    ):
        found = check(start, [FLOOR, ceiling(height)], PLANES, min_distance=asked)
        assert found.outcome == outcome, (height, asked)
        if outcome == 'clear':
            assert found.lower_bound == pytest.approx(height)
        else:
            assert found.distance == pytest.approx(4.0)


def test_what_others_do_is_told_beside_it():
    # The ball falls into the floor; before that nothing is known of the planes.
    found = check([FLOOR, ceiling(4.0), ASIDE], [FLOOR, ceiling(4.0, 1.0), pose(x=3.0, z=-1.0)])
    assert found.outcome == 'unknown'
    assert found.times == (0.0, pytest.approx(1.9 / 3.0, abs=1e-5))
    assert found.evaluations > 0
    # It is in the floor at once.
    low = pose(x=3.0, z=0.05)
    found = check([FLOOR, ceiling(4.0), low], [FLOOR, ceiling(4.0, 1.0), low])
    assert (found.outcome, found.times[0], np.isfinite(found.p_WCa).all()) == (
        'contact',
        0.0,
        True,
    )


def test_contacts_of_the_start_are_ignored_if_that_is_asked_for():
    start, end = [FLOOR, pose(z=-1.0), pose(z=3.0)], [FLOOR, pose(z=-1.5), pose(z=2.0)]
    assert check(start, end).outcome == 'contact'
    found = check(start, end, ignore_start_contacts=True)
    assert (found.outcome, found.ignored) == ('clear', 1)
    # What was clear at the start is not ignored.
    found = check(
        [FLOOR, CEILING, ASIDE],
        [pose(axis=X, angle=1.0), CEILING, ASIDE],
        ignore_start_contacts=True,
    )
    assert (found.outcome, found.ignored) == ('unknown', 0)


def test_filters_leave_them_out():
    moving = Moving(WITH_BALL)
    planes = moving.graph.model_inspector().GetAllGeometryIds()[:2]
    manager = moving.graph.collision_filter_manager()
    manager.Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(planes)))
    start, end = [FLOOR, pose(z=-1.0), pose(z=3.0)], [FLOOR, pose(z=-2.0), pose(z=2.0)]
    assert moving.check(start, end).outcome == 'clear'
    everything = GeometrySet(moving.graph.model_inspector().GetAllGeometryIds())
    manager.Apply(CollisionFilterDeclaration().ExcludeWithin(everything))
    with pytest.raises(ArgumentError, match='carry no geometry which could collide'):
        moving.check(start, end)


def test_prepared_motions_see_where_what_rests_is_now():
    moving = Moving(WITH_BALL)
    query = moving.query([FLOOR, CEILING, ASIDE])
    end = FramePoseVector.FromArrays(moving.ids[2:], np.array([pose(x=5.0, z=2.0)]))
    for second, outcome in (
        (CEILING, 'clear'),
        (pose(z=-1.0), 'contact'),
        (ceiling(9.0), 'clear'),
    ):
        where = FramePoseVector.FromArrays(moving.ids[1:2], np.array([second], float))
        query._context.UpdateFramePoses(where)
        assert query.CheckMotion(end).outcome == outcome
        assert query.HasCollisions() == (outcome == 'contact')


def test_paddings_count():
    for padding, outcome in ((0.04, 'clear'), (0.06, 'contact')):
        poses = [(UPRIGHT, [0, 0, 0]), (OVERTURNED, [0, 0, 0.1])]
        planes = Planes(poses, padding=padding)
        end = FramePoseVector.FromArrays([planes.frames[1]], np.array([[0, 0, 0.3, 1, 0, 0, 0.0]]))
        assert planes.query.CheckMotion(end).outcome == outcome


@pytest.mark.parametrize('seed', range(30))
def test_no_state_of_a_clear_motion_collides(seed):
    rng = np.random.default_rng(seed)
    moving = Moving(WITH_BALL)

    def some():
        kinds = [ceiling(*rng.uniform(-1, 2, 1)), pose(z=rng.uniform(-1, 1))]
        kinds += [ceiling(1.0, rng.uniform(-3, 3), (X, Z)[rng.integers(2)])]
        return kinds[rng.choice(3, p=[0.7, 0.15, 0.15])]

    start, end = [FLOOR, some(), pose(x=1.0, z=0.5)], [FLOOR, some(), pose(x=2.0, z=0.5)]
    found = moving.check(start, end)
    ends = [moving.query(poses).HasCollisions() for poses in (start, end)]
    assert not (found.outcome == 'clear' and any(ends))
    if ends[0]:
        assert found.outcome == 'contact'
