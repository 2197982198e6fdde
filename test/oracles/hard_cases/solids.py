"""Meshes as solids: what has dents, holes and cavities, where a hull or a bare surface is wrong.

Every distance is plain from the drawing: blocks of whole metres, and what lies in, on and between
them.
"""

import itertools

import numpy as np
from oracles.hard_cases.construct import body, case, placing

from drake_geom_ros.cross_check.bodies import Body, as_tuples
from truth.bodies.grids import (
    CORNER,
    CUBE,
    FRAME,
    HOLLOW,
    RING,
    L,
    U,
    flat,
    solid,
    surface,
)
from truth.bodies.random_bodies import random_rotation

X, Y, Z = np.eye(3)
NOTCH = (1.5, 1.5, 0.5)  # the middle of the notch, the channel and the hole
TILTED = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # x to z, y to -x
HALF_TURN = np.diag([-1.0, -1.0, 1.0])


def known(about, a, b, distance, *normals):
    """Return the case of a pair whose distance is known but for the rounding of poses."""
    return case(about, a, b, distance, placing(a, b, X), np.array(normals) if normals else None)


def ball(radius, *p):
    return body('Sphere', (radius,), None, p)


def box(size, *p):
    return body('Box', size, None, p)


def solids(rng):
    """Bodies in, on and between blocks; one in three is turned with all that it meets."""
    parts = (inside, in_dents, edges_and_rays, touching, through, of_two, odd_surfaces, extremes)
    for number, row in enumerate(itertools.chain(*(part() for part in parts))):
        each = known(*row)
        if number % 3 == 2 and 'far' not in each.about:
            yield each.moved(random_rotation(rng), np.zeros(3))
        else:
            yield each


def inside():
    """Wholly within: a surface alone is as far away as the nearest triangle (fcl#491)."""
    cube, hollow = solid(CUBE), solid(HOLLOW)
    faces = (X, -X, Y, -Y, Z, -Z)
    yield 'sphere in the middle of a cube', cube, ball(0.1, 0.5, 0.5, 0.5), -0.6, *faces
    small = box((0.2,) * 3, 0.5, 0.5, 0.5)
    yield 'cube in the middle of a cube', cube, small, -0.6, *faces
    yield 'sphere in the arm of an L', solid(L), ball(0.1, 0.5, 1.6, 0.5), -0.5, -Y
    yield 'point in the arm of an L', solid(L), ball(0.0, 0.5, 1.6, 0.5), -0.4, -Y
    yield 'sphere in the wall of a ring', solid(RING), ball(0.1, 0.4, 1.5, 0.5), -0.5, X
    yield 'sphere in the shell of a hollow cube', hollow, ball(0.1, 0.6, 1.5, 1.5), -0.5, -X
    yield 'point in the shell', hollow, ball(0.0, 0.4, 1.5, 1.5), -0.4, X
    yield 'sphere in the cavity of a hollow cube', hollow, ball(0.1, 1.5, 1.5, 1.4), 0.3, -Z
    yield 'point in the cavity', hollow, ball(0.0, 1.5, 1.5, 1.5), 0.5, *faces
    yield 'sphere that fills the cavity', hollow, ball(0.5, 1.5, 1.5, 1.5), 0.0
    yield 'box that fills the cavity', hollow, box((1.0,) * 3, 1.5, 1.5, 1.5), 0.0
    large = ball(0.6, 1.5, 1.5, 1.5)
    yield 'sphere too large for the cavity', hollow, large, -2.1, *faces


def in_dents():
    """Free, where the hull is met (drake#14197, moveit#3299)."""
    notch, channel, ring = solid(L), solid(U), solid(RING)
    yield 'sphere in the notch of an L', notch, ball(0.1, *NOTCH), 0.4, -X, -Y
    yield 'point in the notch of an L', notch, ball(0.0, 1.25, 1.5, 0.5), 0.25, -X
    yield 'sphere off the middle of the notch', notch, ball(0.1, 1.3, 1.6, 0.5), 0.2, -X
    yield 'sphere in the channel of a U', channel, ball(0.1, *NOTCH), 0.4, -X, -Y, X
    yield 'box in the channel of a U', channel, box((0.5, 0.5, 1), *NOTCH), 0.25, X, -X, -Y
    yield 'sphere in the hole of a ring', ring, ball(0.1, *NOTCH), 0.4, X, -X, Y, -Y
    yield 'cube in the hole of a ring', ring, box((0.5,) * 3, *NOTCH), 0.25, X, -X, Y, -Y
    pin = body('Capsule', (0.2, 3.0), None, NOTCH)
    yield 'capsule through the hole of a ring', ring, pin, 0.3, X, -X, Y, -Y
    rod = body('Cylinder', (0.375, 3.0), None, NOTCH)
    yield 'cylinder through the hole of a ring', ring, rod, 0.125, X, -X, Y, -Y
    egg = body('Ellipsoid', (0.25, 0.125, 0.375), None, NOTCH)
    yield 'ellipsoid in the hole of a ring', ring, egg, 0.25, X, -X
    points = as_tuples(0.25 * np.vstack([np.eye(3), -np.eye(3)]))
    octahedron = body('Convex', points, None, NOTCH)
    yield 'octahedron in the notch of an L', notch, octahedron, 0.25, -X, -Y
    crossing = body('Box', (0.1, 8.0, 0.1), None, (1.5, 1.5, 1.5))
    yield 'rod over a ring', ring, crossing, 0.45, -Z
    plane = body('HalfSpace', (), None, (0.0, 0.0, -0.25))
    yield 'ring over a floor', plane, ring, 0.25, -Z


