"""Each law is kept by a true answer, and broken by one that is false in that way alone."""

from types import SimpleNamespace

import numpy as np
import pytest
from oracles import case_laws

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.geometry import METHODS
from truth.bodies.grids import L, solid
from truth.hard_cases.cases import Case
from truth.judging import laws
from truth.judging.asking import PairScene

A, B = Body('Box', (1.0, 1.0, 1.0)), Body('Sphere', (0.5,), p=np.array([2.0, 0.25, 0.0]))
NORMALS, POINTS = np.array([[-1.0, 0, 0]]), np.array([[0.5, 0.25, 0], [1.5, 0.25, 0]])
CASE = Case(A, B, 1.0, 1e-15, NORMALS, POINTS)
TURNED = np.array([-np.cos(1e-3), np.sin(1e-3), 0.0])


def answer(wide=False, **changes):
    """Return what a query says about CASE, changed."""
    true = {'distance': 1.0, 'nhat_BA_W': NORMALS[0], 'p_WCa': POINTS[0], 'p_WCb': POINTS[1],
            'error_bound': 1e-12, 'method': METHODS['closed_form']}  # fmt: skip
    row = {name: np.array([value]) for name, value in {**true, **changes}.items()}
    return SimpleNamespace(breaks_promise=lambda: np.array([wide]), **row)


def test_the_answer_of_the_engine_keeps_them():
    for pair in (CASE, Pair(A, B), Pair(B, A)):
        assert case_laws.of_answer(pair, PairScene(pair.a, pair.b).distance()) == []
    assert case_laws.of_answer(CASE, answer()) == []


@pytest.mark.parametrize(
    ('changes', 'broken'),
    [
        ({'distance': np.nan}, ['not finite']),
        ({'p_WCb': POINTS[1] + np.inf}, ['not finite']),
        ({'wide': True}, [laws.WIDE]),
        ({'p_WCa': POINTS[0] + [0, 1e-9, 0]}, ['witness points apart']),
        ({'nhat_BA_W': NORMALS[0] * (1 + 1e-11)}, ['normal not unit', 'witness points apart']),
        (
            {'p_WCa': POINTS[0] + [1e-9, 0, 0], 'p_WCb': POINTS[1] + [1e-9, 0, 0]},
            ['witness points off their surfaces'],
        ),
        (
            {'p_WCa': POINTS[0] + [0, 1e-3, 0], 'p_WCb': POINTS[1] + [0, 1e-3, 0]},
            ['witness points off their surfaces', 'other witness points than expected'],
        ),
        (
            {'nhat_BA_W': TURNED},
            [
                'witness points apart',
                'normal does not attain the distance',
                'another normal than expected',
            ],
        ),
    ],
)
def test_a_false_answer_breaks_its_law(changes, broken):
    assert case_laws.of_answer(CASE, answer(**changes)) == broken


def test_a_certificate_that_does_not_hold_the_truth_is_false():
    off = answer(distance=1.0 + 1e-9, p_WCb=POINTS[1] + [1e-9, 0, 0])
    assert case_laws.FALSE in case_laws.of_answer(CASE, off)
    assert case_laws.of_bound(CASE, off) == [case_laws.FALSE]
    assert case_laws.of_bound(CASE, answer(distance=1.0 + 1e-9, error_bound=1e-9)) == []


def test_a_coarse_normal_is_told_from_a_wrong_one():
    """Hulls next to touching, where nothing but the distance stops the iteration."""
    cube = tuple(np.ndindex(2, 2, 2))
    pair = Pair(Body('Convex', cube), Body('Convex', cube, p=np.array([1.0, 0.0, 0.0])))
    found = {}
    for turn in (1e-9, 1e-6, 1e-2):
        normal = np.array([-np.cos(turn), np.sin(turn), 0.0])
        point = np.array([1.0, 0.5, 0.5])
        changes = {'p_WCa': point, 'p_WCb': point, 'method': METHODS['iterative']}
        touching = answer(distance=0.0, nhat_BA_W=normal, **changes)
        found[turn] = case_laws.of_answer(pair, touching)
    assert found == {
        1e-9: [],
        1e-6: [case_laws.COARSE],
        1e-2: ['normal does not attain the distance'],
    }


def test_a_solid_moved_by_its_distance_touches():
    case = Case(solid(L), Body('Sphere', (0.1,), p=np.array([1.25, 1.5, 0.5])), 0.15, 1e-15)
    scene = PairScene(case.a, case.b)
    row = scene.distance()
    assert case_laws.of_contact(case, row, scene) == []
    aside = answer(distance=0.15, nhat_BA_W=[0.0, -1.0, 0.0])
    assert case_laws.of_contact(case, aside, scene) == ['no contact when moved by its distance']
    assert abs(scene.distance().distance[0] - 0.15) < 1e-12  # the scene is as it was


def test_points_are_as_sharp_as_a_closed_form():
    ball = Body('Sphere', (0.1,))
    assert not laws.is_wide_to_a_point(1e-11, ball)
    assert laws.is_wide_to_a_point(2e-10, ball)
    assert not laws.is_wide_to_a_point(5e-10, Body('HalfSpace'))
