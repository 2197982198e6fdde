"""Thousands of shapes are a few batches, each copy where its geometry is."""

import numpy as np
from oracles.solids import surface_of

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    GeometryId,
    Mesh,
    Role,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.viewing.batches import batches_of
from drake_geom_ros.viewing.looks import Look
from drake_geom_ros.viewing.scaled_surfaces import parts_of

COLOUR = (0.2, 0.4, 0.6, 0.5)


def looks_of_shapes(*shapes, colour=COLOUR):
    return [
        Look(GeometryId.get_new_id(), Role.kProximity, f'geometry {k}', colour, shape, False)
        for k, shape in enumerate(shapes)
    ]


def rows(looks):
    return {look.geometry.get_value(): row for row, look in enumerate(looks)}


def test_each_copy_stands_where_its_geometry_does():
    looks = looks_of_shapes(Capsule(0.1, 0.5), Cylinder(0.2, 0.4), Capsule(0.3, 0.2))
    X_WGs = [RigidTransform(RollPitchYaw(0.3 * k, 0.2, -0.5 * k), [k, 2.0, -k]) for k in range(3)]
    R_WGs = np.array([X.rotation().matrix() for X in X_WGs])
    p_WGs = np.array([X.translation() for X in X_WGs])
    found = batches_of(looks, rows(looks).__getitem__).batches
    copies = {batch.surface.key: len(batch.bodies) for batch in found}
    assert copies == {'tube of 32': 2, 'dome of 32': 4, 'cylinder of 32': 1}
    for batch in found:
        p_WSs, wxyzs = batch.posed(R_WGs, p_WGs)
        for copy, body in enumerate(batch.bodies.tolist()):
            own = [p for p in parts_of(looks[body].shape) if p.surface is batch.surface]
            before = np.count_nonzero(batch.bodies[:copy] == body)
            X_WS = X_WGs[body] @ own[before].X_GS
            x, y, z, w = X_WS.ToArray()[3:]
            np.testing.assert_allclose(p_WSs[copy], X_WS.translation(), rtol=0, atol=1e-14)
            assert abs(wxyzs[copy] @ [w, x, y, z]) > 1.0 - 1e-14
            assert batch.geometries[copy] == looks[body].geometry.get_value()
            assert tuple(batch.scales[copy]) == own[before].scale
            assert batch.colours[copy].tolist() == [51, 102, 153]


def test_ten_thousand_geometries_are_a_handful_of_batches():
    shapes = [Sphere(0.1 + k / 1e5) if k % 2 else Box(1, 1, 1 + k) for k in range(10_000)]
    looks = looks_of_shapes(*shapes)
    found = batches_of(looks, rows(looks).__getitem__)
    assert sorted(len(batch.bodies) for batch in found.batches) == [5000, 5000]


def test_many_round_shapes_are_coarser_and_few_are_fine():
    def triangles(*shapes):
        found = batches_of(looks := looks_of_shapes(*shapes), rows(looks).__getitem__)
        return [len(b.surface.triangles) * len(b.bodies) for b in found.batches]

    ball, capsule = Sphere(0.1), Capsule(0.1, 0.2)
    assert triangles(ball) == [2 * 32 * 15]
    # What is not round is no reason to be coarse.
    assert triangles(ball, *[Box(1, 1, 1)] * 5000)[0] == triangles(ball)[0]
    few, many = (sum(triangles(*[ball, capsule] * count)) for count in (50, 1000))
    assert few == 100 * 32 * 31
    assert many == 1000 * (48 + 64)


def test_what_is_as_transparent_is_together():
    looks = looks_of_shapes(Box(1, 1, 1)) + looks_of_shapes(Box(1, 1, 1), colour=(1, 1, 1, 1))
    found = batches_of(looks, rows(looks).__getitem__)
    assert sorted(batch.alpha for batch in found.batches) == [0.5, 1.0]


def test_a_mesh_that_cannot_be_read_is_told_and_the_others_are_drawn(tmp_path):
    broken = tmp_path / 'broken.obj'
    broken.write_text('f 1 2 3\n')
    looks = looks_of_shapes(
        *(Mesh('/nowhere/at_all.obj'), Convex(str(broken)), Mesh.FromMeshData(surface_of('L')))
    )
    told = []
    found = batches_of(looks, rows(looks).__getitem__, told.append)
    assert len(found.batches) == 1
    first, second = found.troubles
    assert first.startswith('geometry 0: ')
    assert '/nowhere/at_all.obj' in first
    assert second.startswith('geometry 1: ')
    assert told == [1, 2, 3]
