"""The generated families of hard cases, each from a seed of its own.

    PYTHONPATH=.:test python -m oracles.hard_cases.families [FAMILY ...]

writes them into the catalogue.
"""

import itertools
import sys
import time
import zlib
from dataclasses import replace

import numpy as np
from oracles.hard_cases import scales
from oracles.hard_cases.construct import (
    PAIRS,
    SOLIDS,
    body,
    box_vertices,
    case,
    gap_case,
    hull_vertices,
    outward,
    sizes,
    turned,
    unit,
)
from oracles.hard_cases.interlocked import interlocked
from oracles.hard_cases.solids import solids

from drake_geom_ros.cross_check.bodies import as_tuples
from truth.bodies.random_bodies import random_rotation
from truth.hard_cases.cases import CATALOGUE, text_of

WITH_HALF_SPACE = tuple(('HalfSpace', kind) for kind in SOLIDS)
QUARTER = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
UPWARDS, SIDEWAYS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
GAPS = (0.0, 1e-15, 1e-12, 1e-9, 1e-6, -1e-12, -1e-9, -1e-6)


def touching(rng):
    """Faces, edges and vertices of every pair of shapes at, or next to, contact."""
    gaps = itertools.cycle(GAPS)
    for (x, y), feature in itertools.product(PAIRS + WITH_HALF_SPACE, ('face', 'edge', 'vertex')):
        a, b = turned(rng, x), turned(rng, y)
        gap = next(gaps)
        yield gap_case(f'{feature} of A, gap {gap:g}', a, b, outward(a, rng, feature), gap)


def flush(rng):
    """Aligned bodies face on face, so that contact is a whole area."""
    kinds = ('Box', 'Cylinder', 'Convex', 'Capsule')
    size = {'Box': (1.0, 2.0, 0.5), 'Cylinder': (0.5, 0.25), 'Capsule': (0.25, 1.0),
            'Convex': box_vertices((1.0, 0.5, 2.0))}  # fmt: skip
    for (x, y), gap in itertools.product(
        itertools.combinations_with_replacement(kinds, 2), (0.0, 1e-3, -1e-3)
    ):
        a, b = body(x, size[x]), body(y, size[y])
        # Capsules touch along their sides, which are parallel to z.
        n, aside = (UPWARDS, SIDEWAYS) if 'Capsule' not in (x, y) else (SIDEWAYS, UPWARDS)
        found = gap_case('', a, b, n, gap)
        found = replace(found, b=found.b.at(found.b.p + 0.125 * aside), witnesses=None)
        R, about = random_rotation(rng), f'flush, shifted by 1/8 m, gap {gap:g}'
        a, b = found.a.moved(R, np.zeros(3)), found.b.moved(R, np.zeros(3))
        if gap < 0.0:
            yield case(about, a, b)
        else:
            yield replace(found.moved(R, np.zeros(3)), about=about)


def parallel(rng):
    """Axes parallel, or off by 1e-16 to 1e-3 rad, side by side or end to end."""
    kinds = ('Capsule', 'Cylinder', 'Box', 'Ellipsoid')
    tilts = itertools.cycle((0.0, 1e-16, 1e-12, 1e-8, 1e-5, 1e-3))
    long = {'Capsule': (0.1, 2.0), 'Cylinder': (0.1, 2.0), 'Box': (0.2, 0.25, 2.0),
            'Ellipsoid': (0.1, 0.125, 1.0)}  # fmt: skip
    for (x, y), side, gap in itertools.product(
        itertools.combinations_with_replacement(kinds, 2), (True, False), (1e-3, -1e-3)
    ):
        R, tilt = random_rotation(rng), next(tilts)
        a = body(x, long[x], R)
        b = body(y, long[y], R @ random_rotation(rng, tilt) if tilt else R)
        n = R[:, 0] if side else R[:, 2]
        where = 'side by side' if side else 'end to end'
        yield gap_case(f'{where}, {tilt:g} rad off parallel, gap {gap:g}', a, b, n, gap)


def concentric(rng):
    """One centre for both bodies, in one orientation, a quarter turn or any."""
    for x, y in PAIRS:
        a = body(x, sizes(x, rng))
        for name, R in (('aligned', np.eye(3)), ('turned', random_rotation(rng))):
            yield case(f'one centre, {name}', a, body(y, sizes(y, rng), R))


def same(rng):
    """Yield a body with itself, at the same pose or next to it."""
    for kind in SOLIDS:
        a = turned(rng, kind)
        for step in (0.0, 1e-15, 1e-9):
            b = a.at(a.p + step * unit(rng.normal(size=3)))
            yield case(f'the same body {step:g} m away', a, b)


def nested(rng):
    """Yield a small body within a large one, near its surface or deep."""
    for x, y in PAIRS:
        a = turned(rng, x)
        b = body(y, sizes(y, rng, 0.1), random_rotation(rng))
        inside = 0.5 * rng.uniform(0.1, 0.9) * min(np.ravel(a.size).min(), 1.0)
        if x == 'Convex':
            inside = 0.1
        yield case('a tenth of the size, inside', a, b.at(inside * unit(rng.normal(size=3))))


