"""Gradients of the distance to a point where faces meet: the mean of the normals that adjoin."""

import itertools

import numpy as np
import pytest
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    Box,
    Cylinder,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw

POSES = {
    'identity': RigidTransform(),
    'turned': RigidTransform(RollPitchYaw(0.3, -1.2, 2.0), [1.0, -2.0, 0.5]),
    'far': RigidTransform(RollPitchYaw(1.0, 0.5, -0.7), [1e4, -3e4, 2e4]),
}
BOX = Box(1.0, 2.0, 0.5)
RADIUS, LENGTH = 0.3, 1.2
BEYOND = 1e-9  # [m] more than rounding, within 1 m


def asked(shape, X_WG, p_GQs):
    """Return distances (n,), gradients (n, 3) in G, and which are unique (n,), at points of G."""
    query = ShapeScene(shape).posed(X_WG).query
    p_WQs = X_WG.multiply(np.asarray(p_GQs, dtype=float).T).T
    found = query.ComputeSignedDistanceToPoint(p_WQs)
    assert found.point_index.tolist() == list(range(len(p_WQs)))
    return found.distance, found.grad_W @ X_WG.rotation().matrix(), found.is_grad_W_unique


def creases_of_a_box():
    """Yield the points and the mean normals of all corners, and of a place on each edge."""
    for signs in itertools.product((-1.0, 0.0, 1.0), repeat=3):
        faces = np.count_nonzero(signs)
        if faces > 1:
            along = 0.3 * (np.array(signs) == 0.0)
            yield (signs + along) * BOX.size() / 2, np.array(signs) / np.sqrt(faces)


def rims_of_a_cylinder():
    """Yield points and mean normals around both rims."""
    for angle, side in itertools.product(np.linspace(0.0, 6.0, 7), (-1.0, 1.0)):
        radial = np.array([np.cos(angle), np.sin(angle), 0.0])
        axial = np.array([0.0, 0.0, side])
        yield RADIUS * radial + 0.5 * LENGTH * axial, (radial + axial) / np.sqrt(2.0)


CREASES = {
    'box': (BOX, tuple(creases_of_a_box())),
    'cylinder': (Cylinder(RADIUS, LENGTH), tuple(rims_of_a_cylinder())),
}


def test_the_unit_cube_of_the_documentation():
    p_GQs = [[0.5, 0.5, 0.5], [0.5, 0.5, 0.0], [0.5, 0.0, -0.5]]
    distances, grads, unique = asked(Box(1, 1, 1), RigidTransform(), p_GQs)
    thirds, halves = 3**-0.5, 2**-0.5
    expected = [[thirds] * 3, [halves, halves, 0.0], [halves, 0.0, -halves]]
    np.testing.assert_allclose(grads, expected, rtol=0, atol=1e-15)
    assert distances.tolist() == [0.0] * 3
    assert not unique.any()


@pytest.mark.parametrize('pose', POSES)
@pytest.mark.parametrize('name', CREASES)
def test_where_faces_meet_it_is_the_mean_of_their_normals(name, pose):
    shape, creases = CREASES[name]
    p_GQs, normals = (np.array(side) for side in zip(*creases, strict=True))
    distances, grads, unique = asked(shape, POSES[pose], p_GQs)
    np.testing.assert_allclose(grads, normals, rtol=0, atol=1e-9 if pose == 'far' else 1e-14)
    np.testing.assert_allclose(distances, 0.0, rtol=0, atol=1e-10)
    assert not unique.any()


@pytest.mark.parametrize('side', [-1.0, 1.0])
def test_on_a_face_it_is_that_of_the_face_alone(side):
    on_box = side * np.array([[0.5, 0.3, -0.1], [0.2, 1.0, 0.1], [-0.4, 0.7, 0.25]])
    on_cylinder = np.array([[0.0, side * RADIUS, 0.2], [0.1, -0.1, side * 0.5 * LENGTH]])
    for shape, p_GQs in ((BOX, on_box), (Cylinder(RADIUS, LENGTH), on_cylinder)):
        _, grads, unique = asked(shape, RigidTransform(), p_GQs)
        faces = (0, 1, 2) if shape is BOX else (1, 2)
        np.testing.assert_allclose(grads, side * np.eye(3)[list(faces)], rtol=0, atol=1e-15)
        assert unique.all()


@pytest.mark.parametrize('name', CREASES)
def test_beside_an_edge_it_is_that_of_the_face_and_beyond_it_points_away(name):
    """Rounding is not what decides here, so neither does the mean."""
    shape, creases = CREASES[name]
    for p_GC, normal in creases:
        towards = np.array([-normal[0], -normal[1], -normal[2]])
        out = p_GC - BEYOND * towards
        ((distance,), (grad,), (unique,)) = asked(shape, RigidTransform(), [out])
        assert unique
        assert distance == pytest.approx(BEYOND, rel=1e-6)
        np.testing.assert_allclose(grad, normal, rtol=0, atol=1e-6)
        for k in np.flatnonzero(normal):
            beside = p_GC.copy()
            beside[k] *= 1.0 - BEYOND / abs(p_GC[k])
            if name == 'cylinder' and k < 2:
                beside[:2] = (1.0 - BEYOND / RADIUS) * p_GC[:2]
            ((distance,), (grad,), _) = asked(shape, RigidTransform(), [beside])
            assert distance == pytest.approx(0.0, abs=1e-15)
            assert np.abs(grad - normal).max() > 0.1
