"""The hunt: it finds nothing in our answers, and whatever is wrong with answers made wrong."""

import json

import numpy as np
import pytest
from numba import config

from bench.searches.hunting import asking, report, scene, search
from bench.searches.hunting.judge import LAWS
from drake_geom_ros.cross_check.bodies import Body, Pair
from truth.hard_cases.cases import case_of, text_of

SLOTS = 2 if config.DISABLE_JIT else 32
ROUNDS = 1 if config.DISABLE_JIT else 5
PLAIN = Pair(
    Body('Box', (0.4, 0.3, 0.2), np.eye(3), np.zeros(3)),
    Body('Cylinder', (0.1, 0.5), np.array([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]]),
         np.array([0.1, 0.2, 0.15])),
)  # fmt: skip


def hunted(seed, rounds=ROUNDS):
    hunt = search.Hunt(seed, slots=SLOTS)
    for _ in range(rounds):
        hunt.generation()
    return hunt


def falsify(monkeypatch, change):
    """Let answers be changed on their way from the engine to those who judge them."""
    real = scene.distances
    monkeypatch.setattr(scene, 'distances', lambda found: change(real(found)))


def test_a_short_run_finds_nothing_false():
    hunt = hunted(seed=7)
    assert hunt.judged >= 4 * SLOTS * ROUNDS
    assert dict(hunt.broken) == {}


@pytest.fixture(scope='module')
def one_round():
    return hunted(seed=5, rounds=1)


def test_a_run_is_the_same_for_its_seed(one_round):
    first, second = one_round, hunted(seed=5, rounds=1)
    assert first.judged == second.judged
    assert {key: find.ratio for key, find in first.worst.items()} == {
        key: find.ratio for key, find in second.worst.items()
    }


def test_a_plain_pair_breaks_no_law():
    assert asking.broken(PLAIN) == []


@pytest.mark.parametrize(
    ('law', 'change'),
    [
        ('certificate', lambda x: x._replace(distance=x.distance - 0.01 * abs(x.distance))),
        ('certificate', lambda x: x._replace(distance=x.distance + 0.01 * abs(x.distance))),
        ('promise', lambda x: x._replace(error_bound=1e7 * x.error_bound)),
        ('identity', lambda x: x._replace(p_WCa=x.p_WCa + 1e-9)),
        ('surface', lambda x: x._replace(p_ACa=x.p_ACa * (1.0 + 1e-9))),
        ('unit', lambda x: x._replace(nhat_BA_W=x.nhat_BA_W * (1.0 + 1e-9))),
        ('normal', lambda x: x._replace(nhat_BA_W=-x.nhat_BA_W)),
        ('finite', lambda x: x._replace(p_BCb=np.nan * x.p_BCb)),
        ('contact', lambda x: x._replace(distance=x.distance + 1.0)),
    ],
)
def test_what_is_made_wrong_is_seen(monkeypatch, law, change):
    falsify(monkeypatch, change)
    assert law in asking.broken(PLAIN)


@pytest.mark.skipif(config.DISABLE_JIT, reason='a search needs thousands of pairs')
def test_bounds_that_are_a_thousand_times_too_small_are_found(monkeypatch):
    falsify(monkeypatch, lambda x: x._replace(error_bound=1e-3 * x.error_bound))
    broken = {key.law for key in hunted(seed=1, rounds=2).broken}
    assert broken >= {'order', 'motion', 'hint', 'levels', 'surface'}


@pytest.mark.skipif(config.DISABLE_JIT, reason='a search needs thousands of pairs')
def test_what_is_wrong_in_rare_poses_only_is_found_and_minimised(monkeypatch):
    """Distances off by 1 % where the normal is 1e-6 to 1e-9 off an axis: no random pose has it."""

    def change(x):
        off = 1.0 - np.abs(x.nhat_BA_W).max(axis=1)
        rare = (off < 1e-12) & (off > 0.0)
        return x._replace(distance=np.where(rare, x.distance * 1.01, x.distance))

    falsify(monkeypatch, change)
    hunt = hunted(seed=2, rounds=3)
    hunt.worst = {
        key: find for key, find in hunt.worst.items() if key[::2] == ('certificate', search.PLAIN)
    }
    (found, _) = report.entries(hunt, 2)
    assert any(case.about.startswith('certificate') for case in found)


@pytest.fixture
def broken_certificate(monkeypatch):
    falsify(monkeypatch, lambda x: x._replace(distance=x.distance - 0.01 * abs(x.distance)))


def test_an_entry_is_simple_true_and_read_by_the_catalogue(broken_certificate):
    p = np.array([0.123456789, 0.2, 0.15])
    pair = Pair(PLAIN.a, PLAIN.b.at(p))
    case, ratio = report.minimised(pair, 'certificate')
    assert ratio > 1.0
    assert all(len(f'{x:g}') <= 4 for one in (case.a, case.b) for x in (*one.size, *one.p))
    made = report.entry(case, 'certificate', ratio, 'hunt-0-0', 0)
    read = case_of(json.loads(text_of([made]))[0], 'found')
    assert read.distance == made.distance
    # The engine is not asked for the distance of an entry.
    gap = scene.PairsScene([case])
    gap.place([case])
    answer = gap.query.ComputeSignedDistancePairwiseClosestPoints()
    assert abs(answer.distance[0] - made.distance) <= made.tolerance + answer.error_bound[0]


def test_the_page_has_every_law_and_pair(one_round):
    hunt = one_round
    page = report.page(hunt, './run hunt')
    assert all(f' {law} ' in page for law in LAWS)
    assert f'{hunt.judged} pairs judged' in page
    pairs, laws = page.split('## The laws')
    assert all(f'| `{law}` |' in laws for law in LAWS)
    rows = [line[2:].split(' | ')[0] for line in pairs.splitlines() if line.startswith('| ')]
    assert rows == ['shapes', '---', *sorted({key.kinds for key in hunt.worst})]


def test_a_worse_plane_of_the_search_does_not_make_a_certificate_false():
    """Of two needles the search found 51866.8 m, and a given plane 51877.78 m: so did we."""
    R = [0.7025062572408202, -0.49462221994123506, -0.511696998308472, -0.36604776899733704]
    R += [0.3654755136262597, -0.8558251455476726, 0.6103228566501241, 0.7885280644847253]
    R = np.array([*R, 0.07569347508475079]).reshape(3, 3)
    p = np.array([-59664.985184586425, -0.7625376465078091, -49.68832135051094])
    pair = Pair(
        Body('Ellipsoid', (1.5130245478531883e-06, 1e5, 5.497554968322061e-06), R, np.zeros(3)),
        Body(
            'Ellipsoid', (3.782561385248358e-07, 24999.999906864083, 1.374388742838076e-06), R, p
        ),
    )
    scenes = asking.Scenes([pair], np.random.default_rng(0), chains=False)
    judged = scenes.ask([pair], np.zeros((1, 3)))[asking.GIVEN]
    # A plane a little worse than the best, and far better than the one of the search.
    judged.nhats[0] += 1e-13
    assert asking._error(judged, 0) < 100.0
