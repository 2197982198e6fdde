"""A peer in a process of its own: answers, crashes and time limits. python-fcl is always here."""

import numpy as np
import pytest

from bench.accuracy.cases import ShapePair
from bench.accuracy.peer_process import (
    ANSWERED,
    MISSED,
    MOST_LOST,
    NOT_ASKED,
    UNSUPPORTED,
    PeerProcess,
)
from bench.accuracy.samples import stream
from drake_geom_ros.cross_check.lost_process import CRASH, EXCEPTION, HANG
from truth.judging.asking import PENETRATION, SIGNED_DISTANCE


def pairs(case, *configurations):
    rng = stream(case.name, 0)
    return [case.sample(configuration, rng) for configuration in configurations]


@pytest.fixture(scope='module')
def fcl():
    process = PeerProcess('python-fcl')
    yield process
    process.close()


def test_it_answers_and_is_timed(fcl):
    apart, deep = pairs(ShapePair('Box', 'Box'), 'apart', '2 cm deep')
    fcl.begin()
    fcl.give([apart, deep])
    assert fcl.answer(PENETRATION, None, 0).verdict == MISSED
    outcome = fcl.answer(PENETRATION, None, 1)
    assert outcome.verdict == ANSWERED
    assert outcome.distance == pytest.approx(deep.distance, rel=0.1)
    seconds = fcl.seconds(PENETRATION, None, [0, 1], np.array([np.eye(3)] * 2))
    assert 0.0 < seconds < 1.0


def test_it_may_crash_and_is_given_up_after_some(fcl):
    fcl.begin()
    fcl.give(pairs(ShapePair('Sphere', 'HalfSpace'), *['2 mm apart'] * (MOST_LOST + 1)))
    verdicts = [fcl.answer(SIGNED_DISTANCE, None, k).verdict for k in range(MOST_LOST + 1)]
    assert verdicts == [CRASH] * MOST_LOST + [NOT_ASKED]
    # The other query goes on, in a process that knows the samples.
    assert fcl.answer(PENETRATION, None, 0).verdict == MISSED


def test_a_setting_that_there_is_not_is_unsupported(fcl):
    fcl.begin()
    fcl.give(pairs(ShapePair('Box', 'Box'), 'apart'))
    assert fcl.answer(PENETRATION, 1e-9, 0).verdict == UNSUPPORTED
    assert fcl.answer('volume', None, 0).verdict in (UNSUPPORTED, EXCEPTION)


def test_what_takes_too_long_hangs():
    process = PeerProcess('python-fcl', limit=0.0)
    process.begin()
    process.give(pairs(ShapePair('Convex', 'Convex', 500), 'apart'))
    assert process.answer(PENETRATION, None, 0).verdict == HANG
    process.close()
