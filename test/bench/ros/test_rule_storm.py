"""The referee of the storm of proximity rules notices faults."""

from types import SimpleNamespace as Plain

import pytest

from bench.ros.rules.cell import NAMES, Rule
from bench.ros.rules.referee import Facts, Heard, Referee, Step
from drake_geom_ros.math import RigidTransform

RULE = Rule('r', ('left::f0', 'right'), 3, 0.1, 0.2)


def step(gap, *events, at=10.0, **facts):
    """Return a step with `left::f0`, a ball of 6 cm, so far from the flat side of a box."""
    places = {name: RigidTransform([3.0 * k, 5, 0]) for k, name in enumerate(NAMES)}
    places['right::f2'] = RigidTransform([0, 0, 0])
    places['left::f0'] = RigidTransform([0, 0.025 + 0.06 + gap, 0])
    posed = dict.fromkeys(('left', 'right'), (at, at + 0.01))
    known = Facts({'r': RULE}, **facts)
    return Step(1, at, at + 0.01, places, posed, known, [], list(events), at + 0.02)


def event(number, entered, distance, why='near', at=10.01):
    pair = ('left::f0/g', 'right::f2/g')
    told = Plain(
        sequence=number, rule='r', entered=entered, why=why, distance=distance, error_bound=1e-12,
        geometry_a=pair[0], geometry_b=pair[1],
    )  # fmt: skip
    return Heard(told, at)


def problems(*steps):
    referee = Referee()
    for each in steps:
        referee.look(each)
    return ' '.join(referee.problems)


def test_what_is_founded_is_no_problem():
    come, go = step(0.05, event(1, True, 0.05)), step(0.3, event(2, False, 0.3), at=10.1)
    assert problems(step(0.3, at=9.9), come, go) == ''


@pytest.mark.parametrize(
    ('steps', 'told'),
    [
        ([step(0.05)], 'a pair is near, and it was not entered'),
        (
            [step(0.05, event(1, True, 0.05)), step(0.3, at=10.1)],
            'all is far, and it was not left',
        ),
        ([step(0.3, event(1, True, 0.05))], 'and it is 0.3'),
        ([step(0.15, event(1, True, 0.15))], 'not below enter'),
        ([step(0.05, event(2, True, 0.05))], 'event 2 after 0'),
        ([step(0.05, event(1, True, 0.05), event(2, True, 0.05))], 'entered twice'),
        ([step(0.3, event(1, True, 0.3, 'stale'))], 'all that it needs were fresh'),
        ([step(0.05, event(1, True, 0.05), event(2, False, 0.05))], 'left while a pair is'),
        ([step(0.3, unposed=frozenset(['left']))], 'poses are stale, and it was not entered'),
        (
            [step(0.05, event(1, True, 0.05), filtered=frozenset([frozenset(NAMES[::5])]))],
            'a pair that does not count',
        ),
    ],
)
def test_what_is_not_is_told(steps, told):
    assert told in problems(*steps)
