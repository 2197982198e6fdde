"""Whole scenes: their pairs have a truth, which the query of the whole scene meets."""

import numpy as np
import pytest

from bench.accuracy.scenes import BATCH, NEAR, SCENES, heap
from truth.judging.asking import PENETRATION, SIGNED_DISTANCE


@pytest.mark.parametrize('name', SCENES)
def test_a_scene_is_what_its_name_says(name):
    scene = SCENES[name]()
    assert scene.name == name
    for body in scene.bodies:
        np.testing.assert_allclose(body.R @ body.R.T, np.eye(3), rtol=0, atol=1e-14)


def test_answers_of_the_scene_are_those_of_its_pairs():
    subject = heap(25)
    batch = next(subject.batches(0))
    assert 0 < len(batch) <= BATCH
    for pair in batch:
        exact = subject.answers(pair, SIGNED_DISTANCE)[-1]
        assert abs(exact.distance - pair.distance) <= exact.error_bound
        overlap = subject.answers(pair, PENETRATION)[-1]
        assert (overlap is not None) == (pair.distance < -1e-14)


def test_the_timed_scene_turns_as_a_whole():
    subject = heap(25)
    timed, pairs = subject.timed(SIGNED_DISTANCE, [])
    assert pairs == timed.found(NEAR) > 0
    before = sorted(timed._ask(SIGNED_DISTANCE, 'exact', np.zeros((0, 3)))[0])
    timed.cycle(SIGNED_DISTANCE, 'exact', np.random.default_rng(5), 1)
    after = sorted(timed._ask(SIGNED_DISTANCE, 'exact', np.zeros((0, 3)))[0])
    np.testing.assert_allclose(before, after, rtol=0, atol=1e-12)
