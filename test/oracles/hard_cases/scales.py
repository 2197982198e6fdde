"""Families of odd proportions: slivers, sizes far apart, far from the origin, tiny."""

import itertools
from dataclasses import replace

import numpy as np
from oracles import body_truth as truth
from oracles.hard_cases.construct import (
    PAIRS,
    SOLIDS,
    body,
    case,
    gap_case,
    outward,
    sizes,
    turned,
)

from drake_geom_ros.cross_check.bodies import BOUNDED
from truth.bodies.random_bodies import random_rotation


def _thin(kind, t):
    return {
        'plate': ('Box', (1.0, 1.0, t)),
        'rod': ('Box', (t, t, 1.0)),
        'coin': ('Cylinder', (1.0, t)),
        'wire': ('Cylinder', (t, 1.0)),
        'hair': ('Capsule', (t, 1.0)),
        'pancake': ('Ellipsoid', (1.0, 1.0, t)),
        'needle': ('Ellipsoid', (t, t, 1.0)),
    }[kind]


def slivers(rng):
    """Bodies as thin as 1e-2 to 1e-6 of their length, apart, touching and a little into others."""
    names = ('plate', 'rod', 'coin', 'wire', 'hair', 'pancake', 'needle')
    others = itertools.cycle(BOUNDED)
    for name, t in itertools.product(names, (1e-2, 1e-4, 1e-6)):
        a = body(*_thin(name, t), random_rotation(rng))
        b = turned(rng, next(others))
        for feature, gap in (('face', 0.1 * t), ('vertex', 0.0), ('edge', 0.1)):
            yield gap_case(f'{name} of {t:g}, gap {gap:g}', a, b, outward(a, rng, feature), gap)
    for x, y in itertools.combinations_with_replacement(names, 2):
        a, b = body(*_thin(x, 1e-4), random_rotation(rng)), body(*_thin(y, 1e-4))
        yield gap_case(f'{x} and {y} of 1e-4, touching', a, b, outward(a, rng, 'vertex'), 0.0)
    for x, y in (('plate', 'rod'), ('plate', 'hair'), ('hair', 'hair'), ('rod', 'rod')):
        a, b = body(*_thin(x, 1e-4), random_rotation(rng)), body(*_thin(y, 1e-4))
        yield case(f'{x} and {y} of 1e-4 through each other', a, b)


def ratios(rng):
    """One body up to 1e8 times as large as the other."""
    steps = itertools.cycle((1e-2, 1e-4, 1e-6, 1e-8))
    for x, y in itertools.product(SOLIDS, repeat=2):
        small = next(steps)
        a, b = turned(rng, x), body(y, sizes(y, rng, small), random_rotation(rng))
        yield gap_case(f'B of {small:g} m beside A', a, b, outward(a, rng, 'vertex'), 0.1 * small)


def far(rng):
    """All pairs up to 1e7 m from the origin, at positions that float64 holds exactly."""
    steps = itertools.cycle((1e3, 1e5, 1e7))
    for (x, y), gap in itertools.product(PAIRS, (1e-2, -1e-2)):
        a, b = turned(rng, x), turned(rng, y)
        found = gap_case('', a, b, outward(a, rng, 'vertex'), gap)
        away = next(steps) * rng.choice([-1.0, 1.0], 3)
        ps = [np.round(2**20 * one.p) / 2**20 + away for one in (found.a, found.b)]
        distance, tolerance = truth.signed_distance(found.a.at(ps[0]), found.b.at(ps[1]))
        # Results are in World, where a coordinate of this size is rounded.
        tolerance += np.finfo(float).eps * np.abs(away).max()
        yield replace(
            case(f'{np.abs(away).max():g} m away', found.a, found.b, distance, tolerance),
            a=found.a.at(ps[0]),
            b=found.b.at(ps[1]),
        )


def extremes(rng):
    """Sizes of 1e-306 to 1e300 m, alike, and the smallest numbers that there are beside 1 m."""
    kinds = (('Sphere', 'Sphere'), ('Sphere', 'Box'), ('Box', 'Box'), ('Capsule', 'Capsule'),
             ('Cylinder', 'Box'), ('Ellipsoid', 'Ellipsoid'), ('Sphere', 'Ellipsoid'),
             ('Capsule', 'Cylinder'))  # fmt: skip
    size = {'Sphere': (0.5,), 'Box': (1.0, 0.5, 0.25), 'Capsule': (0.25, 1.0),
            'Cylinder': (0.5, 1.0), 'Ellipsoid': (0.5, 0.25, 1.0)}  # fmt: skip
    for (x, y), s in itertools.product(kinds, (1e-306, 1e-100, 1e-9, 1e9, 1e100, 1e300)):
        s = 2.0 ** np.round(np.log2(s))
        a, b = body(x, s * np.array(size[x])), body(y, s * np.array(size[y]))
        for gap in (0.25, -0.125):
            found = gap_case('', body(x, size[x]), body(y, size[y]), (1.0, 0.0, 0.0), gap)
            tolerance = s * found.tolerance + 5e-324
            about = f'sizes of {s:.0e} m, gap {gap * s:.0e}'
            yield case(about, a, b.at(s * found.b.p), s * found.distance, tolerance)
    for kind in ('Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'Sphere'):
        for s in (5e-324, 1e-300, 1e-160, 1e-20):
            a, b = turned(rng, kind), body('Sphere', (s,))
            yield gap_case(f'sphere of radius {s:g} m', a, b, outward(a, rng, 'vertex'), 0.5)
            small = {'Box': (s, s, s), 'Ellipsoid': (s, s, s)}.get(kind, (s, s))
            if kind != 'Sphere':
                a = body('Box', (1.0, 1.0, 1.0))
                b = body(kind, small)
                yield gap_case(f'{kind} of {s:g} m', a, b, (1.0, 0.0, 0.0), 0.5)
