"""CheckMotion against closed forms: balls, planes, a rod; and what it refuses."""

import math

import numpy as np
import pytest
from geometry.queries.moving_bodies import Moving, pose
from oracles.motions import ball_and_plane, rod_and_ball, two_balls

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Capsule,
    Cylinder,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    HalfSpace,
    PoseError,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry import CollisionFilterDeclaration as Declaration
from drake_geom_ros.math import RigidTransform

TOLERANCE = 1e-6


def holds(check, time, tolerance=TOLERANCE, least=0.0):
    """Hold a contact against its exact first time."""
    assert check.outcome == 'contact'
    first, last = check.times
    assert first <= time <= last or math.isclose(time, last, abs_tol=1e-12)
    assert last - first <= tolerance
    assert check.last_free == first
    assert check.time == last
    assert check.distance + check.error_bound <= least


@pytest.mark.parametrize('least', [0.0, 0.05])
@pytest.mark.parametrize('interpolation', ['slerp', 'screw'])
@pytest.mark.parametrize('tolerance', [1e-3, 1e-6, 1e-9])
def test_a_ball_comes_down_on_a_plane(least, interpolation, tolerance):
    bodies = Moving([HalfSpace(), Sphere(0.1)])
    check = bodies.check(
        [pose(), pose(z=1.0)],
        [pose(), pose(x=3.0, z=-0.5, angle=0.0)],
        min_distance=least,
        interpolation=interpolation,
        time_tolerance=tolerance,
    )
    holds(check, ball_and_plane(1.0, 1.5, 0.1, least), tolerance, least)
    np.testing.assert_allclose(check.p_WCb[2] - check.p_WCa[2], check.distance, rtol=0, atol=1e-12)


def test_balls_on_lines():
    rng, bodies = np.random.default_rng(3), Moving([Sphere(0.1), Sphere(0.25)])
    outcomes = []
    for _ in range(60):
        starts, ends = rng.uniform(-1, 1, (2, 2, 3))
        least = float(rng.choice([0.0, 0.1]))
        apart, later = starts[1] - starts[0], ends[1] - ends[0]
        first = two_balls(apart, later - apart, (0.1, 0.25), least)
        check = bodies.check(
            [pose(*p) for p in starts], [pose(*p) for p in ends], min_distance=least
        )
        outcomes.append(check.outcome)
        if first is None:
            assert check.outcome == 'clear'
            assert check.times == (1.0, 1.0)
            assert check.lower_bound > least
        elif first == 0:
            assert (check.outcome, check.times) == ('contact', (0.0, 0.0))
        else:
            holds(check, first, least=least)
    assert {'clear', 'contact'} <= set(outcomes)


@pytest.mark.parametrize('bearing', [0.2, 1.0, 2.5])
def test_a_rod_turns_to_a_ball(bearing):
    bodies = Moving([Capsule(0.01, 2.0), Sphere(0.02)])
    along_x = [0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)]
    # About z by 2.8 rad, after the turn that brings the rod from z to x.
    turned = np.array([-math.sin(1.4), math.cos(1.4), math.sin(1.4), math.cos(1.4)])
    end = [0.0, 0.0, 0.0, *(turned * math.sqrt(0.5))]
    ball = pose(0.8 * math.cos(bearing), 0.8 * math.sin(bearing))
    check = bodies.check([[0, 0, 0, *along_x], ball], [end, ball])
    holds(check, rod_and_ball(2.8, bearing, 0.8, (0.01, 0.02), 0.0))


@pytest.mark.parametrize('shape', [Sphere(0.1), Box(0.2, 0.2, 0.2), Cylinder(0.1, 0.2)])
def test_grazing_at_exactly_the_least_distance_is_not_clear(shape):
    bodies = Moving([HalfSpace(), shape])
    asked = {'min_distance': 0.05}
    ends = [pose(), pose(x=1.0, z=0.15)]
    check = bodies.check([pose(), pose(x=-1.0, z=0.15)], ends, **asked)
    assert check.outcome != 'clear'
    assert check.last_free <= 1e-6
    above = bodies.check([pose(), pose(x=-1.0, z=0.15 + 1e-9)], ends, **asked)
    assert above.outcome == 'contact' or above.last_free > 0.99


