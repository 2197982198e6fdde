"""Queries through the public surface: meaning, order, filters, levels, live and baked."""

import copy
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    ArgumentError,
    Box,
    Capsule,
    CollisionFilterDeclaration,
    Cylinder,
    Ellipsoid,
    FilterError,
    FrameId,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    HalfSpace,
    IllustrationProperties,
    QueryObject,
    RoleError,
    SceneGraph,
    Sphere,
    UnknownIdError,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw


def two_spheres(x):
    return ShapeScene(Sphere(0.1), Sphere(0.2)).posed([0, 0, 0], [x, 0, 0])


def test_a_gap_and_an_overlap():
    scene = two_spheres(0.5)
    (pair,) = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert (pair.id_A, pair.id_B) == tuple(scene.ids)
    assert pair.distance == pytest.approx(0.2, abs=1e-15)
    assert pair.nhat_BA_W.tolist() == [-1, 0, 0]
    np.testing.assert_allclose(pair.p_ACa, [0.1, 0, 0], rtol=0, atol=1e-16)
    np.testing.assert_allclose(pair.p_BCb, [-0.2, 0, 0], rtol=0, atol=1e-16)
    assert pair.is_nhat_BA_W_unique
    assert len(scene.query.ComputePointPairPenetration()) == 0
    assert not scene.query.HasCollisions()
    scene.posed([0, 0, 0], [0.25, 0, 0])
    (contact,) = scene.query.ComputePointPairPenetration()
    assert contact.depth == pytest.approx(0.05, abs=1e-15)
    np.testing.assert_allclose(contact.p_WCa, [0.1, 0, 0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(contact.p_WCb, [0.05, 0, 0], rtol=0, atol=1e-15)
    assert (contact.p_WCb - contact.p_WCa) @ contact.nhat_BA_W == pytest.approx(contact.depth)
    assert scene.query.HasCollisions()


def test_touching_is_not_penetrating():
    for gap in (0.0, 1e-16, -1e-16):
        scene = two_spheres(0.1 + 0.2 + gap)
        assert len(scene.query.ComputePointPairPenetration()) == 0
        assert not scene.query.HasCollisions()
    scene = two_spheres(0.3 - 1e-13)
    assert len(scene.query.ComputePointPairPenetration()) == 1
    assert scene.query.HasCollisions()


def test_max_distance_and_its_edge():
    scene = two_spheres(1.3)
    assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints(1.0 + 1e-12)) == 1
    assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints(0.999)) == 0
    with pytest.raises(ArgumentError, match='NaN'):
        scene.query.ComputeSignedDistancePairwiseClosestPoints(math.nan)


def test_distances_may_be_whole_numbers():
    query = two_spheres(1.3).query
    assert len(query.ComputeSignedDistancePairwiseClosestPoints(2)) == 1
    assert len(query.ComputeSignedDistancePairwiseClosestPoints(0)) == 0
    assert len(query.ComputeSignedDistanceToPoint([0, 0, 0], 3)) == 2


def test_results_are_sorted_and_a_is_the_lower_id():
    # Shapes in descending order of type number: the kernels take each pair the other way round.
    shapes = [Ellipsoid(1, 1, 1), Cylinder(1, 1), Capsule(1, 1), Box(1, 1, 1), Sphere(1)]
    scene = ShapeScene(*shapes).posed(*[[3.0 * k, 0, 0] for k in range(5)])
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    pairs = list(zip(results.id_A.tolist(), results.id_B.tolist(), strict=True))
    assert pairs == sorted(pairs)
    assert len(pairs) == 10
    assert all(a < b for a, b in pairs)
    for pair in results:
        # B lies towards +x of A, so the normal out of B points towards -x.
        assert pair.nhat_BA_W[0] == pytest.approx(-1.0)


SHAPES = [Sphere(0.3), Box(0.4, 0.5, 0.6), Capsule(0.2, 0.5), Cylinder(0.3, 0.4)]
SHAPES += [Ellipsoid(0.2, 0.3, 0.4), HalfSpace()]
angles = st.lists(st.floats(-3, 3), min_size=3, max_size=3)
places = st.lists(st.floats(-1, 1), min_size=3, max_size=3)


