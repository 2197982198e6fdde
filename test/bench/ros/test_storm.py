"""The order of faults is that of the seed, and a scene that is not intact is told."""

import resource
import subprocess
import sys

import numpy as np
import pytest

from bench.ros.faults import limits, order
from bench.ros.storm import Scene


class Site:
    """Stands for nodes; what is random comes from it."""

    random = None


@pytest.fixture
def drawn(monkeypatch):
    """Return a function that does faults, which only draw, and returns what they drew."""

    def make(name):
        def fault(site):
            seen.append((name, site.random.random()))
            return name if name == 'bad' else ''

        fault.__name__ = name
        return fault

    seen = []
    monkeypatch.setattr(order, 'FAULTS', tuple(map(make, ('good', 'fine', 'bad'))))

    def do(count, seed, first=1):
        seen.clear()
        faults = order.Faults(Site(), seed, first)
        problems = [problem for _ in range(count) for problem in faults.do_one()]
        assert faults.counts.total() == count
        return list(seen), problems

    return do


def test_a_fault_can_be_done_again_by_its_number(drawn):
    whole, problems = drawn(50, seed=3)
    assert drawn(50, seed=3) == (whole, problems)
    assert drawn(50, seed=4)[0] != whole
    assert drawn(1, seed=3, first=17)[0] == whole[16:17]
    bad = [k for k, (name, _) in enumerate(whole, 1) if name == 'bad']
    assert problems == [f'bad, fault {k}: bad' for k in bad]
    assert bad


def test_an_answer_that_does_not_come_is_a_problem(monkeypatch):
    def silent(site):
        raise TimeoutError('waited for ever')

    monkeypatch.setattr(order, 'FAULTS', (silent,))
    assert order.Faults(Site(), 0).do_one() == ['silent, fault 1: waited for ever']


IDS = np.array([[1, 2], [1, 3]], dtype=np.uint64)
BEFORE = Scene({'sources': ['s']}, (3, 7), IDS, np.array([1.0, 2.0]), np.array([1e-9, 1e-9]))


def test_the_same_scene_differs_in_nothing():
    assert BEFORE.difference(BEFORE) == ''
    # Answers may differ within their bounds.
    assert BEFORE.difference(BEFORE._replace(distances=np.array([1.0, 2.0 + 1e-9]))) == ''


@pytest.mark.parametrize(
    ('changed', 'said'),
    [
        ({'entries': {'sources': ['s', 't']}}, 'saved scene'),
        ({'filters': (3,)}, 'filters were'),
        ({'ids': IDS[:1]}, 'the pairs are others: 2 before, 1 now'),
        ({'distances': np.array([1.0, 2.1])}, 'the distance of [1 3] differs by 0.1'),
    ],
)
def test_another_scene_is_told(changed, said):
    assert said in BEFORE.difference(BEFORE._replace(**changed))


@pytest.mark.processes
@pytest.mark.skipif(not hasattr(resource, 'prlimit'), reason='limits of others are of Linux')
def test_a_limit_of_a_process_is_put_back():
    process = subprocess.Popen([sys.executable, '-c', 'input()'], stdin=subprocess.PIPE)
    before = resource.prlimit(process.pid, resource.RLIMIT_NOFILE)
    with limits.limited(process.pid, resource.RLIMIT_NOFILE, 7):
        assert resource.prlimit(process.pid, resource.RLIMIT_NOFILE) == (7, before[1])
    assert resource.prlimit(process.pid, resource.RLIMIT_NOFILE) == before
    process.communicate(b'\n')