def test_balls_that_graze_are_unknown_or_told_apart_by_a_hair():
    bodies = Moving([Sphere(0.1), Sphere(0.2)])
    for by, outcome in ((1e-12, 'clear'), (0.0, 'unknown'), (-1e-10, 'contact')):
        starts, ends = [pose(y=0.3 + by), pose(1.0)], [pose(2.0, 0.3 + by), pose(1.0)]
        check = bodies.check(starts, ends, time_tolerance=1e-4)
        assert check.outcome == outcome
        assert abs(check.last_free - (1.0 if outcome == 'clear' else 0.5)) < 1e-4


@pytest.mark.parametrize('tolerance', [1e-3, 1e-6, 1e-9, 1.0])
@pytest.mark.parametrize('first', [0.0, 0.25, 0.375, 0.5, 0.75])
def test_a_contact_at_a_time_that_is_halved_to_is_found(first, tolerance):
    """There the distance is 0 within rounding: neither clear nor certified to touch."""
    bodies = Moving([Box(0.5, 0.25, 0.125), Sphere(0.25)])
    begin = -0.5 - 2.0 * first
    check = bodies.check(
        [pose(), pose(x=begin)], [pose(), pose(x=begin + 2.0)], time_tolerance=tolerance
    )
    assert check.outcome == 'contact'
    assert check.times[0] <= first <= check.times[1] <= check.times[0] + tolerance
    assert check.distance + check.error_bound <= 0.0


def test_bodies_that_touch_at_the_start_and_part_are_left_out_where_that_is_asked_for():
    bodies = Moving([Box(0.5, 0.25, 0.125), Sphere(0.25)])
    starts = [pose(), pose(x=0.5)]
    for x in (0.5, 1.0):  # rests, and parts
        ends = [pose(), pose(x=x)]
        check = bodies.check(starts, ends)
        assert (check.outcome, check.last_free) == ('unknown', 0.0)
        left_out = bodies.check(starts, ends, ignore_start_contacts=True)
        assert (left_out.outcome, left_out.ignored) == ('clear', 1)
    into = bodies.check(starts, [pose(), pose(x=0.0)])
    assert into.outcome == 'contact'
    assert into.last_free == 0.0


def test_a_half_space_that_turns_sweeps_what_is_far():
    """A plane through the origin turns to a ball 5 m away by the arc of its height."""
    bodies = Moving([HalfSpace(), Sphere(0.1)])
    height = 1.0
    turn = math.asin(height / math.hypot(5.0, height)) - math.asin(0.1 / math.hypot(5.0, height))
    starts = [pose(), pose(x=5.0, z=height)]
    for angle, first in ((0.5, turn / 0.5), (0.9 * turn, None)):
        ends = [pose(axis=(0, -1, 0), angle=angle), starts[1]]
        check = bodies.check(starts, ends)
        if first is None:
            assert check.outcome == 'clear'
            lever = math.hypot(5.0, height)
            least = lever * math.sin(math.asin(height / lever) - angle) - 0.1
            assert 0.0 < check.lower_bound <= least
        else:
            holds(check, first)


def test_a_sheet_thinner_than_any_step_is_not_missed():
    bodies = Moving([Box(1.0, 1.0, 1e-9), Sphere(1e-6)])
    check = bodies.check([pose(), pose(z=100.0)], [pose(), pose(x=0.2, z=-300.0)])
    assert check.outcome == 'contact'
    assert abs(check.times[1] - 0.25) < 1e-6


def test_no_motion_whole_turns_and_kilometres():
    bodies = Moving([Box(0.2, 2.0, 0.2), Sphere(0.1)])
    here = [pose(), pose(x=0.5)]
    still = bodies.check(here, here)
    assert still.outcome == 'clear'
    assert abs(still.lower_bound - 0.3) < 1e-9
    half = bodies.check(here, [pose(angle=math.pi), pose(x=0.5)])
    assert half.outcome == 'contact'
    far = bodies.check(
        [pose(x=-1e6), pose(x=0.5)], [pose(x=1e6), pose(x=0.5)], time_tolerance=1e-9
    )
    assert far.outcome == 'contact'
    assert far.times[0] <= (1e6 + 0.3) / 2e6 <= far.times[1] + 1e-12


