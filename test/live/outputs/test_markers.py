"""What is drawn is what is checked: extents of shapes, solids, ids, colours."""

import itertools

import numpy as np
import pytest
from live.live_scenes import live_scene
from live.outputs.marker_types import TEXT, TYPES
from oracles.mesh_files import gltf
from oracles.solids import surface_of

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    HalfSpace,
    Mesh,
    Rgba,
    Role,
    Sphere,
)
from drake_geom_ros.live.outputs import markers
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.viewing import looks


@pytest.fixture
def live():
    return live_scene(TEXT, world_frame='map')


def extent(parts):
    """Return the highest point (3,) of markers along each axis of the geometry's frame."""
    tops = []
    for part in parts:
        p = part.X_GP.translation()
        if part.triangles is not None:
            tops.append((part.triangles @ part.X_GP.rotation().matrix().T + p).max(axis=0))
        else:
            tops.append(p + np.array(part.scale) / 2)
    return np.max(tops, axis=0)


@pytest.mark.parametrize(
    ('shape', 'expected'),
    [
        (Sphere(0.3), (0.3, 0.3, 0.3)),
        (Box(2, 4, 6), (1, 2, 3)),
        (Cylinder(0.5, 3), (0.5, 0.5, 1.5)),
        (Ellipsoid(1, 2, 3), (1, 2, 3)),
        (Capsule(0.5, 3), (0.5, 0.5, 2.0)),
    ],
)
def test_a_shape_is_as_large_as_what_is_checked(shape, expected):
    assert extent(markers.parts_of(shape)) == pytest.approx(expected)


def test_a_half_space_ends_at_its_plane():
    (plate,) = markers.parts_of(HalfSpace())
    assert extent([plate])[2] == pytest.approx(0.0)


def test_a_capsule_is_a_cylinder_between_two_balls():
    tube, *balls = markers.parts_of(Capsule(0.5, 3))
    assert (tube.kind, tube.scale) == (markers.CYLINDER, (1.0, 1.0, 3.0))
    assert [ball.kind for ball in balls] == [markers.SPHERE] * 2
    assert sorted(ball.X_GP.translation()[2] for ball in balls) == [-1.5, 1.5]


@pytest.mark.parametrize('kind', [Convex, Mesh])
@pytest.mark.parametrize('scale', [1.0, [2.0, 3.0, -4.0]])
def test_a_mesh_is_drawn_as_its_hull_seen_from_outside(tmp_path, kind, scale):
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    lines = [f'v {x} {y} {z}' for x, y, z in [*corners, (0.5, 0.5, 0.5)]]
    path = tmp_path / 'cube.obj'
    path.write_text('\n'.join([*lines, 'f 1 2 9', 'f 3 4 9', 'f 5 6 7 8']))
    (part,) = markers.parts_of(kind(str(path), scale))
    a, b, c = np.moveaxis(part.triangles.reshape(-1, 3, 3), 1, 0)
    normals = np.cross(b - a, c - a)
    # Outward triangles of a closed surface: the divergence theorem gives the volume.
    assert (a * normals).sum() / 6 == pytest.approx(np.prod(np.abs(np.broadcast_to(scale, 3))))


@pytest.mark.parametrize('solid', [False, True])
def test_a_gltf_file_is_turned_once(tmp_path, solid):
    """Its triangles are sent, not its name: RViz would turn that file itself."""
    (tmp_path / 'box.gltf').write_text(gltf())
    (part,) = markers.parts_of(Mesh(str(tmp_path / 'box.gltf')), solid)
    assert part.triangles.min(axis=0).tolist() == [0, -3, 0]
    assert part.triangles.max(axis=0).tolist() == [1, 0, 2]


def test_a_solid_is_drawn_as_itself(monkeypatch):
    mesh = Mesh.FromMeshData(surface_of('L'), 0.5)
    hull, solid = (markers.parts_of(mesh, solid)[0].triangles for solid in (False, True))

    def volume(triangles):
        a, b, c = np.moveaxis(triangles.reshape(-1, 3, 3), 1, 0)
        return (a * np.cross(b, c)).sum() / 6

    assert volume(hull) == pytest.approx(3.5 / 8)
    assert volume(solid) == pytest.approx(3.0 / 8)
    monkeypatch.setattr(looks, 'MOST_DRAWN', 5)
    assert volume(markers.parts_of(mesh, True)[0].triangles) == pytest.approx(3.5 / 8)


def test_colours_come_from_the_properties(scene):
    ball, seen = (scene.model.names.geometry(f'b/{name}') for name in ('ball', 'seen'))
    colours = [
        looks.colour_of(scene.model.inspector, id, Role.kIllustration) for id in (ball, seen)
    ]
    assert colours[0] == (1.0, 0.0, 0.0, 0.5)
    assert Rgba(*colours[1]).a() == 1.0
    assert looks.colour_of(scene.model.inspector, ball, Role.kProximity)[3] < 1.0


def test_ids_of_any_geometry_fit_into_a_marker():
    writer = markers.MarkerWriter(TYPES, 'world', None)
    parts = markers.parts_of(Capsule(1, 1))
    drawn = writer.geometry('n', GeometryId(2**40), parts, (1, 1, 1, 1), RigidTransform())
    assert all(0 <= marker.id < 2**31 for marker in drawn)
    assert len({marker.id for marker in drawn}) == 3
