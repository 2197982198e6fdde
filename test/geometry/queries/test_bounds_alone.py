"""The level `bound` of bodies whose vertices are far from their origin, as in map coordinates."""

import math
from fractions import Fraction

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    Convex,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    Mesh,
    MeshData,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform

ORIGIN = np.array([5e5, 4e6, 300.0])  # of a map, in units
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def hull(low, high):
    """Return a box as a hull about its corners."""
    corners = [[x, y, z] for x, y, z in np.ndindex(2, 2, 2)]
    return Convex(points=np.where(corners, high, low).T, label='box')


def solid(low, high):
    """Return a box as a solid."""
    corners = [[x, y, z] for x, y, z in np.ndindex(2, 2, 2)]
    triangles = [t for a, b, c, d in FACES for t in ((a, b, c), (a, c, d))]
    mesh = MeshData(np.where(corners, high, low), triangles)
    return Mesh.FromMeshData(mesh)


def truth(boxes, p):
    """Return the signed distance of two boxes, the second moved by p, in fractions."""
    moved = [Fraction(float(x)) for x in p]
    (low_a, high_a), (low_b, high_b) = (
        [[Fraction(float(x)) for x in e] for e in b] for b in boxes
    )
    gaps = [
        max(low_b[k] + moved[k] - high_a[k], low_a[k] - high_b[k] - moved[k]) for k in range(3)
    ]
    if max(gaps) <= 0:
        return max(gaps)
    return Fraction(math.sqrt(sum(max(gap, Fraction(0)) ** 2 for gap in gaps)))


@pytest.mark.parametrize('make', [hull, solid])
def test_no_rounding_of_vertices_far_away_is_left_out(make):
    # Edges that all but meet: along the line of the origins supports are small differences of
    # large numbers.
    random = np.random.default_rng(3)
    for _ in range(60):
        unit = 10.0 ** random.integers(-3, 4)
        sizes = random.integers(1, 4, (2, 3))
        boxes = [(unit * ORIGIN, unit * (ORIGIN + size)) for size in sizes]
        off = random.choice([-1.0, 0.0, 1.0], 3) * 10.0 ** random.uniform(-15.0, -9.0)
        p = unit * (random.integers(-3, 4, 3) + off)
        exact = truth(boxes, p)
        graph = SceneGraph()
        source = graph.RegisterSource('far')
        properties = ProximityProperties()
        properties.AddProperty('mesh', 'solid', True)
        poses = FramePoseVector()
        for k, box in enumerate(boxes):
            frame = graph.RegisterFrame(source, GeometryFrame(str(k)))
            body = GeometryInstance(RigidTransform(), make(*box), 'body')
            body.set_proximity_properties(properties)
            graph.RegisterGeometry(source, frame, body)
            poses.set_value(frame, RigidTransform(p if k else [0.0, 0.0, 0.0]))
        for level in ACCURACY_LEVELS:
            context = graph.CreateDefaultContext()
            context.UpdateFramePoses(poses)
            query = graph.get_query_output_port().Eval(context)
            (pair,) = query.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
            off = abs(Fraction(pair.distance) - exact)
            assert off <= Fraction(pair.error_bound) + Fraction(4 * math.ulp(float(exact)))
            if exact > 0:
                near = query.ComputeSignedDistancePairwiseClosestPoints(
                    float(exact) * (1.0 + 1e-15), accuracy=level
                )
                assert len(near) == 1
