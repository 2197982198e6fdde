import numpy as np
import pytest

from drake_geom_ros.ros.demo.surfaces import faces_of

SHAPES = {
    'sphere': (1, (0.3,), 4 / 3 * np.pi * 0.3**3),
    'box': (2, (0.3, 0.25, 0.55), 0.3 * 0.25 * 0.55),
    'capsule': (3, (0.2, 0.5), np.pi * 0.2**2 * 0.5 + 4 / 3 * np.pi * 0.2**3),
    'cylinder': (4, (0.2, 0.5), np.pi * 0.2**2 * 0.5),
    'ellipsoid': (5, (0.1, 0.2, 0.4), 4 / 3 * np.pi * 0.1 * 0.2 * 0.4),
}


def _off_surface(kind, d, p):
    """How far points (n, 3) are off the surface, zero on it."""
    if kind == 1:
        return np.linalg.norm(p, axis=1) - d[0]
    if kind == 2:
        return np.max(np.abs(p) - np.array(d) / 2, axis=1)
    if kind == 3:
        z = np.clip(p[:, 2], -d[1] / 2, d[1] / 2)
        return np.linalg.norm(p - z[:, None] * [0, 0, 1], axis=1) - d[0]
    if kind == 4:
        return np.maximum(np.hypot(p[:, 0], p[:, 1]) - d[0], np.abs(p[:, 2]) - d[1] / 2)
    return np.sum((p / d) ** 2, axis=1) - 1.0


@pytest.mark.parametrize('name', SHAPES)
def test_corners_lie_on_the_surface(name):
    kind, dimensions, _ = SHAPES[name]
    corners = np.concatenate(faces_of(kind, dimensions))
    np.testing.assert_allclose(_off_surface(kind, dimensions, corners), 0.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize('name', SHAPES)
def test_faces_are_closed_and_wound_outwards(name):
    """The flux of x / 3 through all faces is the volume: gaps or a wrong winding spoil it."""
    kind, dimensions, volume = SHAPES[name]
    enclosed = 0.0
    total_area = np.zeros(3)
    for face in faces_of(kind, dimensions):
        for a, b, c in ((face[0], face[1], face[2]), (face[0], face[2], face[3])):
            area = np.cross(b - a, c - a) / 2
            enclosed += area @ (a + b + c) / 9
            total_area += area
    np.testing.assert_allclose(total_area, 0.0, rtol=0, atol=1e-12)
    assert 0.94 * volume < enclosed < volume * (1 + 1e-12)


@pytest.mark.parametrize('kind', [6, 7, 8])
def test_what_has_no_extent_to_show_has_no_faces(kind):
    assert faces_of(kind, (1.0,)) == []
