"""Distances of surfaces: every triangle with forty digits, and python-fcl as another opinion."""

import fcl  # noqa: TID251 (another opinion, not used by the project)
import numpy as np
import pytest
import trimesh
from oracles.forms import row_of
from oracles.solids import solid

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.cross_check.fcl_peer import fcl_shape
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from truth.bodies import grids
from truth.bodies.random_bodies import random_rotation
from truth.references.meshes import signed_distance

NAMES = ('L', 'U', 'ring')


def test_points_and_balls_against_every_triangle():
    mesh = trimesh.creation.torus(1.0, 0.3, major_sections=12, minor_sections=6)
    torus = Body('Solid', mesh.vertices, triangles=mesh.faces)
    for q in np.random.default_rng(5).uniform(-1.5, 1.5, (12, 3)) * [1, 1, 0.4]:
        truth = signed_distance(Body('Point', p=q), torus)
        for radius in (0.0, 0.5 * truth):
            if radius < 0.0:
                continue
            out = row_of(Body('Sphere', (radius,), p=q), torus)
            assert abs(out[0] - (truth - radius)) <= out[calling.ERROR_BOUND]
            assert out[calling.ERROR_BOUND] <= 2e-14


def fcl_distance(A, B):
    """FCL's unsigned distance of two surfaces."""
    objects = [fcl.CollisionObject(fcl_shape(x.shape), fcl.Transform(x.R, x.p)) for x in (A, B)]
    return fcl.distance(*objects, fcl.DistanceRequest(), fcl.DistanceResult())


@pytest.mark.parametrize('other', ['box', 'solid'])
def test_fcl_is_of_the_same_opinion(other):
    """Its distance of triangles is exact to rounding, and knows no inside: apart only."""
    rng = np.random.default_rng(6)
    apart = 0
    for _ in range(80):
        B = solid(NAMES[rng.integers(3)])
        R, p = random_rotation(rng), rng.uniform(-2, 5, 3)
        A = mesh = solid('U', 0.5).placed(R, p)
        if other == 'box':
            A = Body('Box', rng.uniform(0.1, 1.0, 3), R, p)
            lines = [np.array([-0.5, 0.5]) * length for length in A.size]
            mesh = grids.solid(grids.CUBE, lines).placed(R, p)
        out = row_of(A, B)
        if out[0] > 1e-3:
            apart += 1
            assert fcl_distance(mesh, B) == pytest.approx(out[0], abs=1e-12)
    assert apart >= 20
