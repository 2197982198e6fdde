"""No pixel sees through a closed surface: not along an edge of triangles, nor at a corner."""

import numpy as np
import pytest
from geometry.render.scenes import NAME, images, random_pose, scene_of

from drake_geom_ros.geometry import (
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    OccupiedCells,
    RenderCameraCore,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensors import CameraInfo

PIXELS, FOCAL = 64, 64.0


def depths(shape, X_WS, X_WC, centre, focal=FOCAL):
    """Return the depths (PIXELS, PIXELS) of a shape that fills the image."""
    info = CameraInfo(PIXELS, PIXELS, focal, focal, centre, centre)
    core = RenderCameraCore(NAME, info, ClippingRange(0.01, 100.0), RigidTransform())
    scene, _ = scene_of([(shape, X_WS)])
    camera = DepthRenderCamera(core, DepthRange(0.02, 90.0))
    return images(scene, camera, X_WC, want=('depth',)).depth.data[..., 0]


@pytest.mark.parametrize('offset', [0.0, -3.0, 1e3, 1e5])
@pytest.mark.parametrize('resolution', [0.1, 0.05, 0.03, 1.0 / 30.0])
def test_no_ray_passes_a_wall_of_cells(resolution, offset):
    """Seen straight on, so that rays go through corners; the camera is anywhere in the world."""
    rng = np.random.default_rng(7)
    for centre, away in ((31.5, 0.5), (32.0, 1.0), (31.5, 2.0), (31.5, 0.53)):
        distance = FOCAL * resolution * away
        half = int(0.5 * FOCAL * away) + 3
        along = (np.arange(-half, half) + 0.5) * resolution
        wall = np.stack(np.meshgrid(along, along, [distance + 0.5 * resolution]), -1)
        shape = OccupiedCells(resolution, wall.reshape(-1, 3) + offset)
        for X_WC in (RigidTransform(), random_pose(rng, 1.0)):
            X_WM = X_WC @ RigidTransform(np.full(3, -offset))
            told = depths(shape, X_WM, X_WC, centre)
            np.testing.assert_allclose(told, distance, rtol=1e-6, atol=1e-14 * abs(offset))


@pytest.mark.parametrize('is_turned', [False, True])
def test_no_ray_passes_a_corner_of_triangles(is_turned):
    """Each pixel's ray goes through a corner of six triangles, none of them in one plane."""
    rng = np.random.default_rng(int(is_turned))
    slopes = (np.arange(-2, PIXELS + 2) + 0.5 - 31.0) / FOCAL
    xs, ys = np.meshgrid(slopes, slopes)
    zs = rng.uniform(1.0, 2.0, xs.shape)
    corners = np.stack((xs * zs, ys * zs, zs), -1).reshape(-1, 3)
    numbers = np.arange(zs.size).reshape(zs.shape)
    a, b, c, d = (
        part.ravel()
        for part in (numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:])
    )
    triangles = np.vstack((np.stack((a, c, b), 1), np.stack((a, d, c), 1)))
    X_WC = random_pose(rng, 1.0) if is_turned else RigidTransform()
    told = depths((corners, triangles), X_WC, X_WC, 31.0)
    np.testing.assert_allclose(told, zs[2:-2, 2:-2], rtol=1e-6)
