"""Boxes around things, planes, and what overlaps them."""

import copy
import itertools
import math

import numpy as np
import pytest

from drake_geom_ros.geometry import Aabb, HalfSpace, Obb, Plane
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from truth.bodies.random_bodies import random_directions

X_HB = RigidTransform(RollPitchYaw(0.3, -1.0, 2.0), [1, 2, 3])


def test_an_oriented_box():
    box = Obb(X_HB=X_HB, half_width=[1, 2, 3])
    assert box.center().tolist() == [1, 2, 3]
    assert box.half_width().tolist() == [1, 2, 3]
    assert box.pose() == X_HB
    assert box.CalcVolume() == 48
    assert box.Equal(copy.copy(box))
    assert box.Equal(copy.deepcopy(box))
    assert not box.Equal(Obb(X_HB, [1, 2, 4]))
    assert not box.Equal(Obb(RigidTransform(), [1, 2, 3]))
    with pytest.raises(RuntimeError, match='must be >= 0'):
        Obb(X_HB, [1, -2, 3])


def test_a_box_along_the_axes():
    box = Aabb(p_HoBo=[1, 2, 3], half_width=[0.5, 1, 1.5])
    assert box.lower().tolist() == [0.5, 1, 1.5]
    assert box.upper().tolist() == [1.5, 3, 4.5]
    assert box.pose() == RigidTransform([1, 2, 3])
    assert eval(repr(box)).Equal(box)


def test_a_plane():
    plane = Plane(normal=[0, 0, 2], point_on_plane=[0, 0, 1])
    assert plane.unit_normal().tolist() == [0, 0, 1]
    assert plane.reference_point().tolist() == [0, 0, 1]
    assert (plane.CalcHeight([5, 5, 3]), plane.CalcHeight(point=[5, 5, -1])) == (2, -2)
    assert Plane([0, 0, 1], [0, 0, 0], already_normalized=True).CalcHeight([0, 0, 3]) == 3
    assert plane.BoxOverlaps([1, 1, 1], [0, 0, 2], RigidTransform().rotation())
    assert not plane.BoxOverlaps([1, 1, 0.9], [0, 0, 2], RigidTransform().rotation())
    with pytest.raises(RuntimeError, match='must be >= 1e-10'):
        Plane([0, 0, 0], [0, 0, 0])


def corners(box):
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    return box.pose() @ (signs * box.half_width()).T


def gap_by_planes(a, b):
    """Return the largest gap [m] of the projections of two boxes to very many directions."""
    directions = random_directions(np.random.default_rng(1), 20_000)
    on_a, on_b = directions @ corners(a), directions @ corners(b)
    return (on_b.min(axis=1) - on_a.max(axis=1)).max()


@pytest.mark.parametrize('seed', range(30))
def test_boxes_overlap_unless_a_plane_parts_them(seed):
    rng = np.random.default_rng(seed)
    a, b = (
        Obb(
            RigidTransform(RollPitchYaw(rng.uniform(-3, 3, 3)), rng.uniform(-1.2, 1.2, 3)),
            rng.uniform(0.1, 1.0, 3),
        )
        for _ in range(2)
    )
    X_GH = RigidTransform(RollPitchYaw(rng.uniform(-3, 3, 3)), rng.uniform(-0.5, 0.5, 3))
    there = Obb(X_GH @ b.pose(), b.half_width())
    gap = gap_by_planes(a, there)
    if abs(gap) > 0.02:  # what so many directions tell for sure
        assert Obb.HasOverlap(a, b, X_GH) == (gap < 0)
        assert Obb.HasOverlap(b, a, X_GH.inverse()) == (gap < 0)


def test_half_spaces_and_planes():
    for height, overlaps, cuts in ((-5, True, False), (1.0, True, True), (1.001, False, False)):
        X = RigidTransform([7, 7, height])
        for box in (Obb(RigidTransform(), [1, 1, 1]), Aabb([0, 0, 0], [1, 1, 1])):
            assert type(box).HasOverlap(box, HalfSpace(), X) == overlaps
            assert type(box).HasOverlap(bv_H=box, hs_C=HalfSpace(), X_CH=X) == overlaps
            plane = Plane([0, 0, 1], [0, 0, 0])
            assert type(box).HasOverlap(bv_H=box, plane_P=plane, X_PH=X) == cuts
    tilted = Obb(RigidTransform(RollPitchYaw(0, math.pi / 4, 0), [0, 0, 1.4]), [1, 1, 1])
    assert Obb.HasOverlap(tilted, HalfSpace(), RigidTransform())
    assert not Obb.HasOverlap(tilted, HalfSpace(), RigidTransform([0, 0, 0.02]))


def test_keywords_of_boxes_of_both_kinds():
    obb, aabb, X = Obb(RigidTransform(), [1, 1, 1]), Aabb([3, 0, 0], [1, 1, 1]), RigidTransform()
    assert not Obb.HasOverlap(obb_G=obb, aabb_H=aabb, X_GH=X)
    assert Aabb.HasOverlap(aabb_G=aabb, obb_H=obb, X_GH=RigidTransform([2, 0, 0]))
    with pytest.raises(RuntimeError, match='is not a box'):
        Obb.HasOverlap(obb, 3, X)
