"""What is stored is what the generator makes, and what the oracles hold true."""

import numpy as np
import pytest
from every import check
from oracles import body_truth as truth
from oracles.hard_cases.families import FAMILIES, generate

from drake_geom_ros.cross_check.surfaces import width
from truth.hard_cases import cases

QUICK = (
    'rotations', 'half_spaces', 'points', 'slivers', 'ratios', 'nested', 'solids', 'interlocked',
)  # fmt: skip


def test_every_stored_family_is_generated_but_what_was_found():
    assert set(cases.families()) == {*FAMILIES, 'reports', 'fuzzed', 'hunted'}


@pytest.mark.parametrize('family', QUICK)
def test_stored_cases_are_those_of_the_generator(family):
    stored, made = cases.load(family), generate(family)
    assert len(stored) == len(made)
    for old, new in zip(stored, made, strict=True):
        assert (old.id, old.source, old.about) == (new.id, new.source, new.about)
        # Other versions of NumPy and SciPy, and other processors, round otherwise: poses by this
        # much, distances with them.
        off = 1e-14 * (1.0 + new.away)
        assert old.distance == pytest.approx(new.distance, abs=2.0 * new.tolerance + off)
        for a, b in ((old.a, new.a), (old.b, new.b)):
            assert a.kind == b.kind
            np.testing.assert_allclose(np.ravel(a.size), np.ravel(b.size), rtol=1e-14)
            np.testing.assert_allclose(a.R, b.R, rtol=0, atol=1e-15)
        if not same_place(old, new):
            assert_true(old)


def same_place(old, new):
    """Whether bodies are where they were; of corners that tie, rounding chooses another one."""
    ps = [(old.a.p, new.a.p), (old.b.p, new.b.p)]
    return all(np.allclose(p, q, rtol=0, atol=1e-14 * (1.0 + np.abs(q).max())) for p, q in ps)


def assert_true(case):
    distance, tolerance = truth.signed_distance(case.a, case.b)
    assert abs(distance - case.distance) <= tolerance + case.tolerance


def test_spheres_by_solids_are_true():
    def judge(case):
        distance = truth.of_ball(case.a, case.b)
        if distance is None:  # no straight way out
            assert case.distance < 0.0
        elif 'inside out' not in case.about:
            assert distance == pytest.approx(case.distance, abs=case.tolerance)

    kinds = ('Solid', 'Sphere')
    spheres = [case for case in cases.load('solids') if (case.a.kind, case.b.kind) == kinds]
    assert len(spheres) > 40
    check(judge, spheres, lambda case: case.id)


def test_reports_are_true():
    def judge(case):
        assert_true(case)
        assert case.tolerance <= 1e-12 + 1e-11 * (case.extent + abs(case.a.p).max())

    check(judge, cases.load('reports'), lambda case: case.id)


def test_what_was_hunted_is_true():
    """A normal proves a depth where the search, of bodies too unlike, ends beside it."""

    def judge(case):
        if case.normals is None:
            assert_true(case)
        for n in () if case.normals is None else case.normals:
            assert width(case.a, case.b, n) == pytest.approx(case.distance, abs=case.tolerance)
            assert truth.signed_distance(case.a, case.b)[0] <= case.distance + case.tolerance

    check(judge, cases.load('hunted'), lambda case: case.id)
