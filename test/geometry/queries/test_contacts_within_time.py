"""Contacts from a narrow phase that ran out of time: no pair without a surface is missing."""

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    AddCompliantHydroelasticProperties,
    AddRigidHydroelasticProperties,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    QueryObject,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from drake_geom_ros.math import RigidTransform, RotationMatrix

SHAPES = (
    Sphere(0.1),
    Box(0.3, 0.2, 0.1),
    Cylinder(0.1, 0.3),
    Capsule(0.05, 0.3),
    Ellipsoid(0.1, 0.05, 0.15),
    Sphere(0.01),  # which is often deep within another
)
COUNT = 36


def heap(random):
    """Return query objects, of two contexts that nobody asked anything yet, of a heap of bodies.

    A third each are soft, rigid, and neither.
    """
    graph = SceneGraph()
    source, X_WFs = graph.RegisterSource('heap'), {}
    for k in range(COUNT):
        properties = ProximityProperties()
        if k % 3 == 0:
            AddCompliantHydroelasticProperties(0.1, 1e5, properties)
        elif k % 3 == 1:
            AddRigidHydroelasticProperties(0.1, properties)
        instance = GeometryInstance(RigidTransform(), SHAPES[random.integers(len(SHAPES))], 'body')
        instance.set_proximity_properties(properties)
        frame = graph.RegisterFrame(source, GeometryFrame(f'f{k}'))
        graph.RegisterGeometry(source, frame, instance)
        Q, _ = np.linalg.qr(random.normal(size=(3, 3)))
        R = RotationMatrix(Q * np.sign(np.linalg.det(Q)))
        X_WFs[frame] = RigidTransform(R, random.uniform(-0.35, 0.35, 3))
    contexts = [graph.CreateDefaultContext() for _ in range(2)]
    for context in contexts:
        context.UpdateFramePoses(FramePoseVector(X_WFs))
    return [QueryObject(context) for context in contexts]


def rows_of(contacts):
    others = contacts.others
    pairs = zip(others.id_A.tolist(), others.id_B.tolist(), strict=True)
    told = zip(
        contacts.reasons.tolist(),
        others.depth.tolist(),
        others.error_bound.tolist(),
        strict=True,
    )
    return dict(zip(pairs, told, strict=True))


@pytest.mark.parametrize('seed', range(6))
def test_all_that_overlap_are_among_those_that_may(seed):
    query, leisurely = heap(np.random.default_rng(seed))
    distances = query.ComputeSignedDistancePairwiseClosestPoints(0.1, time_budget=1e-9)
    assert query.effects().unrefined_pairs > 20
    hurried = query.contacts(overlaps=distances.penetrations())
    exact = leisurely.contacts()
    np.testing.assert_array_equal(hurried.surfaces.areas, exact.surfaces.areas)
    expected, found = rows_of(exact), rows_of(hurried)
    assert {reason for reason, *_ in expected.values()} >= {
        *(NoSurface.NO_PROPERTIES, NoSurface.BOTH_RIGID)
    }
    assert set(expected) <= set(found)
    assert len(found) > len(expected)  # bounds alone cannot tell them from those that are apart
    for pair, (reason, depth, bound) in found.items():
        if pair not in expected:
            assert bound >= depth  # may be apart, and the numbers say so
            continue
        true_reason, true_depth, true_bound = expected[pair]
        assert reason == true_reason
        assert abs(depth - true_depth) <= bound + true_bound


def test_some_pair_of_these_heaps_is_too_deep():
    seen = [heap(np.random.default_rng(seed))[0].contacts().reasons for seed in range(6)]
    assert (np.concatenate(seen) == NoSurface.TOO_DEEP).any()