def edges_and_rays():
    """Points whose rays along an axis meet an edge, a vertex or a face edge-on (trimesh#85)."""
    notch, cube = solid(L), solid([(0, 0, 0)], [np.array([0.0, 2.0])] * 3)
    diagonal = np.array([1.0, 1.0, 0.0]) / 2**0.5
    yield 'ray along the floor of the notch', notch, ball(0.0, 3.0, 1.0, 0.5), 1.0, -X
    yield 'ray through edges three times', notch, ball(0.0, -1.0, 1.0, 1.0), 1.0, X
    yield 'ray through the inner edge', notch, ball(0.0, 2.0, 2.0, 0.5), 1.0, -X, -Y
    yield 'ray through a vertex', notch, ball(0.0, 0.0, 3.0, 1.0), 1.0, -Y
    yield 'point in the plane of a face', cube, ball(0.0, 3.0, 2.0, 2.0), 1.0, -X
    yield 'point inside, ray through edges', notch, ball(0.0, 0.75, 1.0, 0.5), -0.25, -X
    yield 'point on a face', notch, ball(0.0, 1.5, 1.0, 0.5), 0.0
    yield 'point on the inner edge', notch, ball(0.0, 1.0, 1.0, 0.5), 0.0
    yield 'point on an outer edge', notch, ball(0.0, 2.0, 1.0, 0.5), 0.0
    yield 'point on a vertex', notch, ball(0.0, 1.0, 1.0, 1.0), 0.0
    yield 'point 2^-40 m off a face', notch, ball(0.0, 1.5, 1.0 + 2.0**-40, 0.5), 2.0**-40
    yield 'sphere on the inner edge', notch, ball(0.1, 1.0, 1.0, 0.5), -(0.02**0.5), -diagonal
    yield 'sphere before an outer edge', notch, ball(0.1, 2.3, 1.4, 0.5), 0.4


def touching():
    """Faces flush on faces, in line with others and between them."""
    notch, channel, ring = solid(L), solid(U), solid(RING)
    block = (0.5, 0.5, 1.0)
    yield 'box on the floor of the notch', notch, box(block, 1.5, 1.25, 0.5), 0.0
    yield 'box in the inner edge', notch, box(block, 1.25, 1.25, 0.5), 0.0
    yield 'box that fills the notch', notch, box((1.0,) * 3, *NOTCH), 0.0
    yield 'box that fills the channel', channel, box((1.0,) * 3, *NOTCH), 0.0
    rod = body('Cylinder', (0.5, 1.0), None, NOTCH)
    yield 'cylinder that fills the channel', channel, rod, 0.0
    yield 'box that fills the hole', ring, box((1.0,) * 3, *NOTCH), 0.0
    yield 'sphere that fits in the hole', ring, ball(0.5, *NOTCH), 0.0
    yield 'box in line with an arm', notch, box((1.0,) * 3, 2.5, 0.5, 0.5), 0.0
    yield 'box 2^-10 m over the floor', notch, box(block, 1.5, 1.25 + 2.0**-10, 0.5), 2.0**-10, -Y
    yield 'box 2^-10 m in the floor', notch, box(block, 1.5, 1.25 - 2.0**-10, 0.5), -(2.0**-10), -Y
    yield 'sphere 2^-20 m in a wall', ring, ball(0.25, 1.25 - 2.0**-20, 1.5, 0.5), -(2.0**-20), -X
    yield 'L on a floor', body('HalfSpace', ()), solid(L), 0.0, -Z
    ceiling = body('HalfSpace', (), [[1, 0, 0], [0, 0, -1], [0, 1, 0]], (0.0, 1.75, 0.0))
    yield 'U in a ceiling, channel first', ceiling, solid(U), -0.25, Y


def through():
    """Yield what runs through an arm: the way out is across it, past what is beside it."""
    frame = solid(FRAME)
    along_y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    rod = body('Capsule', (0.125, 3.0), along_y, (2.5, 0.5, 0.75))
    yield 'capsule through an arm of a frame', frame, rod, -0.375, -Z
    plate = box((8.0, 8.0, 0.25), 2.5, 2.5, 0.875)
    yield 'plate through a frame', frame, plate, -0.25, -Z
    ring = solid(RING)
    # It leaves upwards until it rests on the rims of the hole.
    rest = (0.625**2 - 0.5**2) ** 0.5
    yield 'sphere stuck in a hole', ring, ball(0.625, *NOTCH), -(0.5 + rest), Z, -Z


