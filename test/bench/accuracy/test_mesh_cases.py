"""Cases with solids: closed bodies with dents, samples whose truth is known, certificates."""

import numpy as np
import pytest

from bench.accuracy.mesh_cases import (
    CUTS,
    MAKERS,
    QUICK_CASES,
    UNIT,
    MeshPair,
    mesh_body,
    mesh_cases,
    surface_point,
)
from bench.accuracy.samples import CONFIGURATIONS
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry.meshes._solids import solid_of, volume
from drake_geom_ros.geometry.meshes._welding import merged
from truth.judging.asking import PENETRATION, certified
from truth.references.meshes import point_distance

CASES = [case for case in mesh_cases() if case.resolution == 100]
coarse = pytest.mark.parametrize('case', CASES, ids=lambda case: case.name)


def test_every_body_in_every_resolution_and_names_are_unique():
    cases = mesh_cases()
    names = {case.name for case in cases}
    assert len(names) == len(cases) == 6 * len(CUTS)
    assert {'Sphere-L1300', 'L20000-L20000', 'Point-Ball100'} <= names
    assert {case.name for case in QUICK_CASES} <= names
    assert len({case.family for case in cases}) == 2 * len(CUTS)


@coarse
def test_samples_are_as_placed(case):
    rng = np.random.default_rng(2)
    for configuration, gap in CONFIGURATIONS.items():
        drawn = case.sample(configuration, rng)
        if gap is None:
            assert drawn.distance <= 0.0
        else:
            assert drawn.distance == pytest.approx(gap, abs=1e-9)
        assert drawn.extent < 1.0


@coarse
def test_certificates_hold_at_every_level(case):
    for drawn in next(case.batches(5)):
        for query in case.queries:
            if query == PENETRATION and drawn.distance > -1e-9:
                continue
            for answer in case.answers(drawn, query):
                error = abs(answer.distance - drawn.distance)
                assert error <= answer.error_bound + drawn.tolerance


def test_what_overlaps_is_promised_to_hold_only():
    case = MeshPair('L', 'L', 100)
    deep = case.sample('contained', np.random.default_rng(0))
    apart = case.sample('apart', np.random.default_rng(0))
    (answer,) = certified(deep, 'signed_distance', ['exact'])
    assert abs(answer.distance - deep.distance) <= answer.error_bound + deep.tolerance
    assert not answer.is_wide
    assert certified(apart, 'signed_distance', ['exact'])[0].error_bound < 1e-9


@pytest.mark.parametrize('name', ['L', 'Ball'])
def test_surface_points_are_on_the_surface_and_look_out(name):
    rng = np.random.default_rng(4)
    _, mesh = MeshPair('Point', name, 1300).bodies(rng)
    for _ in range(20):
        f, n = surface_point(mesh, rng)
        assert float(point_distance(mesh.corners, f)[0]) == pytest.approx(0.0, abs=1e-15)
        assert float(point_distance(mesh.corners, f + 1e-6 * n)[0]) > 0.0
        assert np.linalg.norm(n) == pytest.approx(1.0)


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
