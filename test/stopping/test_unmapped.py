"""Stops before things that are no geometry, known by their distance from bodies alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stopping.test_laws_of_stops import states_of

from drake_geom_ros.geometry import FramePoseVector, GeometryId, QueryObject
from drake_geom_ros.stopping import (
    RESOLUTION,
    Braking,
    StoppingCheck,
    StoppingQuestion,
    Unmapped,
)
from truth.judging.stops import StoppingCell

BRAKING = Braking(decelerations=(2.0,), reaction_time=0.1)
seeds = st.integers(0, 10_000)
few = settings(max_examples=25, deadline=None)


class Thing:
    """The left arm of a cell, and a pole that is a geometry, or known by its distance alone."""

    def __init__(self, category=1, with_base=False):
        braking = replace(BRAKING, category=category)
        self.cell = StoppingCell(braking, max_speed=0.5)
        self.left = self.cell.own['left']
        self.wall, self.pole = (self.cell.ids['things', 'world', n] for n in ('wall', 'pole'))
        self.beside_wall = self.check([self.wall])
        self.beside_both = self.check([self.wall, self.pole])

    def check(self, set_b):
        question = StoppingQuestion(self.cell.braking, self.left, set_b, 0.02, 0.5)
        return StoppingCheck(self.cell.context, self.cell.robots, [question])

    def stop(self, check, moment, unmapped=None):
        """Return the answer about a moment, with rows of what is beside bodies."""
        asked = []

        def find(reach):
            asked.append(reach)
            return [unmapped]

        self.cell.stops(moment, check)  # it poses the bodies
        finding = None if unmapped is None else find
        (stop,) = check.stops(states_of(self.cell, moment), find_unmapped=finding)
        assert len(asked) == (unmapped is not None)
        return stop

    def rows(self, moment):
        """Return what is known of the pole where it is no geometry; the wall stands for it."""
        self.cell.stops(moment)
        joints = self.cell.joints
        links = FramePoseVector.FromArrays(
            joints.id_values, joints.poses(moment.positions[None])[0]
        )
        self.cell.context.UpdateFramePoses(links)
        query, rows = QueryObject(self.cell.context), []
        for body in self.left:
            pair = GeometryId(body), GeometryId(self.pole)
            found = query.ComputeSignedDistancePairClosestPoints(*pair)
            rows.append(Unmapped(body, self.wall, found.distance, found.error_bound))
        return rows


@pytest.fixture(scope='module')
def things():
    return {category: Thing(category) for category in (0, 1)}


@few
@given(seeds, st.sampled_from([0, 1]))
def test_a_distance_alone_never_proves_more_than_the_thing_itself(things, seed, category):
    it = things[category]
    moment = it.cell.moment(np.random.default_rng(seed))
    truth = it.stop(it.beside_both, moment)
    told = it.stop(it.beside_wall, moment, it.rows(moment))
    assert told.scale <= truth.scale + RESOLUTION
    assert truth.clear or not told.clear


@few
@given(seeds, st.floats(0.0, 0.5))
def test_what_is_nearer_never_raises_the_scale(things, seed, nearer):
    it = things[1]
    moment = it.cell.moment(np.random.default_rng(seed))
    rows = it.rows(moment)
    near = [row._replace(distance=row.distance - nearer) for row in rows]
    far, close = (it.stop(it.beside_wall, moment, each) for each in (rows, near))
    assert close.scale <= far.scale
    assert close.least_clearance <= far.least_clearance
    alone, without = it.stop(it.beside_wall, moment, []), it.stop(it.beside_wall, moment)
    np.testing.assert_equal(alone, without)


def test_a_thing_matters_from_the_way_of_its_body_on(things):
    it = things[1]
    moment = it.cell.moment(np.random.default_rng(2))
    q, v = np.zeros_like(moment.positions), np.zeros_like(moment.velocities)
    v[it.cell.joints.names.index('left::turn')] = 0.5
    moment = moment._replace(positions=q, velocities=v)
    alone = it.stop(it.beside_wall, moment, [])
    assert alone.clear
    (finger,) = (key for key in it.left if it.cell.names[key][1] == 'finger')
    # All of it turns about one axis: it is certified to go this far, and the pole none.
    needed = alone.stopping_distance + 0.02
    beyond = it.stop(it.beside_wall, moment, [Unmapped(finger, it.pole, needed + 1e-6)])
    assert (beyond.clear, beyond.scale) == (True, 1.0), 'the pole is not of set_b'
    both = it.check([it.wall, it.pole])
    assert it.stop(both, moment, [Unmapped(finger, it.pole, needed + 1e-6)]).clear
    short = it.stop(both, moment, [Unmapped(finger, it.pole, needed - 1e-6)])
    assert not short.clear
    assert 0.9 < short.scale < 1.0
    assert (short.id_A, short.id_B) == tuple(sorted((finger, it.pole)))
    half = it.stop(both, moment, [Unmapped(finger, it.pole, 0.5 * needed)])
    assert 0.0 < half.scale < short.scale


def test_of_a_body_that_nobody_sees_nothing_is_proved_while_it_moves(things):
    it = things[1]
    moment = it.cell.moment(np.random.default_rng(2))
    q, v = np.zeros_like(moment.positions), np.zeros_like(moment.velocities)
    base, finger = (
        next(key for key in it.left if it.cell.names[key][1] == link)
        for link in ('base', 'finger')
    )
    still = moment._replace(positions=q, velocities=v)
    moving = still._replace(velocities=np.where(np.arange(len(v)) == 0, 0.5, v))
    assert it.cell.joints.names[0] == 'left::turn'
    unseen = it.stop(it.beside_wall, moving, [Unmapped(finger, it.wall)])
    assert (unseen.clear, unseen.scale) == (False, 0.0)
    assert 'out of the sight of all sensors' in unseen.trouble
    assert unseen.stopping_distance > 0.0
    # The base does not move with its joints, and what stands needs no stop.
    for it_moves, body in ((moving, base), (still, finger)):
        assert it.stop(it.beside_wall, it_moves, [Unmapped(body, it.wall)]).clear
