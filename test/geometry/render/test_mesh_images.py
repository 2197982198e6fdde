"""Meshes in images: their own triangles, in the colours of their files."""

import io

import numpy as np
import pytest
import trimesh
from geometry.render.scenes import NAME, images, instance, properties, scene_of
from oracles.mesh_files import gltf

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import Convex, InMemoryMesh, Mesh, MeshData, RenderLabel
from drake_geom_ros.geometry.render import DepthCameraProperties
from drake_geom_ros.math import RigidTransform

CAMERA = DepthCameraProperties(40, 30, 0.8, NAME, 0.1, 100.0)
EMPTY = int(RenderLabel.kEmpty)


def ring():
    return trimesh.creation.torus(1.0, 0.3, major_sections=24, minor_sections=12)


def test_a_mesh_shows_its_own_triangles_and_convex_its_hull():
    mesh = ring()
    data = MeshData(mesh.vertices, mesh.faces)
    for shape, seen in ((Mesh.FromMeshData(data), EMPTY), (Convex.FromMeshData(data), 0)):
        scene, _ = scene_of([(shape, RigidTransform([0, 0, 4.0]))])
        assert images(scene, CAMERA).label.at(20, 15)[0] == seen


def test_depth_against_rays_of_trimesh():
    """A ray caster of another hand, with tolerances of its own."""
    mesh = ring()
    X_WG = RigidTransform([0.1, 0.05, 4.0])
    scene, _ = scene_of([((mesh.vertices, mesh.faces), X_WG)])
    depth = images(scene, CAMERA).depth.data[..., 0]
    v, u = np.mgrid[0:30, 0:40].reshape(2, -1)
    f = 15.0 / np.tan(0.4)
    rays = np.column_stack(((u + 0.5 - 19.5) / f, (v + 0.5 - 14.5) / f, np.ones(len(u))))
    mesh.apply_translation(X_WG.translation())
    caster = trimesh.ray.ray_triangle.RayMeshIntersector(mesh)
    points, ray, _ = caster.intersects_location(np.zeros_like(rays), rays, multiple_hits=True)
    true = np.full(len(u), np.inf)
    np.minimum.at(true, ray, points[:, 2])
    np.testing.assert_allclose(depth.ravel(), true, rtol=1e-6)
    assert 100 < np.isfinite(true).sum() < len(u)


def test_a_gltf_file_is_seen_z_up():
    """Its box reaches from y = -3 to 0 and from z = 0 to 2, 4 m ahead of the camera."""
    box = InMemoryMesh(mesh_file=MemoryFile(gltf(), '.gltf', 'box'))
    scene, _ = scene_of([(Mesh(mesh_data=box), RigidTransform([-0.5, 0, 4.0]))])
    shown = images(scene, CAMERA)
    above, below = shown.depth.at(20, 8)[0], shown.depth.at(20, 20)[0]
    assert (above, below) == (pytest.approx(4.0), np.inf)


def coloured(kind, colours):
    mesh = trimesh.creation.box(extents=[1, 1, 1])
    made = {'face': len(mesh.faces), 'vertex': len(mesh.vertices)}[kind]
    visual = {f'{kind}_colors': np.tile(colours, (made, 1))}
    mesh.visual = trimesh.visual.ColorVisuals(mesh, **visual)
    return mesh


@pytest.mark.parametrize('kind', ['face', 'vertex'])
def test_colours_of_a_file_are_shown_before_those_of_properties(kind):
    file = io.BytesIO()
    coloured(kind, [0, 255, 0, 255]).export(file, 'ply')
    memory = InMemoryMesh(mesh_file=MemoryFile(file.getvalue(), '.ply', 'green'))
    scene, source = scene_of([])
    red = properties(1, (1.0, 0.0, 0.0))
    made = instance(Mesh(mesh_data=memory), RigidTransform([0, 0, 3]), 'g', red)
    scene.RegisterAnchoredGeometry(source, made)
    r, g, b, _ = images(scene, CAMERA).color.at(20, 15).tolist()
    assert (r, b) == (0, 0)
    assert g > 150


def test_a_mesh_scaled_by_a_mirror_is_seen_as_well():
    mesh = trimesh.creation.box(extents=[1, 2, 1])
    shape = Mesh.FromMeshData(MeshData(mesh.vertices, mesh.faces), [-1.0, 2.0, 1.0])
    scene, _ = scene_of([(shape, RigidTransform([0, 0, 3.0]))])
    assert images(scene, CAMERA).depth.at(20, 15)[0] == pytest.approx(2.5)
