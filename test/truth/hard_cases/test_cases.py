"""Entries keep all digits, and cases move and scale with their truth."""

import json

import numpy as np
import pytest
from oracles import body_truth as truth
from oracles.hard_cases.construct import gap_case, turned

from drake_geom_ros.cross_check.surfaces import width
from truth.hard_cases.cases import case_of, entry_of, text_of


def some_cases():
    rng = np.random.default_rng(4)
    for kind in ('Box', 'Ellipsoid', 'Convex', 'HalfSpace'):
        a, b = turned(rng, kind), turned(rng, 'Sphere')
        yield gap_case('a, "quoted" gap', a, b, a.R[:, 2], 1 / 3)


def test_the_text_of_cases_reads_back():
    cases = list(some_cases())
    for one, entry in zip(cases, json.loads(text_of(cases)), strict=True):
        read = case_of(entry, '')
        assert json.dumps(entry_of(read)['a']) == json.dumps(entry_of(one)['a'])
        assert (read.distance, read.about) == (one.distance, one.about)
        assert one.tolerance <= read.tolerance <= 1.2 * one.tolerance
        np.testing.assert_array_equal(read.b.R, one.b.R)
        np.testing.assert_array_equal(read.b.p, one.b.p)


@pytest.mark.parametrize('one', list(some_cases()), ids=lambda one: one.a.kind)
def test_truth_moves_and_scales_with_the_case(one):
    R = turned(np.random.default_rng(5), 'Box').R
    for changed in (one.swapped(), one.moved(R, np.array([3.0, 2.0, 1.0])), one.scaled(0.25)):
        distance, tolerance = truth.signed_distance(changed.a, changed.b)
        assert abs(distance - changed.distance) <= tolerance + changed.tolerance
        if changed.normals is not None:
            gap = width(changed.a, changed.b, changed.normals[0])
            assert gap == pytest.approx(changed.distance, abs=1e-14)