@settings(max_examples=40)
@given(st.lists(st.tuples(angles, places), min_size=6, max_size=6))
def test_depth_is_minus_the_signed_distance_of_the_same_pairs(poses):
    poses = [RigidTransform(RollPitchYaw(*rpy), p) for rpy, p in poses]
    scene = ShapeScene(*SHAPES).posed(*poses)
    distances = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    contacts = scene.query.ComputePointPairPenetration()
    overlapping = {(p.id_A, p.id_B): p for p in distances if p.distance < -1e-12}
    found = {(c.id_A, c.id_B): c for c in contacts}
    assert set(overlapping) <= set(found)
    assert scene.query.HasCollisions() == (len(contacts) > 0)
    for key, pair in overlapping.items():
        assert found[key].depth == -pair.distance
    for pair in distances:
        X_WA, X_WB = scene.query.X_WG(pair.id_A), scene.query.X_WG(pair.id_B)
        p_WCa, p_WCb = X_WA @ pair.p_ACa, X_WB @ pair.p_BCb
        np.testing.assert_allclose(
            p_WCa - p_WCb, pair.distance * pair.nhat_BA_W, rtol=0, atol=1e-12
        )
        assert np.linalg.norm(pair.nhat_BA_W) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_array_equal(distances.penetrations().depth, contacts.depth)


@settings(max_examples=25)
@given(st.lists(st.tuples(angles, places), min_size=2, max_size=2), places, angles)
def test_the_gradient_is_what_moving_shows(poses, velocity, turn):
    shapes = [Box(0.4, 0.5, 0.6), Ellipsoid(0.2, 0.3, 0.4)]
    X_WA, X_WB = (RigidTransform(RollPitchYaw(*rpy), p) for rpy, p in poses)
    X_WB = RigidTransform(X_WB.rotation(), np.add(X_WB.translation(), [1.5, 0, 0]))
    scene = ShapeScene(*shapes).posed(X_WA, X_WB)

    def distance(X_WB):
        scene.posed(X_WA, X_WB)
        return scene.query.ComputeSignedDistancePairClosestPoints(*scene.ids).distance

    scene.posed(X_WA, X_WB)
    pair = scene.query.ComputeSignedDistancePairClosestPoints(*scene.ids)
    of_A, of_B = pair.gradient()
    h = 1e-5
    steps = []
    for sign in (1, -1):
        R = RollPitchYaw(*(sign * h * np.array(turn))).ToRotationMatrix()
        p = X_WB.translation() + sign * h * np.array(velocity)
        steps.append(distance(RigidTransform(R @ X_WB.rotation(), p)))
    rate = of_B @ np.concatenate((turn, velocity))
    assert rate == pytest.approx((steps[0] - steps[1]) / (2 * h), abs=2e-4)
    # Moving both together changes nothing: the translational parts cancel.
    np.testing.assert_allclose(of_A[3:] + of_B[3:], 0.0, rtol=0, atol=1e-15)


def test_a_live_query_object_sees_later_poses_and_a_copy_does_not():
    scene = two_spheres(0.5)
    for bake in (copy.copy, copy.deepcopy):
        baked = bake(scene.query)
        scene.posed([0, 0, 0], [0.6, 0, 0])
        pair = scene.ids
        assert scene.query.ComputeSignedDistancePairClosestPoints(*pair).distance > 0.29
        assert baked.ComputeSignedDistancePairClosestPoints(*pair).distance < 0.21
        scene.posed([0, 0, 0], [0.5, 0, 0])
        # The copy is of filters and model too.
        manager = scene.graph.collision_filter_manager(scene.context)
        manager.Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(pair)))
        assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints()) == 0
        assert len(baked.ComputeSignedDistancePairwiseClosestPoints()) == 1
        manager.Apply(CollisionFilterDeclaration().AllowWithin(GeometrySet(pair)))


def test_results_keep_their_values_when_the_scene_moves_on():
    scene = two_spheres(0.5)
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    before = results.distance.copy(), results.p_WCb.copy(), results.p_BCb.copy()
    scene.posed([0, 0, 0], [0.9, 0, 0])
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    for old, new in zip(before, (results.distance, results.p_WCb, results.p_BCb), strict=True):
        np.testing.assert_array_equal(old, new)


