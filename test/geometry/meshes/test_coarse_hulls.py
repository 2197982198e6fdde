"""Coarse hulls: some vertices of a hull, and a bound of how far it reaches beyond them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.worlds import random_rotations
from scipy.optimize import nnls

from drake_geom_ros.geometry import Convex
from drake_geom_ros.geometry.meshes._coarse_hulls import FEW, MANY, chosen_vertices, coarse_hull
from drake_geom_ros.geometry.meshes.source import MeshData, coarse_hull_of
from truth.bodies.random_bodies import random_directions


def ball(rng, count):
    return random_directions(rng, count)


def needle(rng, count):
    return ball(rng, count) * [1e-5, 1e-4, 1.0]


def disc(rng, count):
    return ball(rng, count) * [1.0, 1.0, 1e-6]


def drum(rng, count):
    """Two polygons, many of whose triangles are in one plane."""
    angle = np.linspace(0.0, 2.0 * np.pi, count // 2, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([np.insert(ring, 2, z, axis=1) for z in (-0.2, 0.2)])


def pin(rng, count):
    """A ball with one vertex far out."""
    return np.vstack([ball(rng, count), [[30.0, 0.0, 0.0]]])


SHAPES = {make.__name__: make for make in (ball, needle, disc, drum, pin)}


def hull_of(name, seed, scale, away):
    """Return a hull at any place, as queries use it, and its coarse hull."""
    rng = np.random.default_rng(seed)
    points = SHAPES[name](rng, 400) @ random_rotations(rng, 1)[0].T
    mesh = MeshData(scale * (points + away))
    return Convex.FromMeshData(mesh).hull_surface()[0], coarse_hull_of(mesh, np.ones(3))


def distances_by_weights(points, few):
    """Return upper bounds of the distances of points from a hull, by weights of its vertices."""
    size = np.abs(few).max()
    rows = np.vstack([few.T / size, np.full(len(few), 1e3)])
    found = []
    for point in points:
        weights, _ = nnls(rows, np.append(point / size, 1e3), maxiter=5000)
        found.append(np.linalg.norm(point - few.T @ weights / weights.sum()))
    return np.array(found)


cases = given(
    name=st.sampled_from(list(SHAPES)),
    seed=st.integers(0, 1000),
    scale=st.sampled_from([1e-3, 0.1, 1.0, 1e3]),
    away=st.sampled_from([0.0, 3.0]),
)


@cases
@settings(max_examples=8, deadline=None)
def test_the_hull_is_within_the_reach(name, seed, scale, away):
    vertices, coarse = hull_of(name, seed, scale, away)
    assert len(vertices) >= MANY
    assert len(coarse.vertices) <= FEW
    assert set(map(tuple, coarse.vertices.tolist())) <= set(map(tuple, vertices.tolist()))
    rng = np.random.default_rng(seed)
    a, b, c = (coarse.vertices[coarse.triangles[:, k]] for k in range(3))
    sides = np.cross(b - a, c - a)
    sides /= np.maximum(np.linalg.norm(sides, axis=1), 1e-300)[:, None]
    n = np.vstack([random_directions(rng, 2000), sides])
    # Support functions of the two hulls differ by no more.
    gaps = (vertices @ n.T).max(axis=0) - (coarse.vertices @ n.T).max(axis=0)
    assert gaps.max() <= coarse.reach
    # A second way to find the distances, which errs to the large side. Of a needle no direction
    # that is drawn shows the farthest vertex: all are looked at.
    largest = distances_by_weights(vertices, coarse.vertices).max()
    size = np.abs(vertices).max()
    assert coarse.reach <= 1.1 * largest + 1e-6 * size
    assert largest <= coarse.reach + 1e-6 * size


@pytest.mark.parametrize('name', SHAPES)
def test_triangles_are_counter_clockwise_and_close(name):
    _, coarse = hull_of(name, 1, 1.0, 0.0)
    a, b, c = (coarse.vertices[coarse.triangles[:, k]] for k in range(3))
    volume = np.einsum('ij,ij->i', np.cross(a, b), c).sum() / 6.0
    assert volume > 0.0
    sides = coarse.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    assert {tuple(side) for side in sides} == {tuple(side[::-1]) for side in sides}


def test_a_reflection_turns_the_triangles():
    mesh = MeshData(ball(np.random.default_rng(0), 300))
    plain, mirrored = (coarse_hull_of(mesh, np.array([1.0, 1.0, z])) for z in (1.0, -1.0))
    np.testing.assert_array_equal(mirrored.vertices, plain.vertices * [1.0, 1.0, -1.0])
    np.testing.assert_array_equal(mirrored.triangles, plain.triangles[:, ::-1])
    assert mirrored.reach == plain.reach


def test_small_hulls_have_none():
    points = ball(np.random.default_rng(0), MANY - 1)
    assert chosen_vertices(points) is None
    assert coarse_hull_of(MeshData(points), np.ones(3)) is None


def test_what_a_coarse_hull_lacks_is_seen():
    """A vertex far out that was not chosen makes the reach that long."""
    points = ball(np.random.default_rng(0), 200)
    chosen, triangles = chosen_vertices(points)
    left_out = np.setdiff1d(np.arange(200), chosen)[0]
    points[left_out] *= 3.0
    coarse = coarse_hull(points, chosen, triangles)
    assert coarse.reach == pytest.approx(2.0, abs=0.15)
