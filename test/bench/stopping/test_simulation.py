"""Robots among people: the referee sees contacts, and robots whose stops are proved have none."""

import numpy as np
import pytest

from bench.stopping.room import HALF, PEOPLE, WALKS, Contact, People, Room
from bench.stopping.simulation import simulate
from bench.stopping.strategies import PlainDistance, Stoppable, Unrestricted


@pytest.fixture(scope='module')
def room():
    return Room()


def test_people_walk_everywhere_in_the_room_and_never_faster_than_declared():
    people, steps = People(np.random.default_rng(3)), []
    for k in range(20_000):
        people.walk(0.01 * k, 0.01)
        steps.append(people.places.copy())
    places = np.array(steps)
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=2) / 0.01
    assert speeds.max() <= WALKS + 1e-9
    assert speeds.max() > 0.95 * WALKS
    assert np.abs(places).max() <= HALF + 0.02
    assert places.min() < -0.9 * HALF
    assert places.max() > 0.9 * HALF


def test_the_referee_counts_contacts_of_robots_that_move_and_no_others(room):
    positions = np.repeat([[0.0, 0.0, 0.0, -2.0, -2.5]], 3, axis=0)  # the arm is upright
    places = np.full((3, PEOPLE, 2), 3.0)
    places[1:, 0] = 0.0, 1.2  # at the pedestal, and where the links reach over it
    places[2, 1] = -2.0, -2.5  # on the base
    moving, resting = np.ones((3, 2)), np.zeros((3, 2))
    found = room.contacts(positions, places, moving)
    assert {(c.robot, c.sample, c.other) for c in found} == {
        ('arm', 1, 'people'), ('arm', 2, 'people'), ('base', 2, 'people'),
    }  # fmt: skip
    assert room.contacts(positions, places, resting) == []
    resting[2, 1] = 0.01
    assert room.contacts(positions, places, resting) == [Contact('base', 2, 'people')]


def test_what_is_proved_to_stop_touches_nobody_and_goes_farther_than_by_distance_alone(room):
    runs = {
        kind: simulate(kind(room), room, 60.0, seed=1)
        for kind in (Unrestricted, PlainDistance, Stoppable)
    }
    assert runs[Unrestricted].contacts > 50
    assert runs[Stoppable].contacts == runs[PlainDistance].contacts == 0
    for robot, gone in runs[Stoppable].gone.items():
        assert runs[PlainDistance].gone[robot] < gone < runs[Unrestricted].gone[robot]


def test_a_proof_about_slower_people_is_found_out(room, monkeypatch):
    monkeypatch.setattr('bench.stopping.strategies.WALKS', 0.0)
    assert simulate(Stoppable(room), room, 60.0, seed=1).contacts > 0
