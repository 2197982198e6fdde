"""Whole scenes: their pairs have a truth, which the query of the whole scene meets."""

from bench.accuracy.scenes import BATCH, heap
from truth.judging.asking import PENETRATION, SIGNED_DISTANCE


def test_answers_of_the_scene_are_those_of_its_pairs():
    subject = heap(25)
    batch = next(subject.batches(0))
    assert 0 < len(batch) <= BATCH
    for pair in batch:
        exact = subject.answers(pair, SIGNED_DISTANCE)[-1]
        assert abs(exact.distance - pair.distance) <= exact.error_bound
        overlap = subject.answers(pair, PENETRATION)[-1]
        assert (overlap is not None) == (pair.distance < -1e-14)
