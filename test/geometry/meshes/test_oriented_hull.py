"""Hulls by blocks are those of trimesh, to the bit and in the same order, or none."""

import numpy as np
import pytest
import trimesh

from drake_geom_ros.geometry.meshes import _library
from drake_geom_ros.geometry.meshes._library import convex_hull
from drake_geom_ros.geometry.meshes._oriented_hull import blocks_of, oriented_hull
from truth.bodies.random_bodies import random_directions, random_rotation

SCALE = 2.0**24  # as ``_library`` scales points


def _box(rng, _):
    return np.sign(rng.normal(size=(40, 3))) * rng.uniform(0.1, 1.0, 3)


def _prism(rng, count):
    angles = rng.uniform(0.0, 2.0 * np.pi, count)
    return np.stack([np.cos(angles), np.sin(angles), rng.integers(0, 2, count)], axis=1)


def _turned_plate(rng, count):
    return rng.normal(size=(count, 3)) * [1.0, 1e-3, 1.0] @ random_rotation(rng)


POINTS = {
    'normal': lambda rng, count: rng.normal(size=(count, 3)),
    'ball': random_directions,
    'lattice': lambda rng, count: rng.integers(-2, 3, size=(count, 3)).astype(float),
    'box': _box,
    'prism': _prism,
    'plate': _turned_plate,
    'twins': lambda rng, count: np.repeat(rng.normal(size=(count, 3)), 2, axis=0) + 1e-16,
}


def by_trimesh(points):
    hull = trimesh.Trimesh(points, process=False).convex_hull
    return np.array(hull.vertices), np.array(hull.faces)


@pytest.mark.parametrize('kind', POINTS)
def test_it_is_the_hull_of_trimesh(kind):
    rng = np.random.default_rng(7)
    used = 0
    for _ in range(60):
        points = POINTS[kind](rng, int(rng.integers(12, 200)))
        points *= SCALE / np.abs(points).max()
        hull = oriented_hull(points)
        if hull is not None:
            used += 1
            for ours, theirs in zip(hull, by_trimesh(points), strict=True):
                np.testing.assert_array_equal(ours, theirs)
                assert ours.dtype == theirs.dtype
    assert used >= 50


def test_blocks_change_nothing(monkeypatch):
    points = SCALE * random_directions(np.random.default_rng(3), 400)
    whole = oriented_hull(points)
    monkeypatch.setattr('drake_geom_ros.geometry.meshes._oriented_hull._BLOCK', 7)
    assert len(list(blocks_of(400))) == 58
    for one, other in zip(whole, oriented_hull(points), strict=True):
        np.testing.assert_array_equal(one, other)


def test_what_trimesh_would_repair_is_left_to_it():
    flat = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]) * SCALE
    assert oriented_hull(flat) is None  # Qhull fails
    ball = SCALE * random_directions(np.random.default_rng(4), 50)
    assert oriented_hull(1e-13 * ball) is None  # vertices and triangles that it merges and drops


def test_a_hull_is_the_same_by_either_way(monkeypatch):
    points = np.random.default_rng(5).normal(size=(300, 3))
    usual = convex_hull(points, 'test')
    monkeypatch.setattr(_library, 'oriented_hull', lambda points: None)
    for one, other in zip(usual, convex_hull(points, 'test'), strict=True):
        np.testing.assert_array_equal(one, other)