def rotations(rng):
    """Rotation matrices that are off orthogonal by rounding, or by a little more."""
    for (x, y), error in zip(PAIRS, itertools.cycle((1e-16, 1e-15, 5e-15, 2e-13)), strict=False):
        a, b = turned(rng, x), turned(rng, y)
        found = gap_case('', a, b, outward(a, rng, 'vertex'), 1e-2)
        bent = [
            replace(one, R=one.R + error * rng.uniform(-1.0, 1.0, (3, 3)))
            for one in (found.a, found.b)
        ]
        tolerance = found.tolerance + 6.0 * error * (a.radius + b.radius)
        about = f'rotations off by {error:g}'
        yield replace(found, about=about, a=bent[0], b=bent[1], tolerance=tolerance)


def lattice(rng):
    """Equal sizes on lattice points, axes aligned or turned by right angles (as fcl#508)."""
    size = {'Sphere': (0.5,), 'Box': (1.0, 1.0, 1.0), 'Capsule': (0.5, 1.0),
            'Cylinder': (0.5, 1.0), 'Ellipsoid': (0.5, 0.5, 1.0),
            'Convex': box_vertices((1.0, 1.0, 1.0))}  # fmt: skip
    offsets = [p for p in itertools.product((0.0, 1.0, 2.0, 4.0), repeat=3) if any(p)]
    for x, y in PAIRS:
        for R in (np.eye(3), QUARTER):
            p = offsets[rng.integers(len(offsets))]
            yield case(f'offset {p}', body(x, size[x]), body(y, size[y], R, p))
    for p in offsets:
        if np.count_nonzero(p) < 3 and max(p) == 4.0:
            a, b = body('Box', (1.0, 1.0, 1.0)), body('Box', (1.0, 1.0, 1.0), None, p)
            yield case(f'unit cubes at offset {p}', a, b)


def half_spaces(rng):
    """Every shape over, on, in and under a tilted plane."""
    for (_, kind), gap in itertools.product(WITH_HALF_SPACE, (1e-3, 0.0, -1e-3, -10.0)):
        plane = body('HalfSpace', (), random_rotation(rng), rng.uniform(-1.0, 1.0, 3))
        yield gap_case(f'gap {gap:g}', plane, turned(rng, kind), plane.R[:, 2], gap)


def points(rng):
    """Spheres of radius 0: at centres, on surfaces, at corners, next to them."""
    for kind in ('Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'Sphere', 'Convex', 'HalfSpace'):
        a = turned(rng, kind)
        point = body('Sphere', (0.0,))
        yield case('at the origin of the shape', a, point.at(a.p))
        for feature, gap in (('face', 0.0), ('vertex', 0.0), ('vertex', 1e-9), ('edge', 1.0)):
            yield gap_case(f'{feature}, gap {gap:g}', a, point, outward(a, rng, feature), gap)


def hulls(rng):
    """Hulls that hide something: boxes, coplanar and double points, slivers, prisms."""
    cube = box_vertices((1.0, 1.0, 1.0))
    middles = as_tuples(np.vstack([np.eye(3), -np.eye(3)]) * 0.5)
    tetrahedron = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    angles = np.arange(8) * np.pi / 4
    prism = tuple((float(np.cos(t)), float(np.sin(t)), z) for z in (-0.5, 0.5) for t in angles)
    needle = box_vertices((1e-3, 1e-3, 1.0))
    shapes = {
        'cube': cube,
        'cube with points in its faces': cube + middles,
        'cube with double points': cube + cube,
        'tetrahedron': tetrahedron,
        'octagonal prism': prism,
        'needle': needle,
        'ball of 100 points': hull_vertices(rng, 1.0, 100),
    }
    for name, vertices in shapes.items():
        a = body('Convex', vertices, random_rotation(rng))
        for y, feature, gap in (
            ('Box', 'face', 1e-6), ('Convex', 'vertex', 0.0), ('Sphere', 'edge', 0.1),
            ('Cylinder', 'face', -1e-3),
        ):  # fmt: skip
            n = outward(a, rng, feature)
            yield gap_case(f'{name}, gap {gap:g}', a, turned(rng, y), n, gap)
        if len(vertices) < 100:  # the search over directions crosses all edges with all
            yield case(f'{name} about its own double', a, replace(a, R=random_rotation(rng)))


FAMILIES = {
    function.__name__: function
    for function in (
        touching, flush, parallel, concentric, same, nested, rotations, lattice, half_spaces,
        points, hulls, solids, interlocked, scales.slivers, scales.ratios, scales.far,
        scales.extremes,
    )
}  # fmt: skip


def generate(name):
    """Return the cases of a family, numbered."""
    seed = zlib.crc32(name.encode())
    found = FAMILIES[name](np.random.default_rng(seed))
    return [
        replace(each, id=f'{name}-{number:02d}', family=name, source=f'{name}, seed {seed}')
        for number, each in enumerate(found)
    ]


def main():
    for name in sys.argv[1:] or FAMILIES:
        start = time.perf_counter()
        cases = generate(name)
        (CATALOGUE / f'{name}.json').write_text(text_of(cases))
        print(f'{name}: {len(cases)} cases, {time.perf_counter() - start:.1f} s', flush=True)


if __name__ == '__main__':
    main()
