"""Round shapes that overlap though their coarse meshes do not: told as points, never lost."""

import numpy as np
import pytest
from batch.test_contacts import COMPLIANT, RIGID, Pressing, same
from oracles.contact_scenes import Body, query_of

from drake_geom_ros.geometry import HalfSpace, Sphere
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface

UPRIGHT = np.eye(3)
# The octahedron in a ball misses a plane at right angles to its faces' normals.
ACROSS = np.array(
    [np.array([1, -1, 0]) / 2**0.5, np.array([1, 1, -2]) / 6**0.5, np.array([1, 1, 1]) / 3**0.5]
)


def coarse(hint, height=0.65, second=None):
    plane = second or Body('HalfSpace', (), 0.0)
    poses = [(UPRIGHT, np.zeros(3)), (ACROSS, np.array([0, 0, height]))]
    return query_of([plane, Body('Sphere', (1.0,), 1e5, hint)], poses)


@pytest.mark.parametrize(
    'second',
    [
        Body('HalfSpace', (), 0.0),
        Body('HalfSpace', (), 1e9, 0.1),
        Body('Convex', tuple(8 * np.array([(1, 1, 0), (1, -1, 0), (-1, 0, 0), (0, 0, -1)])), 0.0),
    ],
    ids=['rigid plane', 'slab', 'hull'],
)
def test_what_a_mesh_misses_is_a_point_pair(second):
    query, ids, _ = coarse(10.0, second=second)
    assert len(query.ComputeContactSurfaces()) == len(query.contact_surfaces()) == 0
    surfaces, points = query.ComputeContactSurfacesWithFallback()
    assert (len(surfaces), points) == (0, [])  # as in Drake
    contacts = query.contacts()
    assert len(contacts.surfaces) == 0
    (point,) = contacts.others
    assert {point.id_A, point.id_B} == set(ids)
    assert point.depth == pytest.approx(0.35, rel=1e-9)
    assert contacts.reasons.tolist() == [NoSurface.TOO_COARSE]


def test_a_finer_mesh_has_a_surface_and_what_is_apart_has_nothing():
    fine = coarse(0.3)[0].contacts()
    assert (len(fine.surfaces), len(fine.others)) == (1, 0)
    for height in (1.0, 1.001):
        apart = coarse(10.0, height)[0].contacts()
        assert (len(apart.surfaces), len(apart.others)) == (0, 0)


def test_a_mesh_that_counts_as_its_hull_tells_nothing_of_what_is_in_a_hollow_of_it():
    # A ball in a corner of two walls, in their hull, and far from both.
    vertices = np.array([(0, 0, 0), (9, 0, 0), (9, 0, 9), (0, 9, 0), (0, 9, 9), (0, 0, 9)], float)
    walls = [(0, 1, 2), (0, 2, 5), (0, 5, 4), (0, 4, 3)]
    mesh, ball = Body('Mesh', (vertices, walls), 0.0), Body('Sphere', (0.5,), 1e5, 10.0)
    with pytest.warns(UserWarning, match='bounds no solid'):
        query = query_of([mesh, ball], [(UPRIGHT, np.zeros(3)), (UPRIGHT, [4, 4, 5])])[0]
    assert len(query.ComputePointPairPenetration()) == 1
    assert not query.contacts().others


@pytest.mark.parametrize('padding', [0.0, 0.05])
def test_batches_tell_it_and_know_the_area(padding):
    scene = Pressing([(HalfSpace(), RIGID), (Sphere(0.05), COMPLIANT)], padding)
    states = np.zeros((4, 2, 7))
    states[..., 6] = 1.0
    states[:, 1, 3:] = 0.8, 0.2, 0.4, 0.4  # on none of its corners
    states[:, 1, 2] = 0.07, 0.0499, 0.03, 0.2
    found = scene.evaluated(states)
    assert found.reason.tolist() == [NoSurface.TOO_COARSE]
    assert np.diff(found.point_offsets).tolist() == [0, 1, 0, 0]  # padding makes none
    assert found.depth[0] == pytest.approx(0.0001 + 2 * padding, rel=1e-6)
    assert (found.total_areas() > 0.0).tolist() == [False, False, True, False]
    _, others, why = scene.contacts(states[1])
    assert same([found.depth, found.reason], [others.depth, why])
