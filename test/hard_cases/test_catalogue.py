"""Every hard case in both orders, and by a law drawn by chance: all laws with ``--everything``.

A test is a family of the catalogue. The seed of the draw is in pytest's header and in the message
of a failure; each case has its own draw, so that every run puts each law to some cases.
"""

import json
import math
import random
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from every import check
from numba import config
from oracles import body_truth as truth
from oracles import case_laws
from plugins.seed import note, seed

from drake_geom_ros.geometry import ACCURACY_LEVELS
from truth import peers
from truth.bodies.random_bodies import random_rotation
from truth.hard_cases import cases
from truth.judging.asking import PairScene
from truth.tolerances import AS_TOUCHING

ALL = cases.load()
# Uncompiled kernels are slow: some cases of every family will do.
CASES = ALL[::23] if config.DISABLE_JIT else ALL
NUMBERS = {case.id: number for number, case in enumerate(CASES)}
SCALES = (2.0**-20, 2.0**13)

every_family = pytest.mark.parametrize('family', sorted({case.family for case in CASES}))


def laws_of(case):
    """Return the judges of the laws that concern a case, beside that of its orders."""
    laws = [at_every_level, by_every_query, under_rigid_motions, at_other_scales]
    return [*laws, by_the_centre_of_a_sphere] if has_centre(case) else laws


@cache
def has_centre(case):
    """Return whether the distance of a sphere follows from its centre (in solids not always)."""
    in_solid = case.a.kind == 'Solid' and case.b.kind == 'Sphere'
    if in_solid:
        return truth.of_ball(case.a, case.b) is not None
    return 'Sphere' in (case.a.kind, case.b.kind)


def drawn(case, seed):
    """Return the one of the laws of a case that a seed draws."""
    return random.Random(f'{seed} {case.id}').choice(laws_of(case))


@pytest.fixture
def put_to(request):
    """Return a function that judges the cases of a family which this run puts to a law."""
    at_all = request.config.getoption('--everything', default=False)

    def put(law, family):
        of_family = [case for case in CASES if case.family == family]
        concerned = [
            case
            for case in of_family
            if law in (laws_of(case) if at_all else [drawn(case, seed())])
        ]
        check(law, concerned, lambda case: case.id, note())

    return put


def motions(case):
    """Return (R, p) of two motions of World, seeded by the case."""
    rng = np.random.default_rng(len(case.about) + NUMBERS[case.id])
    return [
        (random_rotation(rng), case.extent * rng.uniform(-10.0, 10.0, 3)),
        (np.eye(3), case.extent * np.array([8.0, -4.0, 2.0])),
    ]


def answer_of(case, scene):
    """Pose the scene as the case says, and check the answer of the exact level."""
    scene.place(case.a, case.b)
    row = scene.distance()
    assert set(case_laws.of_answer(case, row)) <= {case_laws.COARSE}
    if case.has_solid:
        assert case_laws.of_contact(case, row, scene) == []
    return row


def test_the_catalogue_is_large_and_its_names_are_unique():
    assert len(ALL) >= 300
    assert len({case.id for case in ALL}) == len(ALL)
    assert {case.a.kind for case in ALL} | {case.b.kind for case in ALL} == {
        'Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'HalfSpace', 'Convex', 'Solid',
    }  # fmt: skip


def test_what_peers_return_is_of_cases_that_there_are():
    today = json.loads(cases.PEERS_TODAY.read_text())
    assert len(today) >= 100
    assert set(today) <= {case.id for case in ALL}
    assert {name for entry in today.values() for name in entry} == set(peers.names())


def in_both_orders(case):
    first, second = (answer_of(each, PairScene(each.a, each.b)) for each in (case, case.swapped()))
    bound = first.error_bound[0] + second.error_bound[0]
    assert abs(first.distance[0] - second.distance[0]) <= bound
    if first.is_nhat_BA_W_unique[0] and second.is_nhat_BA_W_unique[0]:
        cosine = -first.nhat_BA_W[0] @ second.nhat_BA_W[0]
        assert cosine >= 0.98  # within the 8 degrees that uniqueness means, from both sides


