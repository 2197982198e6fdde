"""Shadows of bodies against rays that are sampled densely, by closed forms of distances."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    Box,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    Role,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry import FramePoseVector as Poses
from drake_geom_ros.live.scene.self_filter import KnownBodies, SelfFilter
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import random_rotation

NOISE, REACH = 0.01, 0.04
STEP = 5e-4  # [m] between two samples of a ray


class Cell:
    """Balls and boxes, with the distance of points from the nearest of them in closed form."""

    def __init__(self, rng, count):
        self.balls = [(rng.uniform(-1, 1, 3), rng.uniform(0.02, 0.2)) for _ in range(count)]
        self.boxes = [
            (random_rotation(rng), rng.uniform(-1, 1, 3), rng.uniform(0.02, 0.3, 3))
            for _ in range(count)
        ]

    def bodies(self):
        """Yield shapes and poses."""
        for centre, radius in self.balls:
            yield Sphere(radius), RigidTransform(centre)
        for R, p, half in self.boxes:
            yield Box(*(2.0 * half)), RigidTransform(RotationMatrix(R), p)

    def distances(self, points):
        """Return the distance (b, n) [m] of each point outside from each body; 0 inside."""
        rows = [np.linalg.norm(points - c, axis=1) - r for c, r in self.balls]
        for R, p, half in self.boxes:
            beyond = np.maximum(np.abs((points - p) @ R) - half, 0.0)
            rows.append(np.linalg.norm(beyond, axis=1))
        return np.maximum(np.array(rows), 0.0)

    def least_along(self, origin, place):
        """Return the least distance [m] of the way to a place from bodies not at its origin."""
        way = place - origin
        length = np.linalg.norm(way) - REACH
        shares = np.arange(0.0, max(length, 0.0), STEP) / np.linalg.norm(way)
        away = self.distances(origin[np.newaxis])[:, 0] > NOISE
        if not len(shares) or not away.any():
            return np.inf
        return self.distances(origin + way * shares[:, np.newaxis])[away].min()


def filter_of(bodies):
    """Return a self filter and bodies where they are."""
    graph = SceneGraph()
    source = graph.RegisterSource('robot')
    poses = {}
    for k, (shape, X) in enumerate(bodies):
        frame = graph.RegisterFrame(source, GeometryFrame(f'{k}'))
        instance = GeometryInstance(RigidTransform(), shape, f'{k}')
        instance.set_proximity_properties(ProximityProperties())
        graph.RegisterGeometry(source, frame, instance)
        poses[frame] = X
    context = graph.CreateDefaultContext()
    context.UpdateFramePoses(Poses(poses))
    query = graph.get_query_output_port().Eval(context)
    known = KnownBodies()
    known.know(query, query.inspector().GetAllGeometryIds(Role.kProximity))
    return SelfFilter(), known.then(query)


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
@example(148, 3)  # a ray that grazes a body
def test_a_place_is_hidden_where_its_ray_meets_a_body(seed, count):
    rng = np.random.default_rng(seed)
    cell = Cell(rng, count)
    origin, places = rng.uniform(-2, 2, 3), rng.uniform(-2, 2, (40, 3))
    tested, there = filter_of(cell.bodies())
    hidden = tested.in_shadow(there, origin, places, REACH, NOISE)
    for is_hidden, place in zip(hidden.tolist(), places, strict=True):
        least = cell.least_along(origin, place)
        if least <= NOISE - STEP:
            assert is_hidden
        elif least > NOISE + STEP:
            assert not is_hidden


def test_both_answers_are_common():
    rng = np.random.default_rng(0)
    cell = Cell(rng, 4)
    tested, there = filter_of(cell.bodies())
    hidden = tested.in_shadow(
        there, np.array([2.0, 0, 0]), rng.uniform(-1, 1, (500, 3)), REACH, NOISE
    )
    assert 20 < hidden.sum() < 480


def test_a_body_at_the_sensor_has_no_shadow_and_others_have():
    housing = Sphere(0.1), RigidTransform([0.05, 0.0, 0.0])
    arm = Sphere(0.1), RigidTransform([1.0, 0.0, 0.0])
    tested, there = filter_of([housing, arm])
    places = np.array([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.0, 0.0]])
    hidden = tested.in_shadow(there, np.zeros(3), places, REACH, NOISE)
    assert hidden.tolist() == [True, False, False]


def test_a_floor_hides_what_is_beneath_and_not_what_lies_on_it():
    tested, there = filter_of([(HalfSpace(), RigidTransform())])
    places = np.array([[1.0, 0.0, 0.02], [1.0, 0.0, -0.2], [5.0, 0.0, 1.0]])
    hidden = tested.in_shadow(there, np.array([0.0, 0.0, 1.0]), places, REACH, NOISE)
    assert hidden.tolist() == [False, True, False]


@pytest.mark.parametrize('places', [np.zeros((0, 3)), np.zeros((1, 3))])
def test_a_place_at_the_sensor_is_not_hidden(places):
    tested, there = filter_of([(Sphere(0.1), RigidTransform([1.0, 0.0, 0.0]))])
    assert not tested.in_shadow(there, np.zeros(3), places, REACH, NOISE).any()
    nothing, nobody = filter_of([])
    assert not nothing.in_shadow(nobody, np.zeros(3), places, REACH, NOISE).any()
