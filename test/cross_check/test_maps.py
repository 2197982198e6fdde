"""FCL's octree about sensed maps: it agrees, is heard where not, and is silent where it cannot."""

import dataclasses

import numpy as np
import pytest
from cross_check.test_second_opinion import batch_of
from oracles.shape_scenes import SHAPES, ShapeScene

from drake_geom_ros.cross_check.question import AGREED, DISAGREED, SILENT, questions_of
from drake_geom_ros.cross_check.second_opinion import SecondOpinion
from drake_geom_ros.geometry import (
    HalfSpace,
    OccupiedCells,
    PointCloud,
    ProximityProperties,
    RoleAssign,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import random_rotation

pytestmark = [pytest.mark.processes, pytest.mark.everything]

NAMES = [name for name in SHAPES if name != 'half_space']
EDGE = 0.05


def random_cells(rng, count=60, reach=8):
    return OccupiedCells(EDGE, EDGE * (rng.integers(-reach, reach, (count, 3)) + 0.5))


def random_pose(rng, reach):
    return RigidTransform(RotationMatrix(random_rotation(rng)), rng.uniform(-reach, reach, 3))


def asked(scene, *poses):
    query = scene.posed(*poses).query
    results = query.ComputeSignedDistancePairwiseClosestPoints()
    return query, questions_of(query, results, range(len(results)))


@pytest.mark.parametrize('name', NAMES)
def test_fcl_agrees_about_random_maps(name):
    rng, opinion, apart, overlapping = np.random.default_rng(2), SecondOpinion(), 0, 0
    for _ in range(4):
        scene = ShapeScene(random_cells(rng), SHAPES[name])
        for _ in range(12):
            query, questions = asked(scene, random_pose(rng, 0.2), random_pose(rng, 0.9))
            (verdict,) = opinion.judge(batch_of(query, questions, version=rng.integers(2**40)))
            assert verdict.verdict == AGREED, verdict
            overlapping += questions[0].distance < 0.0
            apart += questions[0].distance > 0.0
    opinion.close()
    assert min(apart, overlapping) >= 3


def test_fcl_agrees_about_two_maps():
    rng, opinion = np.random.default_rng(3), SecondOpinion()
    scene = ShapeScene(random_cells(rng), random_cells(rng, 40))
    for _ in range(12):
        query, questions = asked(scene, random_pose(rng, 0.2), random_pose(rng, 1.5))
        (verdict,) = opinion.judge(batch_of(query, questions))
        assert verdict.verdict == AGREED, verdict
    opinion.close()


def test_a_wrong_answer_about_a_map_is_a_disagreement():
    rng, opinion = np.random.default_rng(4), SecondOpinion()
    scene = ShapeScene(random_cells(rng), Sphere(0.1))
    query, questions = asked(scene, RigidTransform(), RigidTransform([1.0, 0, 0]))
    for step in (-0.01, 0.01):
        wrong = [dataclasses.replace(q, distance=q.distance + step) for q in questions]
        (verdict,) = opinion.judge(batch_of(query, wrong))
        assert verdict.verdict == DISAGREED
    opinion.close()


def test_where_fcl_has_no_words_for_a_map_it_is_silent():
    opinion, cells = SecondOpinion(), random_cells(np.random.default_rng(5))
    beside = OccupiedCells(EDGE, cells.centres() + 0.01)
    for version, (shape, margin, told) in enumerate(
        [
            (PointCloud(0.02, cells.centres()), 0.0, 'no balls'),
            (beside, 0.0, 'grid of an octree'),
            (cells, 0.01, 'margin'),
        ]
    ):
        scene = ShapeScene(shape, Sphere(0.1))
        properties = ProximityProperties()
        properties.AddProperty('map', 'margin', margin)
        scene.graph.AssignRole(
            scene.context, scene.source, scene.ids[0], properties, RoleAssign.kReplace
        )
        query, questions = asked(scene, RigidTransform(), RigidTransform([1.0, 0, 0]))
        (verdict,) = opinion.judge(batch_of(query, questions, version))
        assert verdict.verdict == SILENT
        assert told in verdict.text
    scene = ShapeScene(cells, anchored=[(HalfSpace(), RigidTransform())])
    query, questions = asked(scene, RigidTransform([0, 0, 1.0]))
    (verdict,) = opinion.judge(batch_of(query, questions, 9))
    assert verdict.verdict == SILENT
    assert 'half space' in verdict.text
    opinion.close()
