"""Cases with solids: closed bodies with dents, samples whose truth is known, certificates."""

import numpy as np
import pytest

from bench.accuracy.mesh_cases import QUICK_CASES, MeshPair, mesh_cases, surface_point
from bench.accuracy.samples import CONFIGURATIONS
from truth.bodies.mesh_bodies import CUTS
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
