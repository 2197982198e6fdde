"""Extruded outlines: volume by the shoelace formula, orientation, solids with notches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import ArgumentError, CalcVolume, Mesh
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID
from drake_geom_ros.geometry.meshes._solids import solid_of
from drake_geom_ros.geometry.shapes.extrusion import extruded

ARROW = [[0, 0], [2, 1], [0, 2], [1, 1]]
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
ONES = (1.0, 1.0, 1.0)


@pytest.mark.parametrize('turned', [False, True])
@pytest.mark.parametrize('closed', [False, True])
def test_a_notch_stays_out(turned, closed):
    outline = ARROW[::-1] if turned else ARROW
    mesh = extruded([*outline, outline[0]] if closed else outline, 0.5)
    assert len(mesh.vertices) == 8
    assert CalcVolume(Mesh.FromMeshData(mesh)) == pytest.approx(0.5 * 1.0, rel=1e-15)
    assert solid_of(mesh, ONES)[0] == SOLID
    assert solid_of(extruded(SQUARE, 0.5), ONES)[0] == CONVEX


@given(st.lists(st.floats(0.2, 3.0), min_size=3, max_size=12), st.floats(0.1, 5.0))
def test_the_volume_is_the_area_times_the_height(radii, height):
    """Outlines that are seen whole from the origin."""
    angles = np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False)
    outline = np.array(radii)[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    ahead = np.roll(outline, -1, axis=0)
    area = 0.5 * (outline[:, 0] * ahead[:, 1] - ahead[:, 0] * outline[:, 1]).sum()
    volume = CalcVolume(Mesh.FromMeshData(extruded(outline, height)))
    assert volume == pytest.approx(area * height, rel=1e-12)


@pytest.mark.parametrize(
    ('outline', 'height', 'fault'),
    [
        (SQUARE[:2], 1.0, '2 points'),
        ([*SQUARE[:2], SQUARE[0]], 1.0, '2 points'),
        (SQUARE, 0.0, 'height 0.0'),
        ([[0, 0], [1, 1], [2, 2]], 1.0, 'no area'),
        ([[0, 0], [1, np.nan], [2, 2]], 1.0, 'three finite points'),
    ],
)
def test_what_bounds_nothing_is_refused(outline, height, fault):
    with pytest.raises(ArgumentError, match=fault):
        extruded(outline, height)
