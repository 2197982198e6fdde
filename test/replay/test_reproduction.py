"""A replay asks the very same: the answer of a rebuilt scene has the same bits."""

import dataclasses
import math

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.replay import Replay, recorded, reproduce
from drake_geom_ros.scene_files import SceneFileError

SHAPES = [Sphere(0.1), Box(0.1, 0.2, 0.3), Cylinder(0.1, 0.2), Ellipsoid(0.1, 0.15, 0.2)]
SHAPES += [Capsule(0.05, 0.2), HalfSpace()]


class Scene:
    """One of each shape, turned on its frame; frames hang on each other."""

    def __init__(self, seed=0):
        self.rng = np.random.default_rng(seed)
        self.graph = SceneGraph()
        source = self.graph.RegisterSource('s')
        self.frames, parent = [], ()
        for number, shape in enumerate(SHAPES):
            frame = self.graph.RegisterFrame(source, *parent, GeometryFrame(f'f{number}'))
            self.frames.append(frame)
            parent = (frame,) if number % 2 else ()
            instance = GeometryInstance(self.pose(0.05), shape, 'g')
            instance.set_proximity_properties(ProximityProperties())
            self.graph.RegisterGeometry(source, frame, instance)
        self.context = self.graph.CreateDefaultContext()
        self.query = self.graph.get_query_output_port().Eval(self.context)
        self.move(0.2)

    def pose(self, reach):
        angles, p = self.rng.uniform(-3, 3, 3), self.rng.uniform(-reach, reach, 3)
        return RigidTransform(RollPitchYaw(*angles), p)

    def move(self, reach):
        self.context.UpdateFramePoses(FramePoseVector({f: self.pose(reach) for f in self.frames}))

    def creep(self):
        step = RigidTransform(RollPitchYaw(0.01, 0.02, 0.0), [0.001, 0.0, 0.002])
        X_PFs = {frame: self.query.X_PF(frame) @ step for frame in self.frames}
        self.context.UpdateFramePoses(FramePoseVector(X_PFs))

    def ask(self, accuracy='exact'):
        return self.query.ComputeSignedDistancePairwiseClosestPoints(accuracy=accuracy)


def same_bits(a, b):
    return repr(dataclasses.asdict(a)) == repr(dataclasses.asdict(b))


@pytest.mark.parametrize('accuracy', ['bound', 'fast', 'exact'])
def test_every_pair_is_reproduced_to_the_last_bit(accuracy):
    scene = Scene(1)
    results = scene.ask(accuracy)
    assert len(results) == 15
    for index in range(len(results)):
        replay = recorded(scene.query, results, index, accuracy, math.inf)
        assert same_bits(reproduce(replay), replay.answer)
        assert not replay.answer.breaks_promise
        assert replay.ids == (results.id_A[index], results.id_B[index])


def test_a_hint_is_kept_where_it_matters_and_then_reproduces():
    scene = Scene(2)
    before = scene.ask('fast')
    scene.creep()
    results = scene.ask('fast')
    kept = 0
    for index in range(len(results)):
        hint = tuple(before.nhat_BA_W[index].tolist())
        replay = recorded(scene.query, results, index, 'fast', math.inf, hint)
        assert replay.question.hint in (None, hint)
        kept += replay.question.hint is not None
        assert same_bits(reproduce(replay), replay.answer)
    # Closed forms need none.
    assert 0 < kept < len(results)


def test_filters_are_no_part_of_the_question():
    scene = Scene(3)
    results = scene.ask()
    ids = [results[0].id_A, results[0].id_B]
    declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(ids))
    scene.graph.collision_filter_manager(scene.context).Apply(declaration)
    replay = recorded(scene.query, results, 0, 'exact', math.inf)
    assert 'filters' not in replay.scene
    assert same_bits(reproduce(replay), replay.answer)


def changed(**question):
    """Return a replay whose question is changed."""
    scene = Scene(4)
    replay = recorded(scene.query, scene.ask(), 0, 'exact', math.inf)
    return dataclasses.replace(replay, question=dataclasses.replace(replay.question, **question))


@pytest.mark.parametrize(
    ('question', 'message'),
    [
        ({'geometry_a': ('s', 'f0', 'nobody')}, "case.json: question: .*'s::f0/nobody'"),
        ({'geometry_a': ('s', 'f1', 'g'), 'geometry_b': ('s', 'f1', 'g')}, 'are the same'),
        ({'accuracy': 'superb'}, 'superb'),
    ],
)
def test_a_question_that_cannot_be_asked_is_refused(question, message):
    with pytest.raises(GeometryError, match=message):
        reproduce(changed(**question), 'case.json')


def test_a_scene_that_cannot_be_loaded_names_the_file():
    replay: Replay = dataclasses.replace(changed(), scene='frames: 7')
    with pytest.raises(SceneFileError, match=r'case\.json: scene'):
        reproduce(replay, 'case.json')
