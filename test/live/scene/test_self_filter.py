"""Points on bodies that the scene knows, against the distance of each point from each body."""

import numpy as np
import pytest
from oracles.shape_scenes import SHAPES, ShapeScene

from drake_geom_ros.geometry import HalfSpace, Role, SceneGraph
from drake_geom_ros.live.scene.self_filter import KnownBodies, SelfFilter, bodies_of
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.scene_files import load_scene
from truth.bodies.random_bodies import random_rotation

BODIES = [SHAPES[name] for name in SHAPES if name != 'half_space']


def posed(scene, rng, reach, offset):
    poses = [
        RigidTransform(
            RotationMatrix(random_rotation(rng)), offset + rng.uniform(-reach, reach, 3)
        )
        for _ in BODIES
    ]
    scene.posed(*poses)
    return np.array([X.translation() for X in poses])


def then(known, query, geometries):
    known.know(query, geometries)
    return known.then(query)


def one_by_one(scene, p_WQs, padding):
    near = scene.query.ComputeSignedDistanceToPoint(p_WQs, padding)
    truth = np.zeros(len(p_WQs), dtype=bool)
    truth[near.point_index] = True
    return truth


@pytest.mark.parametrize('padding', [0.0, 0.05])
@pytest.mark.parametrize(('reach', 'offset'), [(0.5, 0.0), (300.0, 0.0), (0.5, 1e6)])
def test_the_points_that_are_near_are_those_of_all_one_by_one(reach, offset, padding):
    rng = np.random.default_rng(round(reach))
    scene, tested, told = ShapeScene(*BODIES), SelfFilter(), {True: 0, False: 0}
    known = KnownBodies()
    geometries = scene.query.inspector().GetAllGeometryIds(Role.kProximity)
    for _ in range(4):  # bodies move, and the filter knows them already
        centres = posed(scene, rng, reach, offset)
        p_WQs = np.concatenate(
            [c + rng.uniform(-0.4, 0.4, (200, 3)) for c in centres]
            + [offset + rng.uniform(-2.0 * reach, 2.0 * reach, (200, 3)), [[1e9, 0.0, 0.0]]]
        )
        found = tested.within(then(known, scene.query, geometries), p_WQs, padding)
        assert found.tolist() == one_by_one(scene, p_WQs, padding).tolist()
        for is_near in found.tolist():
            told[is_near] += 1
    assert min(told.values()) > 100


@pytest.mark.parametrize('padding', [0.0, 0.03, 0.06])
@pytest.mark.parametrize('offset', [0.0, 1e5])
def test_points_that_lie_close_together_are_near_or_not_as_each_by_itself(offset, padding):
    rng = np.random.default_rng(7)
    scene, tested = ShapeScene(*BODIES), SelfFilter()
    geometries = scene.query.inspector().GetAllGeometryIds(Role.kProximity)
    centres = posed(scene, rng, 1.0, offset)
    places = np.concatenate([c + rng.uniform(-0.15, 0.15, (100, 3)) for c in centres])
    p_WQs = np.repeat(places, 40, axis=0) + rng.uniform(-0.004, 0.004, (40 * len(places), 3))
    asked = []
    real = tested._distances

    def counting(bodies, points, threshold):
        asked.append(len(points))
        return real(bodies, points, threshold)

    tested._distances = counting
    found = tested.within(then(KnownBodies(), scene.query, geometries), p_WQs, padding)
    assert found.tolist() == one_by_one(scene, p_WQs, padding).tolist()
    assert 0.1 < found.mean() < 0.9
    assert sum(asked) < 0.7 * len(p_WQs)  # cubes told of most of them


def test_a_half_space_is_near_wherever_its_side_is():
    scene = ShapeScene(HalfSpace(), BODIES[0]).posed(RigidTransform(), RigidTransform([9, 0, 0]))
    geometries = scene.query.inspector().GetAllGeometryIds(Role.kProximity)
    p_WQs = np.array([[1e5, 0.0, -1.0], [0.0, 0.0, 0.5], [9.0, 0.0, 0.1], [-1e5, 1e5, 0.01]])
    found = SelfFilter().within(then(KnownBodies(), scene.query, geometries), p_WQs, 0.05)
    assert found.tolist() == [True, False, True, True]


ATTACHED = """
sources: [robot, part, label, other]
frames:
- {name: tool, source: robot, pose: {}}
- {name: held, source: part, pose: {}}
- {name: shown, source: label, pose: {}}
- {name: away, source: other, pose: {}}
geometries:
- {name: ball, source: robot, frame: tool, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: part, frame: held, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: label, frame: shown, shape: {type: sphere, radius: 0.1}}
- {name: ball, source: other, frame: away, shape: {type: sphere, radius: 0.1}}
"""


def test_what_hangs_on_a_robot_is_left_out_with_it_until_it_is_let_go():
    graph = SceneGraph()
    loaded = load_scene(ATTACHED, graph)
    sources, frames = loaded.sources, loaded.frames
    tool, held, shown = (
        frames[at] for at in (('robot', 'tool'), ('part', 'held'), ('label', 'shown'))
    )
    query = graph.get_query_output_port().Eval(graph.CreateSharedContext())

    def left_out():
        ids = set(bodies_of(query, {'robot'}, None))
        return [
            source for (source, _, _), geometry in loaded.geometries.items() if geometry in ids
        ]

    assert left_out() == ['robot']
    graph.AttachFrame(sources['part'], held, tool, RigidTransform())
    graph.AttachFrame(sources['label'], shown, held, RigidTransform())
    assert left_out() == ['robot', 'part', 'label']
    graph.DetachFrame(sources['label'], shown, RigidTransform())
    graph.AttachFrame(sources['label'], shown, held, RigidTransform(), is_part=False)
    assert left_out() == ['robot', 'part']  # declared to be no part of the robot
    graph.DetachFrame(sources['part'], held, RigidTransform())
    assert left_out() == ['robot']