def test_candidates_are_what_bounds_cannot_tell_apart():
    scene = ShapeScene(*[Sphere(0.5)] * 3).posed([0, 0, 0], [0.8, 0.8, 0], [5, 0, 0])
    # The boxes of the first two overlap though the spheres do not.
    a, b, _ = scene.ids
    assert scene.query.FindCollisionCandidates() == [(a, b)]
    assert not scene.query.HasCollisions()


def test_anchored_geometry_meets_what_moves_but_not_itself():
    standing = [(shape, RigidTransform()) for shape in (HalfSpace(), Box(1, 1, 1))]
    scene = ShapeScene(Sphere(0.5), anchored=standing).posed([0, 0, 2])
    results = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert results.distance.tolist() == pytest.approx([1.5, 1.0])


def test_two_half_spaces_have_no_distance():
    scene = ShapeScene(HalfSpace(), HalfSpace()).posed([0, 0, 0], [0, 0, -1])
    assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints()) == 0
    assert len(scene.query.ComputePointPairPenetration()) == 0
    with pytest.raises(GeometryError, match='two half spaces'):
        scene.query.ComputeSignedDistancePairClosestPoints(*scene.ids)


def test_asking_for_a_pair_that_cannot_be():
    scene = two_spheres(0.5)
    a, b = scene.ids
    stranger = GeometryId(10**9)
    with pytest.raises(UnknownIdError, match='1000000000'):
        scene.query.ComputeSignedDistancePairClosestPoints(a, stranger)
    with pytest.raises(FilterError, match='self'):
        scene.query.ComputeSignedDistancePairClosestPoints(a, a)
    swapped = scene.query.ComputeSignedDistancePairClosestPoints(b, a)
    assert (swapped.id_A, swapped.id_B) == (a, b)
    manager = scene.graph.collision_filter_manager(scene.context)
    manager.ApplyTransient(CollisionFilterDeclaration().ExcludeWithin(GeometrySet([a, b])))
    with pytest.raises(FilterError, match='transient declaration'):
        scene.query.ComputeSignedDistancePairClosestPoints(a, b)
    bare = scene.graph.RegisterGeometry(
        scene.context, scene.source, scene.frames[0],
        GeometryInstance(RigidTransform(), Sphere(1), 'bare'),
    )  # fmt: skip
    properties = IllustrationProperties()
    scene.graph.AssignRole(scene.context, scene.source, bare, properties)
    with pytest.raises(RoleError, match='bare'):
        scene.query.ComputeSignedDistancePairClosestPoints(bare, b)
    with pytest.raises(GeometryError, match='belongs to no scene'):
        QueryObject().HasCollisions()


def test_points_against_every_shape():
    scene = ShapeScene(*SHAPES).posed(*[[10.0 * k, 0, 0] for k in range(5)], [0, 0, -5])
    outside = [[10.0 * k, 0, 0.65] for k in range(5)]
    results = scene.query.ComputeSignedDistanceToPoint(outside, 0.5)
    assert results.point_index.tolist() == [0, 1, 2, 3, 4]
    assert results.id_G.tolist() == [g.get_value() for g in scene.ids[:5]]
    # Heights of the shapes: 0.3, 0.3, 0.25 + 0.2, 0.2, 0.4; the floor is 5 m below.
    assert results.distance.tolist() == pytest.approx([0.35, 0.35, 0.2, 0.45, 0.25])
    (floor,) = scene.query.ComputeSignedDistanceToPoint([-1e3, 0, -5.5], 1.0)
    assert floor.id_G == scene.ids[5]
    assert floor.distance == pytest.approx(-0.5)


def test_one_point():
    scene = two_spheres(0.5)
    results = scene.query.ComputeSignedDistanceToPoint([0, 0.15, 0])
    first = results[0]
    assert first.id_G == scene.ids[0]
    assert first.distance == pytest.approx(0.05)
    np.testing.assert_allclose(first.p_GN, [0, 0.1, 0], rtol=0, atol=1e-16)
    np.testing.assert_allclose(first.grad_W, [0, 1, 0], rtol=0, atol=1e-16)
    centre = scene.query.ComputeSignedDistanceToPoint([0, 0, 0])[0]
    assert centre.grad_W.tolist() == [1, 0, 0]
    assert not centre.is_grad_W_unique
    for bad, word in (
        ([0, 0], 'shape'),
        ([0, 0, math.nan], 'finite'),
        ([[0, 0, 0], [0, -math.inf, 0], [0, 0, 0]], 'finite'),
        ([[0, 0, 0], [-1e303, 0, 0]], r'-1e\+303 m'),
        (np.zeros((2, 2, 3)), 'shape'),
        (1.0, 'shape'),
    ):
        with pytest.raises(ArgumentError, match=word):
            scene.query.ComputeSignedDistanceToPoint(bad)
    assert len(scene.query.ComputeSignedDistanceToPoint(np.zeros((0, 3)))) == 0


