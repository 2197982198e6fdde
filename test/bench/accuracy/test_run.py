"""The verdict of a run: right answers pass, and bounds that break a promise are named."""

import numpy as np
import pytest

from bench.accuracy import cases, run
from bench.accuracy.run import VIOLATED, Request
from drake_geom_ros.geometry import SignedDistanceResults


def tiny(folder, *patterns, peers=()):
    return Request(folder, peers, patterns or ('Sphere-Box',), quick=True, samples=1)


@pytest.fixture
def said():
    return []


def test_right_answers_pass(tmp_path, said):
    assert run.run(tiny(tmp_path), said.append) == 0
    assert said[-1].startswith('all ')
    assert not any(line.startswith('WRONG') for line in said)


def test_a_bound_below_the_error_is_caught_and_named(tmp_path, said, monkeypatch):
    def lying(*arguments):
        return [
            answer and answer._replace(distance=answer.distance + 2 * answer.error_bound)
            for answer in ours(*arguments)
        ]

    ours = cases.certified
    monkeypatch.setattr(cases, 'certified', lying)
    assert run.run(tiny(tmp_path), said.append) == VIOLATED
    assert any(line.startswith('WRONG: Sphere-Box, signed_distance, exact') for line in said)
    assert (tmp_path / 'README.md').exists()


def test_a_bound_wider_than_the_promise_is_caught(tmp_path, said, monkeypatch):
    """What a query's own ``breaks_promise`` says, and no other measure of it."""
    broken = np.ones(1, dtype=bool)
    monkeypatch.setattr(SignedDistanceResults, 'breaks_promise', lambda found: broken)
    assert run.run(tiny(tmp_path), said.append) == VIOLATED
    (told, *_) = [line for line in said if line.startswith('WRONG')]
    assert told.endswith('m, wider than promised')
