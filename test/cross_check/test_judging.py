"""Who is wrong: a wrong answer of ours is seen, and FCL's known faults are not taken for ours."""

import dataclasses

import numpy as np
import pytest

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.cross_check.judging import allowed_to_others, judged
from drake_geom_ros.cross_check.question import AGREED, DISAGREED, REFUTED, SILENT, PairQuestion
from truth.bodies.random_bodies import box_corners
from truth.peers import PairAnswer

EYE = np.eye(3)
X = np.array([1.0, 0.0, 0.0])


def balls(gap):
    """Return two balls of 0.1 m, B a gap [m] away from A along -x, with the right answer."""
    a, b = Body('Sphere', [0.1], p=np.zeros(3)), Body('Sphere', [0.1], p=-(0.2 + gap) * X)
    p_WCa = -0.1 * X
    right = PairQuestion((1, 2), (EYE, a.p), (EYE, b.p), gap, 1e-14, X, p_WCa, p_WCa - gap * X)
    return Pair(a, b), right


def said(gap, nhat_BA_W=X):
    """Return an answer of FCL's along a normal, with the witness points of the balls."""
    p_WCa = -0.1 * X
    return PairAnswer(gap, None, p_WCa, p_WCa - gap * nhat_BA_W)


GAPS = (0.05, 1e-6, 0.0, -1e-6, -0.03)
gaps = pytest.mark.parametrize('gap', GAPS)


def verdict(pair, ours, theirs):
    return judged(pair, ours, theirs, 'FCL').verdict


@gaps
def test_right_answers_agree(gap):
    pair, right = balls(gap)
    assert verdict(pair, right, said(gap)) == AGREED


@gaps
@pytest.mark.parametrize('off', [0.01, -0.01, 3e-4, -3e-4])
def test_a_wrong_answer_is_seen(gap, off):
    pair, right = balls(gap)
    wrong = dataclasses.replace(right, distance=gap + off)
    assert verdict(pair, wrong, said(gap)) == DISAGREED


@gaps
@pytest.mark.parametrize('off', [0.5, -0.5, 0.01, -0.01])
def test_a_wrong_answer_of_fcl_is_refuted(gap, off):
    pair, right = balls(gap)
    assert verdict(pair, right, said(gap + off, np.array([0.0, 1.0, 0.0]))) == REFUTED


@gaps
def test_within_the_certified_interval_all_is_well(gap):
    """An answer from bounds alone is wide, and right as long as the truth is in it."""
    pair, right = balls(gap)
    wide = dataclasses.replace(right, distance=gap + 0.02, error_bound=0.02)
    assert verdict(pair, wide, said(gap)) == AGREED
    narrow = dataclasses.replace(wide, error_bound=0.019)
    assert verdict(pair, narrow, said(gap)) == DISAGREED


@pytest.mark.parametrize(
    ('gap', 'wanted'), [(0.05, AGREED), (0.0, AGREED), (-5e-5, AGREED), (-0.03, REFUTED)]
)
def test_no_contact(gap, wanted):
    pair, right = balls(gap)
    assert verdict(pair, right, None) == wanted


def test_no_contact_where_we_say_that_there_is_one():
    pair, right = balls(0.05)
    overlapping = dataclasses.replace(right, distance=-0.05)
    assert verdict(pair, overlapping, None) == DISAGREED


@pytest.mark.parametrize('distance', [np.nan, np.inf, 1.8e308])
def test_what_is_no_number_is_no_opinion(distance):
    pair, right = balls(0.05)
    assert verdict(pair, right, said(0.05)._replace(distance=distance)) == SILENT


def test_the_tolerance_is_that_of_the_hard_cases():
    pair, _ = balls(0.05)
    assert allowed_to_others(pair) == pytest.approx(1e-3 * 0.1)


class TestSolids:
    """FCL sees their surface alone."""

    BOX = Body(
        'Solid',
        box_corners(),
        triangles=[
            *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
            *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
        ],
    )

    def question(self, x):
        """Return the cube about the origin and a ball of 0.1 m at x, with the right answer."""
        gap = x - 0.6
        p_WCb = np.array([x - 0.1, 0.0, 0.0])
        pair = Pair(self.BOX, Body('Sphere', [0.1], p=x * X))
        p_WCa = p_WCb - gap * X
        return pair, PairQuestion(
            (1, 2), (EYE, np.zeros(3)), (EYE, x * X), gap, 1e-12, -X, p_WCa, p_WCb
        )

    def test_a_ball_outside(self):
        pair, right = self.question(1.0)
        assert verdict(pair, right, PairAnswer(0.4, None, None, None)) == AGREED
        assert verdict(pair, right, PairAnswer(0.3, None, None, None)) == REFUTED
        assert verdict(pair, right, PairAnswer(0.5, None, None, None)) == REFUTED
        assert verdict(pair, right, PairAnswer(-1.0, None, None, None)) == REFUTED

    def test_a_wrong_answer_outside(self):
        pair, right = self.question(1.0)
        for off in (0.1, -0.1):
            wrong = dataclasses.replace(right, distance=right.distance + off)
            assert verdict(pair, wrong, PairAnswer(0.4, None, None, None)) == DISAGREED

    def test_a_ball_across_the_surface_and_one_inside(self):
        pair, right = self.question(0.55)
        assert verdict(pair, right, PairAnswer(-1.0, None, None, None)) == AGREED
        pair, right = self.question(0.3)
        assert verdict(pair, right, PairAnswer(0.1, None, None, None)) == SILENT

    def test_a_ball_across_the_surface_that_we_call_free(self):
        pair, right = self.question(0.55)
        free = dataclasses.replace(right, distance=0.05)
        assert verdict(pair, free, PairAnswer(-1.0, None, None, None)) == DISAGREED
