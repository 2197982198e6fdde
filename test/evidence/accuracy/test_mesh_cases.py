"""Cases with solids: samples whose truth is known, and certificates that hold it."""

import numpy as np
import pytest

from drake_geom_ros.evidence.accuracy import ours
from drake_geom_ros.evidence.accuracy.mesh_bodies import CUTS
from drake_geom_ros.evidence.accuracy.mesh_cases import (
    QUICK_CASES,
    MeshPair,
    mesh_cases,
    surface_point,
)
from drake_geom_ros.evidence.accuracy.ours import PENETRATION, POINTS
from drake_geom_ros.evidence.accuracy.samples import CONFIGURATIONS
from drake_geom_ros.evidence.truth.meshes import point_distance

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


def test_open_intervals_are_promised_to_hold_only():
    case = MeshPair('L', 'L', 100)
    deep = case.sample('contained', np.random.default_rng(0))
    apart = case.sample('apart', np.random.default_rng(0))
    (answer,) = ours.answers(deep, 'signed_distance', ['exact'])
    assert answer.error_bound > 1e-3
    assert not answer.is_wide
    assert ours.answers(apart, 'signed_distance', ['exact'])[0].error_bound < 1e-9


@pytest.mark.parametrize('name', ['L', 'Ball'])
def test_surface_points_are_on_the_surface_and_look_out(name):
    rng = np.random.default_rng(4)
    _, mesh = MeshPair('Point', name, 1300).bodies(rng)
    for _ in range(20):
        f, n = surface_point(mesh, rng)
        assert float(point_distance(mesh.corners, f)[0]) == pytest.approx(0.0, abs=1e-15)
        assert float(point_distance(mesh.corners, f + 1e-6 * n)[0]) > 0.0
        assert np.linalg.norm(n) == pytest.approx(1.0)


def test_it_is_timed_side_by_side():
    subject = MeshPair('Point', 'Ball', 100)
    known = next(subject.batches(0))
    timed, pairs = subject.timed(POINTS, known)
    assert pairs == MeshPair.timed_pairs
    seconds = timed.cycle(POINTS, 'exact', np.random.default_rng(0), pairs)
    assert 0.0 < seconds.kernels < seconds.whole < 0.1
