"""What a scene computes, in counts: nothing for what no query is about, nothing twice."""

import dataclasses

import numpy as np
import pytest
from oracles.shape_scenes import ShapeScene
from oracles.small_scene import instance

from drake_geom_ros.geometry import (
    Box,
    CollisionFilterDeclaration,
    Ellipsoid,
    FramePoseVector,
    GeometrySet,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Sphere,
)
from drake_geom_ros.geometry._proximity.kernels import addresses as kernel_table
from drake_geom_ros.geometry.queries.context import state_of

BODIES = 12


class Scene(ShapeScene):
    """Bodies of three shapes on a line, each on a frame of its own, and what is put beside."""

    def __init__(self, extra=()):
        shapes = Sphere(0.2), Box(0.3, 0.3, 0.3), Ellipsoid(0.1, 0.2, 0.3)
        super().__init__(*shapes * (BODIES // 3))
        for frame in self.frames:
            for number, properties in enumerate(extra):
                body = instance(f'extra_{number}', Box(9, 9, 9), proximity=False)
                body = self.graph.RegisterGeometry(self.source, frame, body)
                if properties is not None:
                    self.graph.AssignRole(self.source, body, properties)
        self.context = self.graph.CreateDefaultContext()
        self.query = self.asked(self.context)

    def cycle(self, offsets, query):
        """Pose the bodies in a row, each off its place by an offset [m], and ask."""
        poses = np.zeros((BODIES, 7))
        poses[:, 0], poses[:, 1], poses[:, 6] = 0.3 * np.arange(BODIES), offsets, 1.0
        ids = np.array([frame.get_value() for frame in self.frames])
        self.context.UpdateFramePoses(FramePoseVector.FromArrays(ids, poses))
        getattr(self.query, query)()
        counts = dataclasses.asdict(self.query.effects())
        del counts['seconds'], counts['kernels_compiled']
        return counts


QUERIES = (
    'ComputeSignedDistancePairwiseClosestPoints',
    'ComputePointPairPenetration',
    'HasCollisions',
)
# First, all move, one moves, none moves.
MOTION = (np.zeros(BODIES), np.full(BODIES, 0.01), 0.01 + 0.02 * np.eye(BODIES)[3])


def story(scene, query):
    return [scene.cycle(offsets, query) for offsets in (*MOTION, MOTION[-1])]


@pytest.mark.parametrize('query', QUERIES)
@pytest.mark.parametrize(
    'extra',
    [
        [None] * 10,
        [IllustrationProperties() for _ in range(84)],  # 1008 in all
        [PerceptionProperties(), IllustrationProperties(), None],
    ],
    ids=['without a role', '1000 illustrations', 'every role but one'],
)
def test_what_has_no_proximity_role_changes_no_count(query, extra):
    plain, dressed = Scene(), Scene(extra)
    assert dressed.graph.model_inspector().num_geometries() == BODIES * (1 + len(extra))
    assert story(dressed, query) == story(plain, query)


def test_the_role_is_what_counts():
    """The same geometry with the role does change them."""
    extra = [ProximityProperties()]
    assert story(Scene(extra), QUERIES[0]) != story(Scene(), QUERIES[0])


def test_what_has_no_proximity_role_is_not_posed():
    scene = Scene([None, IllustrationProperties()])
    first = scene.cycle(np.zeros(BODIES), QUERIES[0])
    assert (first['frames_moved'], first['geometries_updated']) == (BODIES, BODIES)
    assert state_of(scene.context).up_to_date_world().geometry_count == BODIES


@pytest.mark.parametrize('query', QUERIES[:2])
def test_pairs_that_rest_are_not_computed_again(query):
    first, moving, one, resting = story(Scene(), query)
    assert first['narrowphase_pairs'] > 0
    assert moving['cached_pairs'] == 0
    # One body moved: its pairs alone are looked at anew.
    assert one['frames_moved'] == one['geometries_updated'] == 1
    assert one['narrowphase_pairs'] + one['far_pairs'] < moving['broadphase_pairs']
    assert one['narrowphase_pairs'] <= BODIES - 1
    assert resting['frames_moved'] == resting['geometries_updated'] == 0
    # Poses that are given once more are looked at, and then all of it is known.
    assert resting['narrowphase_pairs'] == 0
    known = resting['cached_pairs'] + resting['far_pairs']
    assert known == resting['broadphase_pairs'] - resting['filtered_pairs']
    assert not resting['near_list_made']


def test_a_filtered_pair_reaches_no_kernel_and_compiles_none(monkeypatch):
    """Boxes against ellipsoids are filtered: their kernel is not even loaded."""
    monkeypatch.setattr(kernel_table, 'COMPILED_ROWS', np.zeros_like(kernel_table.COMPILED_ROWS))
    scene = Scene()
    boxes, ellipsoids = scene.ids[1::3], scene.ids[2::3]
    apart = CollisionFilterDeclaration()
    apart.ExcludeBetween(GeometrySet(boxes), GeometrySet(ellipsoids))
    apart.ExcludeWithin(GeometrySet(ellipsoids))
    scene.graph.collision_filter_manager(scene.context).Apply(apart)
    loaded = []
    real = kernel_table.compiled_address
    monkeypatch.setattr(
        kernel_table,
        'compiled_address',
        lambda kernel: loaded.append(kernel.__name__) or real(kernel),
    )
    counts = scene.cycle(np.zeros(BODIES), QUERIES[0])
    assert sorted(loaded) == ['box_box', 'sphere_box', 'sphere_ellipsoid', 'sphere_sphere']
    assert counts['filtered_pairs'] == 4 * 4 + 6
    assert counts['broadphase_pairs'] == BODIES * (BODIES - 1) // 2
    assert counts['narrowphase_pairs'] == counts['broadphase_pairs'] - counts['filtered_pairs']
    assert 'iterative' not in counts['pairs_by_method']