@pytest.mark.parametrize('level', ACCURACY_LEVELS)
def test_levels(level):
    shapes = Ellipsoid(0.2, 0.3, 0.4), Cylinder(0.2, 0.3)
    scene = ShapeScene(*shapes).posed([0, 0, 0], [0.5, 0.4, 0.6])
    exact = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    answer = scene.query.ComputeSignedDistancePairwiseClosestPoints(accuracy=level)
    assert abs(answer.distance - exact.distance) <= answer.error_bound + exact.error_bound
    scene.context.set_default_accuracy(level)
    default = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert default.distance == answer.distance
    with pytest.raises(ArgumentError, match='superb'):
        scene.query.ComputeSignedDistancePairwiseClosestPoints(accuracy='superb')


def test_poses_of_nested_frames():
    scene = ShapeScene(Sphere(1))
    child = scene.graph.RegisterFrame(
        scene.context, scene.source, scene.frames[0], GeometryFrame('child')
    )
    X = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])
    scene.context.UpdateFramePoses(FramePoseVector({scene.frames[0]: X, child: X}))
    assert scene.query.X_PF(child).IsNearlyEqualTo(X, 1e-15)
    assert scene.query.GetPoseInParent(child).IsNearlyEqualTo(X, 1e-15)
    assert scene.query.X_WF(child).IsNearlyEqualTo(X @ X, 1e-14)
    assert scene.query.GetPoseInWorld(child).IsNearlyEqualTo(X @ X, 1e-14)
    assert scene.query.GetPoseInWorld(scene.ids[0]).IsNearlyEqualTo(X, 1e-15)
    with pytest.raises(UnknownIdError):
        scene.query.X_WF(FrameId(10**9))


def test_effects_tell_what_ran():
    scene = two_spheres(0.5)
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert scene.query.effects().frames_moved == 2
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    effects = scene.query.effects()
    assert effects.frames_moved == 0
    assert effects.geometries_updated == 0
    assert (effects.cached_pairs, effects.narrowphase_pairs) == (1, 0)
    scene.posed([0, 0, 0], [0.6, 0, 0])
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    effects = scene.query.effects()
    assert effects.pairs_by_method == {'closed_form': 1}
    assert list(effects.seconds) == [
        *('update', 'broadphase', 'filter', 'compile', 'cache', 'narrowphase')
    ]
    manager = scene.graph.collision_filter_manager(scene.context)
    manager.Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(scene.ids)))
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    effects = scene.query.effects()
    assert (effects.filtered_pairs, effects.narrowphase_pairs) == (1, 0)


def test_changes_of_shape_and_removals_are_seen():
    scene = two_spheres(0.5)
    a, b = scene.ids
    scene.graph.ChangeShape(scene.context, scene.source, b, Sphere(0.1))
    pair = scene.query.ComputeSignedDistancePairClosestPoints(a, b)
    assert pair.distance == pytest.approx(0.3, abs=1e-15)
    scene.graph.RemoveGeometry(scene.context, scene.source, b)
    assert len(scene.query.ComputeSignedDistancePairwiseClosestPoints()) == 0
    # The model that the context was made from is another.
    fresh = scene.graph.CreateDefaultContext()
    fresh.UpdateFramePoses(FramePoseVector({frame: RigidTransform() for frame in scene.frames}))
    query = scene.graph.get_query_output_port().Eval(fresh)
    assert len(query.ComputeSignedDistancePairwiseClosestPoints()) == 1


def test_an_empty_scene_answers():
    graph = SceneGraph()
    query = graph.get_query_output_port().Eval(graph.CreateDefaultContext())
    assert len(query.ComputeSignedDistancePairwiseClosestPoints()) == 0
    assert len(query.ComputePointPairPenetration()) == 0
    assert query.FindCollisionCandidates() == []
    assert not query.HasCollisions()
    assert len(query.ComputeSignedDistanceToPoint([0, 0, 0])) == 0