def of_two():
    """Solids with solids: hooked, linked, flush, the same."""
    notch, frame = solid(L), solid(FRAME)
    hooked = solid(L).placed(HALF_TURN, (3.25, 3.25, 0.0))
    yield 'an L in the notch of another', notch, hooked, 0.25 * 2**0.5
    linked = solid(FRAME).placed(TILTED, (7.0, 3.0, -2.0))
    yield 'frames linked as a chain', frame, linked, 1.0
    yield 'an L on an L', notch, solid(L).at((0.0, 0.0, 1.0)), 0.0
    yield 'an L beside an L', notch, solid(L).at((2.0, 0.0, 0.0)), 0.0
    yield 'an L with itself', notch, solid(L), -1.0, Z, -Z
    yield 'a cube in the notch', notch, solid(CUBE).at((1.0, 1.0, 0.0)), 0.0
    apart = solid(CUBE).at((1.25, 1.5, 0.0))
    yield 'a cube off the wall of the notch', notch, apart, 0.25, -X
    into = solid(CUBE).at((1.0 - 2.0**-4, 1.5, 0.0))
    yield 'a cube in the wall of the notch', notch, into, -(2.0**-4), -X
    small = solid(L, scale=0.25).at((1.25, 1.25, 1.25))
    yield 'a small L in the cavity of a cube', solid(HOLLOW), small, 0.25
    for dx, distance in ((1.25, 0.25), (1.0, 0.0), (0.875, -0.125), (0.5, -0.5)):
        moved = solid(CUBE).at((dx, 0.0, 0.0))
        yield f'unit cubes as meshes, dx {dx:g} (fcl#221)', solid(CUBE), moved, distance


def odd_surfaces():
    """Surfaces that mean a body all the same: soup, inside out, needles, sheets without area."""
    vertices, triangles = surface(L, [np.arange(4.0)] * 3)
    inside_out = [t[::-1] for t in triangles]
    free, in_arm = ball(0.1, *NOTCH), ball(0.1, 0.5, 1.6, 0.5)
    turned = Body('Solid', vertices, triangles=inside_out)
    yield 'an L inside out, sphere in the notch', turned, free, 0.4, -X, -Y
    yield 'an L inside out, sphere in an arm', turned, in_arm, -0.5, -Y
    soup = [vertices[i] for t in triangles for i in t]
    of_soup = Body('Solid', soup, triangles=[(k, k + 1, k + 2) for k in range(0, len(soup), 3)])
    yield 'an L as soup, sphere in the notch', of_soup, free, 0.4, -X, -Y
    yield 'an L as soup, sphere in an arm', of_soup, in_arm, -0.5, -Y
    none = [(0, 1, 0), (2, 2, 2)]
    with_none = Body('Solid', vertices, triangles=[*triangles, *none])
    yield 'triangles without area, sphere in an arm', with_none, in_arm, -0.5, -Y
    xs, ys = [0.0, 2.0**-30, 1.0, 2.0], [0.0, 1.0 - 2.0**-30, 1.0, 2.0]
    lines = list(map(np.array, (xs, ys, [0.0, 1.0])))
    needles = solid(flat('###', '###', '##'), lines)
    yield 'needles of 1e-9, sphere in the notch', needles, free, 0.4, -X, -Y
    yield 'needles of 1e-9, sphere in an arm', needles, in_arm, -0.5, -Y
    yield 'needles of 1e-9, point on their tips', needles, ball(0.0, 2.0**-30, 0.0, 0.5), 0.0
    two = solid([(0, 0, 0), (1, 1, 0)])
    yield 'bodies that share an edge', two, ball(0.1, 1.25, 0.5, 0.5), 0.15, X * -1
    two = solid([(0, 0, 0), (1, 1, 1)])
    yield 'bodies that share a corner', two, ball(0.1, 1.5, 0.5, 0.5), 0.4
    between = ball(0.1, 1.5, 1.5, 1.5)
    yield 'three axes and the corner between', solid(CORNER), between, 0.4, -X, -Y, -Z


def extremes():
    """Tiny, huge, far away."""
    for s in (2.0**-20, 2.0**-10, 2.0**10, 2.0**20):
        scaled = solid(L, scale=s)
        yield f'an L of {s:.0e} m', scaled, ball(0.125 * s, 1.5 * s, 1.5 * s, 0.5 * s), 0.375 * s
        inside = ball(0.125 * s, 0.5 * s, 1.5 * s, 0.5 * s)
        yield f'in an L of {s:.0e} m', scaled, inside, -0.625 * s
    away = np.array([2.0**20, -(2.0**20), 2.0**20])
    yield '1e6 m far, sphere in the notch', solid(L).at(away), ball(0.125, *(away + NOTCH)), 0.375
    middle = away + np.array([0.5, 1.5, 0.5])
    yield '1e6 m far, sphere in an arm', solid(L).at(away), ball(0.125, *middle), -0.625
    tiny = ball(2.0**-26, 1.0 + 2.0**-20, 1.5, 0.5)
    yield 'a sphere of 1e-8 m by a wall', solid(L), tiny, 2.0**-20 - 2.0**-26, -X
