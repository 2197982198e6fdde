"""Mesh bodies: closed, not convex, as fine as asked for, and the same in every process."""

import pickle

import numpy as np
import pytest

from drake_geom_ros.evidence.accuracy.mesh_bodies import CUTS, SURFACES, UNIT, mesh_body
from drake_geom_ros.geometry._proximity.pair_table import SOLID
from drake_geom_ros.geometry._solid_mesh import merged, solid_of, volume

names = pytest.mark.parametrize('name', SURFACES)


@names
@pytest.mark.parametrize('resolution', CUTS)
def test_a_surface_is_about_as_fine_as_asked_for(name, resolution):
    corners = mesh_body(name, resolution).corners
    assert 0.7 * resolution < len(corners) < 1.2 * resolution
    vertices, triangles = merged(
        corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3)
    )
    # Euler's formula: a closed surface without handles.
    assert len(vertices) - len(triangles) // 2 == 2
    assert volume(corners) > 0.0


@names
def test_it_is_a_solid_with_dents(name):
    solid = mesh_body(name, 100).shape
    kind, _ = solid_of(solid.mesh_data(), (1.0, 1.0, 1.0))
    hull = solid.hull_surface()
    assert kind == SOLID
    assert volume(mesh_body(name, 100).corners) < 0.99 * volume(hull[0][hull[1]])


def test_the_l_is_the_union_of_its_boxes():
    body = mesh_body('L', 1300)
    assert volume(body.corners) == pytest.approx(3.0 * UNIT**3, rel=1e-12)
    points = body.corners.mean(axis=1)
    heights = [np.abs(points - middle) - 0.5 * np.array(box.sizes) for box, middle in body.boxes()]
    on_surface = np.min([height.max(axis=1) for height in heights], axis=0)
    np.testing.assert_allclose(on_surface, 0.0, atol=1e-16)
    assert mesh_body('Ball', 100).boxes() == []


@names
def test_pickled_it_is_the_one_that_the_process_has(name):
    body = mesh_body(name, 100)
    assert pickle.loads(pickle.dumps(body)) is body
    assert len(pickle.dumps(body)) < 200
