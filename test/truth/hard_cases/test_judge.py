"""What passes and what does not, on the unit cubes of fcl#508 and on spheres."""

import numpy as np
import pytest
from oracles.hard_cases.construct import body, case

from drake_geom_ros.cross_check.lost_process import QuestionOutcome
from truth.hard_cases.judge import judged
from truth.peers import PairAnswer, Unsupported

X = (1, 0, 0)
APART = case('', body('Box', (1, 1, 1)), body('Box', (1, 1, 1), None, (0, 4, 0)))
DEEP = case('', body('Sphere', (1,)), body('Sphere', (1,), None, (1.5, 0, 0)))
TOUCHING = case('', body('Sphere', (1,)), body('Sphere', (1,), None, (2, 0, 0)))
A, B, N = np.array([0.0, 0.5, 0]), np.array([0.0, 3.5, 0]), np.array([0.0, -1, 0])


def verdict(one, query, *answer):
    value = PairAnswer(*answer) if answer else None
    return judged(one, query, QuestionOutcome('answer', value))


@pytest.mark.parametrize(
    ('answer', 'expected', 'text'),
    [
        ((3.0, N, A, B), 'pass', ''),
        ((3.0, None, None, None), 'pass', ''),
        ((3.0003, N, A, B), 'pass', ''),
        ((3.16228, N, A, B), 'wrong', '3.16228 for 3'),
        ((float('nan'), N, A, B), 'NaN', 'distance'),
        ((-1.8e308, N, A, B), 'NaN', 'distance'),
        ((3.0, N * np.nan, A, B), 'NaN', 'normal or witness'),
        ((3.0, N * 0, A, B), 'wrong', 'normal of length 0'),
        ((3.0, -N, A, B), 'wrong', 'normal (-0, 1, -0)'),
        ((3.0, N, A, A), 'wrong', 'witness points off by 3 m'),
        ((3.0, N, np.add(A, X), np.add(B, X)), 'wrong', 'witness points off by 0.5 m'),
    ],
)
def test_distances(answer, expected, text):
    found = verdict(APART, 'signed_distance', *answer)
    assert (found.verdict, found.text) == (expected, text)


def test_contacts():
    x = np.array([-1.0, 0, 0])
    assert verdict(DEEP, 'penetration').text == 'no contact for -0.5'
    assert verdict(DEEP, 'penetration', -0.5, x, None, None).verdict == 'pass'
    assert verdict(DEEP, 'penetration', 0.5, x, None, None).verdict == 'wrong'
    assert verdict(APART, 'penetration').verdict == 'pass'
    assert verdict(APART, 'penetration', -0.1, x, None, None).text == 'contact for 3'
    for answer in ((), (-1e-9, x, None, None), (1e-9, x, None, None)):
        assert verdict(TOUCHING, 'penetration', *answer).verdict == 'pass'


def test_other_ends():
    assert judged(DEEP, 'penetration', QuestionOutcome('crash', 'signal 6')) == (
        'crash',
        'signal 6',
        0.0,
    )
    assert judged(DEEP, 'penetration', QuestionOutcome('hang', '2 s')).verdict == 'hang'
    refused = QuestionOutcome('exception', Unsupported('no half spaces\nmore'))
    assert judged(DEEP, 'penetration', refused) == ('unsupported', 'no half spaces', 0.0)
    assert judged(DEEP, 'penetration', QuestionOutcome('exception', ValueError('x'))).text == 'x'