def test_contacts_at_the_start_are_told_or_left_out():
    bodies = Moving([Sphere(0.1), Sphere(0.1), Sphere(0.1)])
    starts = [pose(), pose(x=0.15), pose(x=3.0)]
    ends = [pose(), pose(x=2.0), pose(x=3.0)]
    check = bodies.check(starts, ends)
    assert (check.outcome, check.times, check.time) == ('contact', (0.0, 0.0), 0.0)
    assert abs(check.distance + 0.05) < 1e-12
    left = bodies.check(starts, ends, ignore_start_contacts=True)
    assert (left.outcome, left.ignored) == ('clear', 1)
    through = [pose(), pose(x=3.5), pose(x=3.0)]
    there = bodies.check(starts, through, ignore_start_contacts=True)
    assert (there.outcome, there.ignored) == ('contact', 1)
    at_end = bodies.check(
        [pose(x=9.0), pose(), pose(x=3.0)], [pose(x=9.0), pose(x=2.8), pose(x=3.0)]
    )
    assert at_end.outcome in ('contact', 'unknown')
    assert at_end.last_free > 1 - 2e-6


def test_a_budget_is_monotone_and_never_turns_unknown_into_clear():
    rng, bodies = np.random.default_rng(5), Moving([Box(1.0, 0.1, 0.1), Box(0.1, 1.0, 0.1)])
    for _ in range(20):
        starts, ends = bodies.states(rng, 2, 0.8)
        whole, last = bodies.check(starts, ends), -1.0
        for most in (1, 2, 4, 8, 16, 32, 64, whole.evaluations + 1):
            check = bodies.check(starts, ends, max_evaluations=most)
            assert check.evaluations <= most
            assert check.outcome in ('unknown', whole.outcome)
            assert check.last_free >= last
            last = check.last_free
        assert check.outcome == whole.outcome
        assert check.times == whole.times


def test_a_wide_tolerance_asks_for_any_contact():
    bodies = Moving([Sphere(0.1), Sphere(0.1)])
    starts, ends = [pose(), pose(x=1.0)], [pose(x=2.0), pose(x=1.0)]
    check = bodies.check(starts, ends, time_tolerance=1.0)
    assert check.outcome == 'contact'
    assert check.evaluations <= 4
    assert check.times[0] <= 0.4 <= check.times[1]


def nested(filtered=False, padding=0.0):
    """Return a graph of a ball on a tool on a hand, and a wall; frames, and the wall's way off."""
    graph = SceneGraph()
    source = graph.RegisterSource('nested')
    properties = ProximityProperties()
    if padding:
        properties.AddProperty('proximity', 'padding', padding)
    hand = graph.RegisterFrame(source, GeometryFrame('hand'))
    tool = graph.RegisterFrame(source, hand, GeometryFrame('tool'))
    ids = []
    for frame, shape in ((tool, Sphere(0.1)), (graph.world_frame_id(), HalfSpace())):
        body = GeometryInstance(RigidTransform(), shape, 'body')
        body.set_proximity_properties(properties)
        ids.append(graph.RegisterGeometry(source, frame, body))
    if filtered:
        both = GeometrySet(ids)
        graph.collision_filter_manager().Apply(Declaration().ExcludeWithin(both))
    context = graph.CreateDefaultContext()
    poses = {hand: RigidTransform([0, 0, 2.0]), tool: RigidTransform([0, 0, -0.5])}
    graph.get_source_pose_port(source).FixValue(context, FramePoseVector(poses))
    return graph, context, hand, tool


@pytest.mark.parametrize('padding', [0.0, 0.2])
def test_frames_carry_what_hangs_on_them(padding):
    graph, context, hand, tool = nested(padding=padding)
    query = graph.get_query_output_port().Eval(context)
    end = {hand: RigidTransform([0, 0, 1.0]), tool: RigidTransform([0, 0, -1.0])}
    check = query.CheckMotion(FramePoseVector(end))
    # The ball comes down from 1.5 to 0; it and the plane are padded.
    holds(check, ball_and_plane(1.5, 1.5, 0.1 + 2 * padding, 0.0))
    alone = query.CheckMotion(FramePoseVector({tool: RigidTransform([0, 0, -1.0])}))
    assert alone.outcome == 'clear'
    assert abs(alone.lower_bound - (0.9 - 2 * padding)) < 1e-9


