"""Depth and label of pixels against rays that are solved in 50 digits."""

import math

import numpy as np
import pytest
from geometry.render.rays import first_met
from geometry.render.scenes import (
    KINDS,
    NAME,
    images,
    looking,
    random_pose,
    random_shape,
    scene_of,
    slopes,
)

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    ClippingRange,
    Cylinder,
    DepthRange,
    DepthRenderCamera,
    Ellipsoid,
    HalfSpace,
    RenderCameraCore,
    RenderLabel,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.sensors import CameraInfo

RELATIVE = 1e-6  # of depth: float32 holds 6e-8
SILHOUETTE = 1e-9  # [-] of a ray's slope: nearer to an edge of a body either side is right


def camera(width=32, height=24, fov_y=0.9, near=0.01, far=1e9):
    core = RenderCameraCore(NAME, CameraInfo(width, height, fov_y), ClippingRange(near, far))
    return DepthRenderCamera(core, DepthRange(near, far))


def judged(bodies, pixel, depth, label, cam, X_WC):
    """Return whether a pixel is right: as its ray, or as one that is next to it."""
    core = cam.core()
    x, y = slopes(core, *pixel)
    steps = [(0, 0)] + [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    told = []
    for i, j in steps:
        slope = x + i * SILHOUETTE, y + j * SILHOUETTE
        true, index = first_met(bodies, X_WC, slope, core.clipping().near(), core.clipping().far())
        right = int(RenderLabel.kEmpty) if index is None else index
        told.append((float(true), right))
        if right != label:
            continue
        if math.isinf(true):
            return depth == math.inf
        if abs(depth - true) <= RELATIVE * true:
            return True
    raise AssertionError(f'pixel {pixel}: {depth} of {label}, and it is {told[0]}')


def check(bodies, cam, X_WC, pixels):
    scene, _ = scene_of(bodies)
    made = images(scene, cam, X_WC, ('depth', 'label'))
    for u, v in pixels:
        depth, label = float(made.depth.data[v, u, 0]), int(made.label.data[v, u, 0])
        judged(bodies, (u, v), depth, label, cam, X_WC)
    return made


def sample(random, cam, count):
    size = cam.core().intrinsics()
    columns = random.integers(0, size.width(), count).tolist()
    return list(zip(columns, random.integers(0, size.height(), count).tolist(), strict=True))


@pytest.mark.parametrize('seed', range(4))
def test_random_scenes_of_all_shapes(seed):
    random = np.random.default_rng(seed)
    kinds = [kind for kind in KINDS if kind != 'half_space'] * 2
    bodies = [(random_shape(random, kind), random_pose(random, 1.0)) for kind in kinds]
    bodies.append((HalfSpace(), RigidTransform([0.0, 0.0, -1.5])))
    X_WC = looking(random.uniform([-3, -3, 0], [3, 3, 6]), [0, 0, 0])
    made = check(bodies, camera(), X_WC, sample(random, camera(), 60))
    assert len(np.unique(made.label.data)) > 5


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('size', [1e-6, 1.0, 1e3])
def test_one_body_of_any_size_seen_full(kind, size):
    random = np.random.default_rng(7)
    bodies = [(random_shape(random, kind, size), random_pose(random, 0.1 * size))]
    X_WC = looking(np.array([2.0, 0.5, 1.0]) * size, [0, 0, 0])
    cam = camera(16, 12, near=1e-3 * size, far=1e3 * size)
    check(bodies, cam, X_WC, [(u, v) for u in range(1, 16, 3) for v in range(1, 12, 3)])


@pytest.mark.parametrize('kind', [kind for kind in KINDS if kind != 'half_space'])
@pytest.mark.parametrize(('size', 'distance'), [(1.0, 1e6), (1e-3, 2e4)])
def test_bodies_far_away(kind, size, distance):
    """A body over all of the image, a million and more times its size away."""
    random = np.random.default_rng(3)
    bodies = [(random_shape(random, kind, size), random_pose(random, 0.1 * size))]
    X_WC = looking(np.array([0.6, -0.8, 0.01]) * distance, [0, 0, 0])
    cam = camera(16, 12, fov_y=0.5 * size / distance, near=1.0)
    made = check(bodies, cam, X_WC, [(u, v) for u in range(1, 16, 2) for v in range(1, 12, 2)])
    assert (made.label.data == 0).sum() > 10


@pytest.mark.parametrize('kind', [kind for kind in KINDS if kind not in ('half_space', 'mesh')])
def test_a_camera_within_a_body_sees_it_from_inside(kind):
    random = np.random.default_rng(5)
    bodies = [(random_shape(random, kind), random_pose(random, 0.02))]
    cam = camera(12, 9, fov_y=2.0, near=1e-3)
    made = check(bodies, cam, RigidTransform(), sample(random, cam, 40))
    assert (made.label.data == 0).all()


@pytest.mark.parametrize('kind', KINDS)
def test_bodies_that_cross_the_near_plane_are_open_there(kind):
    random = np.random.default_rng(11)
    bodies = [(random_shape(random, kind), RigidTransform(RollPitchYaw(0.3, 0.4, 0.5), [0, 0, 1]))]
    cam = camera(20, 15, near=0.95)
    check(bodies, cam, RigidTransform(), sample(random, cam, 80))


@pytest.mark.parametrize('degrees', [1e-4, 90.0, 179.0])
def test_frusta_from_needle_to_plane(degrees):
    random = np.random.default_rng(2)
    kinds = [kind for kind in KINDS if kind != 'half_space']
    bodies = [(random_shape(random, kind, 3.0), random_pose(random, 3.0)) for kind in kinds]
    bodies.append((HalfSpace(), RigidTransform([0.0, 0.0, -2.0])))
    cam = camera(24, 20, fov_y=math.radians(degrees), near=1e-3)
    check(bodies, cam, looking([5.0, 1.0, 2.0], [0, 0, 0]), sample(random, cam, 60))


def test_tangent_rays_and_rays_along_faces():
    """The middle ray, exactly along +z, touches or runs in a face: either answer, but one."""
    info = CameraInfo(3, 3, 10.0, 10.0, 1.5, 1.5)
    cam = DepthRenderCamera(
        RenderCameraCore(NAME, info, ClippingRange(0.1, 100.0)), DepthRange(0.1, 100.0)
    )
    aside = RigidTransform([1.0, 0.0, 5.0])
    for shape in (
        Sphere(1.0),
        Box(2, 2, 2),
        Cylinder(1.0, 2.0),
        Capsule(1.0, 2.0),
        Ellipsoid(1.0, 2.0, 3.0),
        HalfSpace(),
        (
            np.array([[-1.0, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0]]),
            np.array([[0, 1, 2], [0, 2, 3]]),
        ),
    ):
        check(
            [(shape, aside)], cam, RigidTransform(), [(u, v) for u in range(3) for v in range(3)]
        )


def test_no_ray_slips_between_two_triangles():
    """A fan of slivers around points that rays hit exactly, and edges along rows of pixels."""
    random = np.random.default_rng(1)
    angles = np.sort(random.uniform(0, 2 * np.pi, 60))
    rim = np.column_stack((np.cos(angles), np.sin(angles), random.uniform(0.0, 0.3, 60)))
    points = np.concatenate([[[0.0, 0.0, 0.0]], 4.0 * rim])
    faces = np.array([[0, 1 + k, 1 + (k + 1) % 60] for k in range(60)])
    info = CameraInfo(101, 101, 100.0, 100.0, 50.5, 50.5)
    cam = DepthRenderCamera(
        RenderCameraCore(NAME, info, ClippingRange(0.1, 100.0)), DepthRange(0.1, 100.0)
    )
    scene, _ = scene_of([((points, faces), RigidTransform([0, 0, 2.0]))])
    assert (images(scene, cam).label.data == 0).all()
    scene, _ = scene_of([((points, faces), RigidTransform([3e5, 0, 1e6]))])
    far = RigidTransform([3e5 - 1e-3, 0, 1e6 - 2.0])
    assert (images(scene, cam, far).label.data == 0).all()


def test_slivers_seen_edge_on():
    """Triangles of 1e-12 m, and ones that the camera is in the plane of."""
    thin = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1e-12, 0.0]])
    edge_on = np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    face = np.array([[0, 1, 2]])
    bodies = [((p, face), RigidTransform([0.0, 0.0, 3.0])) for p in (thin, edge_on)]
    cam = camera(9, 9)
    check(bodies, cam, RigidTransform(), [(u, v) for u in range(9) for v in range(9)])


def test_of_coplanar_faces_one_is_shown():
    """Two boxes of one face: each pixel has the depth of it and the label of one of them."""
    bodies = [(Box(1, 1, 1), RigidTransform([0.2 * k, 0.0, 2.0])) for k in range(2)]
    scene, _ = scene_of(bodies)
    made = images(scene, camera(fov_y=0.4))
    assert set(np.unique(made.label.data)) <= {0, 1}
    np.testing.assert_allclose(made.depth.data, 1.5, rtol=RELATIVE)
