"""Laws of stops: what brakes better or stands farther away is never slower, and the like."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Capsule,
    FrameId,
    FramePoseVector,
    GeometryId,
    OccupiedCells,
    Sphere,
)
from drake_geom_ros.stopping import (
    RESOLUTION,
    Braking,
    BrakingError,
    RobotState,
    StoppingCheck,
    StoppingQuestion,
)
from truth.judging.stops import StoppingCell

BRAKING = Braking(decelerations=(2.0,), reaction_time=0.1)
seeds = st.integers(0, 10_000)
# What is proved by one more bound may end an edge earlier by as much as it is resolved.
SLACK = RESOLUTION
few = settings(max_examples=15, deadline=None)


@pytest.fixture(scope='module')
def cell():
    return StoppingCell(BRAKING)


@pytest.fixture(scope='module')
def each_joint():
    return StoppingCell(replace(BRAKING, category=0))


def scales(it, moment, **changes):
    return [stop.scale for stop in it.stops(moment, it.checked(**changes))]


@few
@given(seeds)
def test_more_deceleration_never_lowers_the_scale(cell, seed):
    moment = cell.moment(np.random.default_rng(seed))
    better = scales(cell, moment, braking=replace(BRAKING, decelerations=(4.0,)))
    for slow, fast in zip(scales(cell, moment), better, strict=True):
        assert fast >= slow - SLACK


@few
@given(seeds, st.sampled_from(['margin', 'max_speed', 'reaction_time']))
def test_larger_demands_never_raise_the_scale(cell, each_joint, seed, field):
    moment = cell.moment(np.random.default_rng(seed))
    for it in (cell, each_joint):
        more = {'margin': {'margin': 0.1}, 'max_speed': {'max_speed': 1.6}}.get(field)
        more = more or {'braking': replace(it.braking, reaction_time=0.3)}
        for lax, strict in zip(scales(it, moment), scales(it, moment, **more), strict=True):
            assert strict <= lax + SLACK


@few
@given(seeds, st.floats(0.0, 0.3), st.floats(0.0, 0.3))
def test_age_and_delay_never_raise_the_scale(cell, seed, age, delay):
    moment = cell.moment(np.random.default_rng(seed))
    later = cell.stops(moment, delay=delay)
    for now, then in zip(cell.stops(moment), later, strict=True):
        assert then.scale <= now.scale + SLACK
        assert then.reaction_time == pytest.approx(now.reaction_time + delay)
    for stop in cell.stops(moment, age=age):
        assert stop.reaction_time >= 0.1


def test_a_robot_that_stands_may_go(cell):
    moment = cell.moment(np.random.default_rng(1))
    still = moment._replace(velocities=np.zeros_like(moment.velocities))
    for stop in cell.stops(still):
        assert (stop.clear, stop.scale, stop.stopping_time, stop.linear) == (True, 1.0, 0.0, 0.0)


def test_moving_away_is_not_slowed_and_moving_near_is():
    it = StoppingCell(BRAKING, max_speed=0.0)
    moment = it.moment(np.random.default_rng(2))
    q, v = np.zeros_like(moment.positions), np.zeros_like(moment.velocities)
    v[it.joints.names.index('left::turn')] = 1.5
    # A limb beside the upright left arm, just beyond the margin, on the side it turns to.
    people = np.array([[5.0, 5, 0.5, 0, 0, 0, 1], [0.35, 0, 0.7, 0, 0, 0, 1]])
    towards = moment._replace(positions=q, velocities=v, people=people)
    left, _ = it.stops(towards)
    assert not left.clear
    assert it.names[left.id_A][0] == 'left'
    assert it.names[left.id_B] == ('person', 'arm', 'limb')
    assert left.scale < 1.0
    assert left.contact_time < left.stopping_time
    away, _ = it.stops(towards._replace(velocities=-v))
    assert (away.clear, away.scale, away.contact_time) == (True, 1.0, math.inf)


def test_a_stale_person_grows(cell):
    for seed in range(20):
        moment = cell.moment(np.random.default_rng(seed))
        now = cell.stops(moment)
        ages = np.zeros(len(cell.check.ids))
        ages[np.isin(cell.check.ids, cell.own['person'])] = 2.0
        states = states_of(cell, moment)
        old = cell.check.stops(states, ages)
        assert all(then.scale <= stop.scale + SLACK for then, stop in zip(old, now, strict=True))
        ages[:] = math.inf
        for stop in cell.check.stops(states, ages):
            assert stop.scale == 0.0 or not stop.pairs


def states_of(it, moment, **changes):
    states = []
    for arm, robot in zip(it.joints.arms, it.robots, strict=True):
        columns = [it.joints.names.index(name) for name in robot.joint_names]
        q, v = moment.positions[columns], moment.velocities[columns]
        states.append(RobotState(arm.X_WB, q, v)._replace(**changes))
    return states


@pytest.mark.parametrize(
    ('changes', 'trouble'),
    [
        ({'velocities': np.full(4, math.nan)}, 'nobody knows how fast .* move'),
        ({'positions': np.full(4, math.nan)}, 'nothing was heard of'),
        ({'age': math.inf}, 'stale, or of unknown age'),
        ({'V_PB': np.full(6, math.nan)}, 'the base of .* moves, or nobody knows'),
        ({'V_PB': np.ones(6)}, 'it does not brake'),
    ],
)
def test_what_is_not_known_proves_nothing(cell, changes, trouble):
    moment = cell.moment(np.random.default_rng(3))
    cell.stops(moment)
    (stop, _) = cell.check.stops(states_of(cell, moment, **changes))
    assert (stop.clear, stop.scale, stop.least_clearance) == (False, 0.0, -math.inf)
    assert stop.contact_time == 0.0
    assert re.search(trouble, stop.trouble)


def test_a_joint_that_nobody_brakes_must_stand(cell):
    moment = cell.moment(np.random.default_rng(4))
    moment = moment._replace(velocities=np.ones_like(moment.velocities))
    names = ('turn', 'bend', 'roll')
    question = StoppingQuestion(Braking(names, (2.0,)), cell.own['left'], None, 0.02, 1.0)
    check = StoppingCheck(cell.context, cell.robots, [question])
    (stop,) = cell.stops(moment, check)
    assert 'left::slide move' in stop.trouble
    v = np.where([name == 'left::slide' for name in cell.joints.names], 0.0, moment.velocities)
    (stop,) = cell.stops(moment._replace(velocities=v), check)
    assert stop.trouble == ''


def test_the_other_arm_must_brake_or_have_a_speed(cell):
    moment = cell.moment(np.random.default_rng(5))
    moment = moment._replace(velocities=np.ones_like(moment.velocities))
    for speed, troubled in ((0.0, True), (1.0, False)):
        question = StoppingQuestion(BRAKING, cell.own['left'], cell.own['right'], 0.0, speed)
        (stop,) = cell.stops(moment, StoppingCheck(cell.context, cell.robots, [question]))
        assert bool(stop.trouble) == troubled


def test_beyond_the_stopping_times_nothing_is_proved():
    braking = Braking(stopping_times=((0.5, 0.1), (1.0, 0.3)), reaction_time=0.05)
    it = StoppingCell(braking, max_speed=0.0)
    moment = it.moment(np.random.default_rng(6))
    far = np.array([[9.0, 9, 0.5, 0, 0, 0, 1]] * 2)
    q, v = np.zeros_like(moment.positions), np.zeros_like(moment.velocities)
    v[0] = 0.75
    calm = moment._replace(positions=q, velocities=v, people=far)
    left, _ = it.stops(calm)
    assert left.clear
    assert left.stopping_time == pytest.approx(0.05 + 0.2)
    fast, _ = it.stops(calm._replace(velocities=2.0 * v))
    assert not fast.clear
    assert fast.scale == pytest.approx(1.0 / 1.5)
    assert 'faster than stopping_times' in fast.trouble


def test_travel_and_speed_are_bounds_of_what_points_do(cell):
    rng = np.random.default_rng(8)
    for _ in range(30):
        moment = cell.moment(rng)
        stop, _ = cell.stops(moment)
        mine = cell.of_arm(0)[:-1]
        went = cell.along_path(moment, 0, 1.0)[0]
        poses = cell.joints.poses(moment.positions + moment.velocities * mine * went[:, :-1])
        left = np.isin(cell.joints.id_values, cell.robots[0].frame_ids)
        steps = np.linalg.norm(np.diff(poses[:, left, :3], axis=0), axis=2).sum(axis=0)
        assert steps.max() <= stop.stopping_distance + 1e-12
        assert stop.angular <= np.abs(moment.velocities).max() + 1e-12


def test_a_change_of_the_scene_is_noticed(cell):
    it = StoppingCell(BRAKING)
    moment = it.moment(np.random.default_rng(9))
    moment = moment._replace(people=np.array([[9.0, 9, 0.5, 0, 0, 0, 1]] * 2))
    before = it.stops(moment)
    frame = it.loaded.frames['person', 'trunk']
    poses = np.array([[0.0, 0.0, 0.5, 0, 0, 0, 1]])
    it.context.UpdateFramePoses(FramePoseVector.FromArrays([FrameId(frame.get_value())], poses))
    states = states_of(it, moment._replace(velocities=np.ones_like(moment.velocities)))
    after = it.check.stops(states)
    assert after[0].scale == 0.0
    assert len(before) == len(after) == 2


def test_what_cannot_matter_within_the_braking_time_is_counted():
    it = StoppingCell(BRAKING, max_speed=0.0)
    moment = it.moment(np.random.default_rng(13))
    far = np.array([[9.0, 9, 0.5, 0, 0, 0, 1]] * 2)
    q, v = np.zeros_like(moment.positions), np.zeros_like(moment.velocities)
    v[it.joints.names.index('left::roll')] = 0.1
    left, right = it.stops(moment._replace(positions=q, velocities=v, people=far))
    assert (left.clear, left.pairs, left.idle_joints) == (True, 0, 1)
    assert left.far_bodies > len(it.own['person'])
    assert (right.far_bodies, right.idle_joints) == (0, 0)  # it stands: it is about nothing
    near = far.copy()
    near[1, :3] = [0.35, 0.0, 0.7]
    v[:] = 0.0
    v[it.joints.names.index('left::turn')] = 1.5
    left, _ = it.stops(moment._replace(positions=q, velocities=v, people=near))
    assert (left.pairs > 0, left.idle_joints) == (True, 0)


@pytest.mark.parametrize('resolution', [0.0, -1.0, 2.0, math.nan])
def test_a_resolution_that_is_no_share_is_refused(cell, resolution):
    question = StoppingQuestion(BRAKING, cell.own['left'])
    with pytest.raises(ArgumentError, match='resolution='):
        StoppingCheck(cell.context, cell.robots, [question], resolution=resolution)


def test_a_finer_resolution_raises_the_scale_by_less_than_the_coarser_one(cell):
    rng = np.random.default_rng(14)
    question = StoppingQuestion(BRAKING, cell.own['left'], cell.own['person'], 0.02, 1.0)
    coarse, fine = (
        StoppingCheck(cell.context, cell.robots, [question], resolution=share)
        for share in (0.2, 0.002)
    )
    for _ in range(40):
        moment = cell.moment(rng)
        (rough,), (sharp,) = cell.stops(moment, coarse), cell.stops(moment, fine)
        assert rough.scale <= sharp.scale <= rough.scale + 0.2


def equal(stop, other):
    """Return whether two answers have the same bits."""
    return all(
        np.array_equal(a, b, equal_nan=True) if isinstance(a, (float, np.ndarray)) else a == b
        for a, b in zip(stop, other, strict=True)
    )


@pytest.mark.parametrize('category', [0, 1])
def test_an_answer_does_not_depend_on_what_was_asked_before(category):
    it, rng = StoppingCell(replace(BRAKING, category=category)), np.random.default_rng(10)
    used = it.checked()
    for _ in range(25):
        it.stops(it.moment(rng), used)
    for _ in range(25):
        moment = it.moment(rng)
        before, first = it.stops(moment, used), it.stops(moment, it.checked())
        assert all(equal(a, b) for a, b in zip(before, first, strict=True))


@pytest.mark.parametrize('category', [0, 1])
def test_a_rule_that_stands_alone_gets_the_answer_that_it_gets_among_others(category):
    it, rng = StoppingCell(replace(BRAKING, category=category)), np.random.default_rng(11)
    args = it.braking, it.own['left'], it.own['person'], it.margin, it.max_speed
    alone = StoppingCheck(it.context, it.robots, [StoppingQuestion(*args)])
    other = StoppingQuestion(it.braking, it.own['right'], None, it.margin, it.max_speed)
    both = StoppingCheck(it.context, it.robots, [other, StoppingQuestion(*args)])
    for _ in range(40):
        moment = it.moment(rng)
        assert equal(it.stops(moment, alone)[0], it.stops(moment, both)[1])


def test_after_a_change_of_shapes_answers_are_those_of_a_scene_packed_anew():
    it, rng = StoppingCell(BRAKING), np.random.default_rng(12)
    it.stops(it.moment(rng))
    preparations = []
    used = it.check
    prepare = used._prepare
    used._prepare = lambda: preparations.append(prepare())
    hand = next(id for id, key in it.names.items() if key[:2] == ('left', 'hand'))
    for turn in range(12):
        places = rng.uniform([-0.6, -0.4, 0.2], [0.6, 0.4, 1.0], (30, 3))
        it.change_shape(it.map, OccupiedCells(0.05, places))
        if turn % 3 == 0:
            it.change_shape(it.ids['person', 'arm', 'limb'], Capsule(*rng.uniform(0.02, 0.4, 2)))
        if turn % 4 == 0:
            it.change_shape(hand, Sphere(rng.uniform(0.02, 0.2)))
        moment = it.moment(rng)
        swapped, anew = it.stops(moment, used), it.stops(moment, it.checked())
        assert all(equal(a, b) for a, b in zip(swapped, anew, strict=True))
    assert not preparations
    it.change_shape(hand, Box(0.1, 0.1, 0.1))  # another type, so other kernels
    moment = it.moment(rng)
    swapped, anew = it.stops(moment, used), it.stops(moment, it.checked())
    assert all(equal(a, b) for a, b in zip(swapped, anew, strict=True))
    assert len(preparations) == 1


@pytest.mark.parametrize(
    ('joints', 'message'),
    [(('elbow',), 'means no joint'), (('x',), None), (('right::turn',), 'means no joint')],
)
def test_joints_that_are_not_of_the_set_are_refused(cell, joints, message):
    question = StoppingQuestion(Braking(joints, (1.0,)), cell.own['left'])
    if message is None:
        StoppingCheck(cell.context, cell.robots, [question])
        return
    with pytest.raises(BrakingError, match=message):
        StoppingCheck(cell.context, cell.robots, [question])
    (stop,) = StoppingCheck(cell.context, cell.robots, [question], may_wait=True).stops(
        states_of(cell, cell.moment(np.random.default_rng(0)))
    )
    assert message in stop.trouble


def test_a_question_that_waits_may_have_a_deceleration_for_each_joint(cell):
    question = StoppingQuestion(Braking(('elbow', 'wrist'), (1.0, 2.0)), cell.own['left'])
    check = StoppingCheck(cell.context, cell.robots, [question], may_wait=True)
    (stop,) = check.stops(states_of(cell, cell.moment(np.random.default_rng(0))))
    assert 'means no joint' in stop.trouble


def test_ways_are_of_the_scene_as_it_is_now():
    it = StoppingCell(BRAKING)
    moment = it.moment(np.random.default_rng(1))
    states = states_of(it, moment._replace(velocities=np.ones_like(moment.velocities)))
    it.check.stops(states)
    before = it.check.ways(states)
    limb, inspector = GeometryId(it.ids['person', 'arm', 'limb']), it.graph.model_inspector()
    (owner,) = (s for s in inspector.GetAllSourceIds() if inspector.BelongsToSource(limb, s))
    it.graph.RemoveGeometry(owner, limb, context=it.context)
    after = it.check.ways(states)
    assert all(len(way) for way in before)
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_set_that_nothing_moves_is_refused(cell):
    question = StoppingQuestion(BRAKING, cell.own['person'])
    with pytest.raises(ArgumentError, match='no geometry of set_a is moved'):
        StoppingCheck(cell.context, cell.robots, [question])
    with pytest.raises(ArgumentError, match='max_speed=-1'):
        StoppingQuestion(BRAKING, cell.own['left'], max_speed=-1.0)