def test_what_cannot_be_asked_is_refused():
    graph, context, hand, _ = nested()
    query = graph.get_query_output_port().Eval(context)
    end = FramePoseVector({hand: RigidTransform()})
    for asked, word in (
        ({'min_distance': -0.1}, 'min_distance'),
        ({'min_distance': math.nan}, 'min_distance'),
        ({'time_tolerance': 0.0}, 'time_tolerance'),
        ({'time_tolerance': math.nan}, 'time_tolerance'),
        ({'interpolation': 'linear'}, 'slerp, screw'),
        ({'max_evaluations': -1}, 'max_evaluations'),
        ({'accuracy': 'best'}, 'accuracy'),
    ):
        with pytest.raises(ArgumentError, match=word):
            query.CheckMotion(end, **asked)
    with pytest.raises(PoseError, match='not in this scene'):
        query.CheckMotion(FramePoseVector({FrameId(10**9): RigidTransform()}))
    with pytest.raises(ArgumentError, match='no frame'):
        query.CheckMotion(FramePoseVector())
    graph, context, hand, _ = nested(filtered=True)
    with pytest.raises(ArgumentError, match='could collide'):
        graph.get_query_output_port().Eval(context).CheckMotion(
            FramePoseVector({hand: RigidTransform()})
        )
    with pytest.raises(TypeError, match='outcome'):
        bool(query.CheckMotion(end))


def test_a_frame_without_a_pose_is_told():
    graph, _, hand, _ = nested()
    query = graph.get_query_output_port().Eval(graph.CreateDefaultContext())
    with pytest.raises(PoseError, match='never had a pose'):
        query.CheckMotion(FramePoseVector({hand: RigidTransform()}))


@pytest.mark.parametrize('tolerance', [1e-15, 5.9e-16, 1e-16, 1e-300])
@pytest.mark.parametrize('gap', [0.3, 0.6, 0.9, 1.0 / 3.0])
def test_a_tolerance_finer_than_times_counts_as_the_finest_one(tolerance, gap):
    """Spans of 2^-53 have no middle: they were halved until no memory was left."""
    bodies = Moving([Sphere(0.1), Sphere(0.1)])
    check = bodies.check(
        [pose(), pose(x=0.2 + gap)], [pose(x=1.0), pose(x=0.2 + gap)], time_tolerance=tolerance
    )
    holds(check, gap, tolerance=2.0**-40)
    assert check.evaluations < 500


@pytest.mark.parametrize('bound_tolerance', [math.inf, 1e-3])
def test_a_pair_left_out_is_in_no_answer(bound_tolerance):
    """Two balls overlap at the start and part; the nearest that counts is a third one."""
    bodies = Moving([Sphere(0.1), Sphere(0.1), Sphere(0.1)])
    starts = [pose(), pose(x=0.15), pose(x=-0.9)]
    ends = [pose(y=0.4), pose(x=0.15), pose(x=-0.9)]
    check = bodies.check(starts, ends, ignore_start_contacts=True, bound_tolerance=bound_tolerance)
    assert check.outcome == 'clear'
    assert check.ignored == 1
    left_out = bodies.query(starts).ComputePointPairPenetration()[0]
    assert {check.id_A, check.id_B} != {left_out.id_A, left_out.id_B}
    if bound_tolerance < math.inf:
        assert check.distance == pytest.approx(0.7, abs=1e-12)
        assert 0.7 - bound_tolerance <= check.lower_bound <= 0.7
    else:
        assert 0.0 < check.lower_bound <= 0.7


def test_a_pair_left_out_hides_nothing_of_what_rests():
    """Pairs that do not move against one another are left out likewise."""
    bodies = Moving([Sphere(0.1), Sphere(0.1), Sphere(0.1)])
    starts = [pose(), pose(x=0.15), pose(x=0.6)]
    ends = [pose(), pose(x=0.15), pose(x=0.6, y=0.3)]
    check = bodies.check(starts, ends, ignore_start_contacts=True, bound_tolerance=1e-3)
    assert (check.outcome, check.ignored) == ('clear', 1)
    assert check.distance == pytest.approx(0.25, abs=1e-12)
    assert 0.249 <= check.lower_bound <= 0.25
