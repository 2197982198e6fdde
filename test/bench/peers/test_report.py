"""Verdicts on made-up times: targets that are met, missed, or not set."""

import pytest

from bench.peers import report
from bench.peers.report import Measurement
from bench.peers.timing import Taken


def taken(microseconds, found=3):
    return Taken([1e-6 * microseconds] * 5, [1e-6] * 5, [found] * 5)


def measurement(scene='spheres-200', query='penetration', **microseconds):
    names = {'mujoco': 'MuJoCo', 'coal': 'Coal'}
    return Measurement(
        scene, 'robot', query, {names.get(n, n): taken(t) for n, t in microseconds.items()}
    )


@pytest.mark.parametrize(
    ('scene', 'query', 'bar'),
    [
        ('spheres-50', 'penetration', 2),
        ('mixed-1000', 'penetration', 2),
        ('arms', 'candidates', 2),
        ('arms', 'near', 3),
        ('arms', 'all', 3),
        ('hulls-20', 'points', 15),
        ('arms', 'has_collisions', 1),
        ('arms/apart', 'has_collisions', 1),
    ],
)
def test_a_bar_is_met_from_its_ratio_on(scene, query, bar):
    for pydrake, met in ((10 * bar + 0.1, True), (10 * bar - 0.1, False)):
        verdict = measurement(scene, query, ours=10, pydrake=pydrake).verdicts()[0]
        assert verdict == ('pydrake', bar, pytest.approx(pydrake / 10), met)


@pytest.mark.parametrize(('mujoco', 'met'), [(10.1, True), (9.9, False)])
def test_after_a_pause_penetrations_are_to_be_no_slower_than_those_of_mujoco(mujoco, met):
    taken_by = {'ours': taken(10), 'pydrake': taken(5), 'MuJoCo': taken(mujoco)}
    m = Measurement('arms', report.ONE_BY_ONE, 'penetration', taken_by)
    assert m.verdicts() == [('MuJoCo', 1.0, pytest.approx(mujoco / 10), met)]
    assert report.summary([m])[0] == f'{int(met)} of 1 targets met'


def test_a_tenth_of_the_bodies_has_no_target():
    assert measurement('mixed-1000/tenth', ours=10, pydrake=1).verdicts() == []


def test_mujoco_is_compared_in_penetration_alone():
    both = {'ours': 10, 'pydrake': 50, 'mujoco': 9}
    assert measurement(**both).verdicts()[1] == ('MuJoCo', 1.0, pytest.approx(0.9), False)
    assert len(measurement(query='near', **both).verdicts()) == 1


def test_a_library_that_was_left_out_has_no_time_and_a_reason():
    libraries = {'ours': taken(1), 'pydrake': Taken(left_out='raised: no')}
    m = Measurement('arms', 'jump', 'all', libraries)
    assert report.cells(m)[4] == '-'
    assert m.verdicts() == []
    assert report.summary([m]) == [
        '0 of 0 targets met',
        'arms jump all: pydrake left out: raised: no',
    ]


def test_the_summary_tells_what_was_missed_and_where_results_differ():
    slow = measurement('arms', 'near', ours=10, pydrake=20)
    other = Measurement('arms', 'slow', 'all', {'ours': taken(1, 4), 'pydrake': taken(9, 5)})
    assert report.summary([slow, other]) == [
        '1 of 2 targets met',
        'missed: arms robot near: 2x pydrake, to be 3x',
        'arms slow all: another number of results than pydrake in 5 of 5 cycles',
    ]


def test_the_mean_counts_and_the_worst_cycle_is_told():
    seconds = [1e-6] * 98 + [101e-6] * 2
    ours = Taken(seconds, [1e-6] * 100, [3] * 100)
    pydrake = Taken([9e-6] * 100, found=[3] * 100)
    m = Measurement('arms', 'robot', 'near', {'ours': ours, 'pydrake': pydrake})
    assert m.times('ours') == '1 / 3 / 101'
    assert m.ratio('pydrake') == pytest.approx(3.0)
    assert report.summary([m]) == ['1 of 1 targets met']
