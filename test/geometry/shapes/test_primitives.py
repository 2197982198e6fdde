"""Shapes: accessors, checks that name argument and value, and what kernels get."""

import copy
import math
import os
import pickle

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.shapes.primitives import for_queries

SHAPES = [
    Sphere(0.5),
    Box(1, 2, 3),
    Capsule(0.5, 2),
    Cylinder(0.5, 2),
    Ellipsoid(1, 2, 3),
    HalfSpace(),
    Convex('/a/b.obj'),
    Mesh('/a/b.obj', 2.0),
]


def test_accessors():
    assert Sphere(0.5).radius() == 0.5
    box = Box(width=1, depth=2, height=3)
    assert (box.width(), box.depth(), box.height()) == (1, 2, 3)
    assert box.size().tolist() == [1, 2, 3]
    for kind in (Capsule, Cylinder):
        assert (kind(radius=0.5, length=2).radius(), kind(0.5, 2).length()) == (0.5, 2.0)
    ellipsoid = Ellipsoid(a=1, b=2, c=3)
    assert (ellipsoid.a(), ellipsoid.b(), ellipsoid.c()) == (1, 2, 3)


def test_measures_can_be_given_at_once():
    assert Box([1, 2, 3]) == Box(measures=np.array([1, 2, 3])) == Box(1, 2, 3)
    assert Capsule([1, 2]) == Capsule(measures=(1, 2)) == Capsule(1, 2)
    assert Ellipsoid(measures=[1, 2, 3]) == Ellipsoid(1, 2, 3)
    with pytest.raises(RuntimeError, match=r'Box: measures = \[1, 2\] must be width, depth'):
        Box([1, 2])


def test_kernels_get_half_sizes_and_the_number_of_the_kind():
    expected = [[0.5], [0.5, 1, 1.5], [0.5, 1], [0.5, 1], [1, 2, 3], []]
    for shape, parameters in zip(SHAPES, expected, strict=False):
        assert for_queries(shape).in_pairs.parameters.tolist() == parameters
        assert for_queries(shape).in_pairs.parameters.dtype == np.float64
    kinds = [for_queries(shape).in_pairs.kind for shape in SHAPES[:6]]
    assert kinds == [1, 2, 3, 4, 5, 6]
    assert all(
        for_queries(shape, True).to_points.kind == k for k, shape in enumerate(SHAPES[:6], 1)
    )


@pytest.mark.parametrize(
    ('make', 'words'),
    [
        (lambda: Sphere(-1), 'Sphere: radius = -1 must be >= 0'),
        (lambda: Sphere(math.nan), 'Sphere: radius = nan must be finite'),
        (lambda: Sphere(math.inf), 'Sphere: radius = inf must be finite'),
        (lambda: Sphere('a'), "Sphere: radius = 'a' must be a number"),
        (lambda: Box(1, 0, 1), 'Box: depth = 0.0 must be > 0'),
        (lambda: Box(1, 2), 'Box: height is missing'),
        (lambda: Box(), 'Box: width is missing'),
        (lambda: Box(1, 2, [3]), r'Box: height = \[3\] must be a number'),
        (lambda: Capsule(1, 0), 'Capsule: length = 0.0 must be > 0'),
        (lambda: Capsule(-1, 1), 'Capsule: radius = -1.0 must be > 0'),
        (lambda: Cylinder(0, 1), 'Cylinder: radius = 0.0'),
        (lambda: Cylinder(1, math.inf), 'Cylinder: length = inf'),
        (lambda: Ellipsoid(1, 1, -0.0), 'Ellipsoid: c = -0.0 must be > 0'),
        (lambda: Convex('/a.obj', 1e-9), r'Convex: \|scale\|'),
        (lambda: Mesh('/a.obj', [1, 1, 0]), r'given \[1.0, 1.0, 0.0\]'),
        (lambda: Mesh('/a.obj', math.inf), 'finite'),
        (lambda: Mesh(''), "Mesh: filename = ''"),
        (lambda: Mesh(3), 'Mesh: filename = 3'),
        (lambda: Shape(), 'one of its kinds'),
    ],
)
def test_bad_measures_are_named_with_their_value(make, words):
    with pytest.raises(RuntimeError, match=words):
        make()


