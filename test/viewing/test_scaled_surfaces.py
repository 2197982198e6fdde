"""What is drawn is what is checked: extents and volumes of shapes, seen from outside."""

import numpy as np
import pytest
from oracles.mesh_files import gltf
from oracles.solids import surface_of

from drake_geom_ros.geometry import (
    Box,
    CalcVolume,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    MeshcatCone,
    Sphere,
)
from drake_geom_ros.viewing.scaled_surfaces import facets_around, parts_of


def corners(parts):
    """Return the triangles (n, 3, 3) of parts in the geometry's frame."""
    return np.concatenate(
        [
            (part.surface.vertices * part.scale @ part.X_GS.rotation().matrix().T)[
                part.surface.triangles
            ]
            + part.X_GS.translation()
            for part in parts
        ]
    )


@pytest.mark.parametrize('solid', [False, True])
def test_a_gltf_file_is_drawn_z_up(tmp_path, solid):
    (tmp_path / 'box.gltf').write_text(gltf())
    found = corners(parts_of(Mesh(tmp_path / 'box.gltf', [1, 2, 3]), solid))
    assert found.min(axis=(0, 1)).tolist() == [0, -6, 0]
    assert found.max(axis=(0, 1)).tolist() == [1, 0, 6]


def volume(parts):
    """Return what outward triangles enclose, by the divergence theorem."""
    a, b, c = np.moveaxis(corners(parts), 1, 0)
    return (a * np.cross(b, c)).sum() / 6


SHAPES = [
    (Sphere(0.3), (0.3, 0.3, 0.3)),
    (Box(2, 4, 6), (1, 2, 3)),
    (Cylinder(0.5, 3), (0.5, 0.5, 1.5)),
    (Ellipsoid(1, 2, 3), (1, 2, 3)),
    (Capsule(0.5, 3), (0.5, 0.5, 2.0)),
]


@pytest.mark.parametrize('around', [facets_around(count) for count in (1, 150, 1000, 10_000)])
@pytest.mark.parametrize(('shape', 'top'), SHAPES, ids=lambda each: type(each).__name__)
def test_a_shape_is_as_large_as_what_is_checked(shape, top, around):
    points = corners(parts_of(shape, around=around)).reshape(-1, 3)
    # The facets of a round surface have their corners on it.
    assert points.max(axis=0) == pytest.approx(top)
    assert -points.min(axis=0) == pytest.approx(top)


@pytest.mark.parametrize('shape', [*(each for each, _ in SHAPES), MeshcatCone(2.0, 0.5, 0.7)])
def test_its_triangles_are_closed_and_seen_from_outside(shape):
    assert volume(parts_of(shape)) == pytest.approx(CalcVolume(shape), rel=0.03)
    assert volume(parts_of(shape, around=8)) == pytest.approx(CalcVolume(shape), rel=0.25)
    for triangles in (corners(parts_of(shape)), corners(parts_of(shape, around=8))):
        sides = np.diff(triangles, axis=1)
        areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        assert areas.min() > 1e-6  # none is drawn in vain


def test_an_edge_is_shaded_apart():
    (part,) = parts_of(Cylinder(1, 1))
    triangles = part.surface.triangles
    z = part.surface.vertices[triangles][..., 2]
    top = (z == 0.5).all(axis=1)
    assert top.any()
    assert not np.isin(triangles[top], triangles[~top]).any()


def test_a_half_space_ends_at_its_plane():
    assert corners(parts_of(HalfSpace()))[..., 2].max() == pytest.approx(0.0)


def test_a_mesh_is_its_hull_and_a_solid_itself():
    mesh = Mesh.FromMeshData(surface_of('L'), 0.5)
    assert volume(parts_of(mesh)) == pytest.approx(3.5 / 8)
    assert volume(parts_of(mesh, solid=True)) == pytest.approx(3.0 / 8)
    assert volume(parts_of(Convex.FromMeshData(surface_of('L'), 0.5))) == pytest.approx(3.5 / 8)


def test_equal_meshes_share_a_surface():
    one, same, other = (
        parts_of(Mesh.FromMeshData(surface_of('L'), scale))[0].surface.key for scale in (1, 1, 2)
    )
    assert one == same != other