def at_every_level(case):
    scene = PairScene(case.a, case.b)
    for level in ACCURACY_LEVELS:
        assert case_laws.of_bound(case, scene.distance(level)) == []


def by_every_query(case):
    scene = PairScene(case.a, case.b)
    row = scene.distance()
    distance, unsure = row.distance[0], case_laws.unsure(case, row)
    size = case.a.radius + case.b.radius
    reach = max(distance + 2.0 * row.error_bound[0], 0.0)
    for found in (scene.pairwise(math.inf), scene.pairwise(reach)):
        assert len(found) == 1
        assert abs(found.distance[0] - distance) <= 2.0 * row.error_bound[0]
    if distance - unsure > 0.0:
        assert len(scene.pairwise(max(0.0, 0.999 * (distance - unsure)))) == 0
    penetration = scene.penetration()
    assert scene.collides() == bool(len(penetration))
    if case.distance < -unsure - AS_TOUCHING * size:
        assert len(penetration) == 1
    if case.distance > unsure:
        assert len(penetration) == 0
    if len(penetration):
        assert len(scene.query.collision_candidates()) == 1
        assert penetration.depth[0] == pytest.approx(-distance, abs=2.0 * row.error_bound[0])
        gap = penetration.p_WCb[0] - penetration.p_WCa[0]
        depth = gap @ penetration.nhat_BA_W[0]
        rounding = case_laws.rounding(case)
        assert depth == pytest.approx(penetration.depth[0], abs=rounding)


def by_the_centre_of_a_sphere(case):
    scene = PairScene(case.a, case.b)
    ball, other = (0, 1) if case.a.kind == 'Sphere' else (1, 0)
    ball = (case.a, case.b)[ball]
    found = scene.query.ComputeSignedDistanceToPoint(ball.p)
    distance = found.distance[other]
    rounding = case_laws.rounding(case)
    assert abs(distance - ball.size[0] - case.distance) <= rounding + case.tolerance
    assert np.linalg.norm(found.grad_W[other]) == pytest.approx(1.0, abs=1e-12)


def under_rigid_motions(case):
    scene = PairScene(case.a, case.b)
    for R, p in motions(case):
        answer_of(case.moved(R, p), scene)


def at_other_scales(case):
    for s in SCALES:
        scaled = case.scaled(s)
        if case.family != 'extremes' and np.isfinite(s * case.extent):
            answer_of(scaled, PairScene(scaled.a, scaled.b))


@every_family
def test_in_both_orders(family):
    check(in_both_orders, [case for case in CASES if case.family == family], lambda case: case.id)


@every_family
def test_at_every_level(family, put_to):
    put_to(at_every_level, family)


@every_family
def test_by_every_query(family, put_to):
    put_to(by_every_query, family)


@every_family
def test_the_centre_of_a_sphere_as_a_point(family, put_to):
    put_to(by_the_centre_of_a_sphere, family)


@every_family
def test_under_rigid_motions(family, put_to):
    put_to(under_rigid_motions, family)


@every_family
def test_at_other_scales(family, put_to):
    put_to(at_other_scales, family)


def test_a_seed_draws_one_law_a_case_and_other_seeds_draw_the_others():
    case = next(case for case in ALL if case.a.kind == 'Sphere')
    draws = [drawn(case, str(seed)) for seed in range(100)]
    assert draws == [drawn(case, str(seed)) for seed in range(100)]
    assert set(draws) == set(laws_of(case))
    assert {drawn(case, '0') for case in ALL} == set(draws)


LAWS = [
    in_both_orders,
    at_every_level,
    by_every_query,
    by_the_centre_of_a_sphere,
    under_rigid_motions,
    at_other_scales,
]


def is_plain(case):
    """Return whether a case has a sphere beside another body, neither touching it nor far."""
    return has_centre(case) and 0.1 < case.distance < 10.0 and case.family != 'extremes'


@pytest.mark.parametrize('law', LAWS, ids=lambda law: law.__name__)
def test_a_law_passes_a_true_case_and_fails_it_with_another_distance(law):
    case = next(case for case in CASES if is_plain(case))
    law(case)
    with pytest.raises(AssertionError):
        law(replace(case, distance=-case.distance))
