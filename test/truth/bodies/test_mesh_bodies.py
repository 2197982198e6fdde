"""Mesh bodies are closed solids with dents, and as fine as their name says."""

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry.meshes._solids import solid_of, volume
from drake_geom_ros.geometry.meshes._welding import merged
from truth.bodies.mesh_bodies import CUTS, MAKERS, UNIT, mesh_body

names = pytest.mark.parametrize('name', MAKERS)


@names
@pytest.mark.parametrize('resolution', CUTS)
def test_a_surface_is_about_as_fine_as_asked_for(name, resolution):
    corners = mesh_body(name, resolution).corners
    assert 0.7 * resolution < len(corners) < 1.2 * resolution
    vertices, triangles = merged(
        mesh_body(name, resolution).size, mesh_body(name, resolution).triangles
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
    heights = [np.abs(points - box.p) - 0.5 * np.array(box.size) for box in body.parts]
    on_surface = np.min([height.max(axis=1) for height in heights], axis=0)
    np.testing.assert_allclose(on_surface, 0.0, rtol=0, atol=1e-16)
    assert mesh_body('Ball', 100).parts == ()
