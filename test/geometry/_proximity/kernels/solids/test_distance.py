"""Distances of surfaces: every triangle with fifty digits, and python-fcl as another opinion."""

import fcl  # noqa: TID251 (another opinion, not used by the project)
import mpmath
import numpy as np
import pytest
import trimesh
from oracles.forms import row_of
from oracles.solids import solid, surface_of

from drake_geom_ros.evidence.bodies import Body
from drake_geom_ros.evidence.random_bodies import random_rotation
from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling

NAMES = ('L', 'U', 'ring')


def point_triangle(q, corners):
    """The distance of a point and a triangle, by the least of plane, edges and corners."""
    q, a, b, c = (mpmath.matrix(v.tolist()) for v in (q, *corners))

    def dot(u, v):
        return (u.T * v)[0]

    best = mpmath.inf
    for u, v in ((a, b), (b, c), (c, a)):
        d = v - u
        t = min(max(dot(q - u, d) / dot(d, d), 0), 1)
        best = min(best, mpmath.norm(q - u - t * d))
    ab, ac, aq = b - a, c - a, q - a
    g = mpmath.matrix([[dot(ab, ab), dot(ab, ac)], [dot(ab, ac), dot(ac, ac)]])
    s, t = mpmath.lu_solve(g, mpmath.matrix([dot(aq, ab), dot(aq, ac)]))
    if s >= 0 and t >= 0 and s + t <= 1:
        best = min(best, mpmath.norm(aq - s * ab - t * ac))
    return best


def test_points_and_balls_against_every_triangle():
    mesh = trimesh.creation.torus(1.0, 0.3, major_sections=12, minor_sections=6)
    torus = Body('Solid', mesh.vertices, triangles=mesh.faces)
    for q in np.random.default_rng(5).uniform(-1.5, 1.5, (12, 3)) * [1, 1, 0.4]:
        with mpmath.workdps(50):
            distances = [point_triangle(q, np.asarray(mesh.vertices)[f]) for f in mesh.faces]
            truth = float(min(distances))
        inside = bool(row_of(Body('Sphere', (0.0,), p=q), torus)[0] < 0.0)
        for radius in (0.0, 0.5 * truth):
            if inside and radius:
                continue
            out = row_of(Body('Sphere', (radius,), p=q), torus)
            expected = -truth if inside else truth - radius
            assert abs(out[0] - expected) <= out[calling.ERROR_BOUND]
            assert out[calling.ERROR_BOUND] <= 2e-14


def fcl_distance(A, R, p, B):
    """FCL's unsigned distance of two surfaces, A turned and moved."""
    objects = []
    for mesh, transform in ((A, fcl.Transform(R, p)), (B, fcl.Transform())):
        model = fcl.BVHModel()
        model.beginModel(len(mesh.vertices), len(mesh.triangles))
        model.addSubModel(mesh.vertices, mesh.triangles)
        model.endModel()
        objects.append(fcl.CollisionObject(model, transform))
    return fcl.distance(*objects, fcl.DistanceRequest(), fcl.DistanceResult())


CORNERS = np.array(list(np.ndindex(2, 2, 2)), dtype=float) - 0.5
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


@pytest.mark.parametrize('other', ['box', 'solid'])
def test_fcl_is_of_the_same_opinion(other):
    """Its distance of triangles is exact to rounding, and knows no inside: apart only."""
    rng = np.random.default_rng(6)
    apart = 0
    for _ in range(80):
        name, R, p = NAMES[rng.integers(3)], random_rotation(rng), rng.uniform(-2, 5, 3)
        B, surface = solid(name), surface_of(name)
        if other == 'box':
            size = rng.uniform(0.1, 1.0, 3)
            A, mesh = Body('Box', size, R, p), MeshData(CORNERS * size, CUBE)
        else:
            A = solid('U', 0.5).placed(R, p)
            mesh = MeshData(A.size, A.triangles)
        out = row_of(A, B)
        if out[0] > 1e-3:
            apart += 1
            assert fcl_distance(mesh, R, p, surface) == pytest.approx(out[0], abs=1e-12)
    assert apart >= 20