def test_a_sphere_may_be_a_point():
    assert Sphere(0).radius() == 0.0


@pytest.mark.parametrize('kind', [Convex, Mesh])
def test_mesh_shapes(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shape = kind('part.OBJ', scale=-2)
    assert shape.filename() == os.path.join(os.getcwd(), 'part.OBJ')
    assert shape.extension() == '.obj'
    assert shape.scale() == -2.0
    assert shape.scale3().tolist() == [-2, -2, -2]
    assert kind(absolute_filename='/a/b.obj') == kind('/a/b.obj') == kind(filename='/a/b.obj')
    assert kind('/a/b.obj', scale3=[1, 2, 3]) == kind('/a/b.obj', [1, 2, 3])
    with pytest.raises(RuntimeError, match='scale3'):
        kind('/a/b.obj', [1, 2, 3]).scale()


def test_shapes_are_values():
    for k, shape in enumerate(SHAPES):
        for other in (copy.copy(shape), copy.deepcopy(shape), shape.Clone()):
            assert other is not shape
            assert other == shape
            assert hash(other) == hash(shape)
        assert pickle.loads(pickle.dumps(shape)) == shape
        assert [shape == other for other in SHAPES].index(True) == k
    assert Capsule(1, 2) != Cylinder(1, 2)
    assert len({Sphere(1), Sphere(1.0), Sphere(2)}) == 2


def test_shapes_print_as_they_are_made():
    for shape in SHAPES:
        assert eval(repr(shape)) == shape
    assert repr(Box(1, 2, 3)) == 'Box(width=1.0, depth=2.0, height=3.0)'


@pytest.mark.parametrize(
    ('normal', 'point'),
    [
        ([0, 0, 1], [0, 0, 0]),
        ([0, 0, -2], [1, 2, 5]),
        ([1, 2, 3], [0, 0, 5]),
        ([3e-10, 0, 0], [7, 8, 9]),
    ],
)
def test_half_space_pose(normal, point):
    X_FH = HalfSpace.MakePose(normal, point)
    Hz_F = X_FH.rotation().col(2)
    np.testing.assert_allclose(Hz_F, np.array(normal) / np.linalg.norm(normal), rtol=0, atol=1e-15)
    assert X_FH.rotation().IsValid()
    p_FHo = X_FH.translation()
    assert abs(Hz_F @ (np.array(point) - p_FHo)) < 1e-14  # on the boundary ...
    assert np.linalg.norm(np.cross(p_FHo, Hz_F)) < 1e-14  # ... and nearest to Fo


def test_half_space_pose_is_pydrakes():
    # HalfSpace.MakePose([1, 2, 3], [0, 0, 5]) of pydrake 1.51.
    X_FH = HalfSpace.MakePose([1, 2, 3], [0, 0, 5])
    R_FH = [
        [0.0, -0.9636241116594317, 0.2672612419124244],
        [0.8320502943378437, 0.14824986333222026, 0.5345224838248488],
        [-0.5547001962252291, 0.22237479499833038, 0.8017837257372732],
    ]
    np.testing.assert_allclose(X_FH.rotation().matrix(), R_FH, rtol=0, atol=1e-15)
    p_FH = [1.0714285714285714, 2.142857142857143, 3.2142857142857144]
    np.testing.assert_allclose(X_FH.translation(), p_FH, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ('normal', 'point', 'words'),
    [
        ([0, 0, 9e-11], [0, 0, 0], r'\|Hz_dir_F\| = 9e-11 must be >= 1e-10'),
        ([0, math.nan, 1], [0, 0, 0], 'Hz_dir_F'),
        ([0, 0, 1], [0, 0, math.inf], 'p_FB'),
        ([0, 1], [0, 0, 0], 'Hz_dir_F'),
    ],
)
def test_half_space_pose_without_a_normal(normal, point, words):
    with pytest.raises(RuntimeError, match=words):
        HalfSpace.MakePose(normal, point)
