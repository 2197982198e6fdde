"""A scene that is changed step by step answers as one that is built at once, to the bit."""

from concurrent.futures import ThreadPoolExecutor
from copy import copy
from functools import partial
from threading import Event

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    HalfSpace,
    MeshData,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    SceneGraphContext,
    Sphere,
)
from drake_geom_ros.geometry import CollisionFilterDeclaration as Declaration
from drake_geom_ros.geometry.queries.context import state_of
from drake_geom_ros.math import RigidTransform, RollPitchYaw

CORNERS = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.2]])
# Pairs of these have closed forms, so no warm start changes a bit of their answers.
CLOSED = Sphere(0.1), Box(0.2, 0.1, 0.15), Capsule(0.05, 0.2), Sphere(0.02)
OTHERS = HalfSpace(), Convex.FromMeshData(MeshData(CORNERS, ()))
EXAMPLES = 8 if config.DISABLE_JIT else 40
CHANGES = (
    *('anchor', 'attach', 'remove', 'shape', 'repose', 'lose', 'gain', 'pad'),
    *('exclude', 'allow', 'frame', 'move', 'wait', 'place', 'unpose'),
)

OF_CONTEXTS = (
    *('RegisterFrame', 'RegisterGeometry', 'RemoveGeometry', 'ChangeShape'),
    *('RemoveRole', 'AssignRole', 'collision_filter_manager'),
)


class Changing:
    """A scene of anchored and moving bodies, a context that sees its changes, and the changes."""

    def __init__(self, seed, anchored, moving, shapes):
        self.rng, self.shapes = np.random.default_rng(seed), shapes
        self.graph = SceneGraph()
        self.source = self.graph.RegisterSource('changing')
        self.size = 0.25 * (anchored + moving) ** (1 / 3) + 0.2
        self.frames, self.ids, self.count = [], [], 0
        for _ in range(moving):
            self.frame()
        for _ in range(anchored):
            self.anchor()
        self.context = self.graph.CreateSharedContext(partial=True)
        self.query = self.graph.get_query_output_port().Eval(self.context)
        self.pose(self.frames)

    def pose(self, frames):
        poses = {frame: self.somewhere() for frame in frames}
        self.context.UpdateFramePoses(FramePoseVector(poses))

    def somewhere(self):
        if self.rng.integers(4) == 0:
            return RigidTransform()  # where a frame is before it has a pose
        angles, p = self.rng.uniform(-3, 3, 3), self.rng.uniform(-self.size, self.size, 3)
        return RigidTransform(RollPitchYaw(*angles), p)

    def add(self, frame, properties=True):
        self.count += 1
        shape = self.shapes[self.rng.integers(len(self.shapes))]
        pose = self.somewhere() if frame == self.graph.world_frame_id() else RigidTransform()
        instance = GeometryInstance(pose, shape, f'body {self.count}')
        if properties:
            instance.set_proximity_properties(ProximityProperties())
        self.ids.append(self.graph.RegisterGeometry(self.source, frame, instance))

    def any_id(self):
        return self.ids[self.rng.integers(len(self.ids))]

    def any_frame(self):
        return self.frames[self.rng.integers(len(self.frames))]

    def anchor(self):
        self.add(self.graph.world_frame_id())

    def attach(self):
        self.add(self.any_frame())

    def frame(self):
        frame = GeometryFrame(f'frame {len(self.frames)}')
        parent = self.any_frame() if self.frames and self.rng.integers(3) == 0 else None
        parents = [] if parent is None else [parent]
        self.frames.append(self.graph.RegisterFrame(self.source, *parents, frame))
        self.add(self.frames[-1])
        if hasattr(self, 'context'):
            self.pose(self.frames[-1:])

    def wait(self):
        self.frames.append(
            self.graph.RegisterFrame(self.source, GeometryFrame(f'frame {len(self.frames)}'))
        )
        self.add(self.frames[-1])

    def remove(self):
        id = self.any_id()
        self.ids.remove(id)
        self.graph.RemoveGeometry(self.source, id)

    def shape(self):
        shape = self.shapes[self.rng.integers(len(self.shapes))]
        self.graph.ChangeShape(self.source, self.any_id(), shape)

    def repose(self):
        id = self.any_id()
        shape = self.graph.model_inspector().GetShape(id)
        self.graph.ChangeShape(self.source, id, shape, self.somewhere())

    def lose(self):
        self.graph.RemoveRole(self.source, geometry_id=self.any_id(), role=Role.kProximity)

    def gain(self):
        id = self.any_id()
        has_it = self.graph.model_inspector().GetProximityProperties(id) is not None
        assign = RoleAssign.kReplace if has_it else RoleAssign.kNew
        self.graph.AssignRole(self.source, id, ProximityProperties(), assign)

    def pad(self):
        id, properties = self.any_id(), ProximityProperties()
        properties.AddProperty('proximity', 'padding', 0.01)
        if self.graph.model_inspector().GetProximityProperties(id) is not None:
            self.graph.AssignRole(self.source, id, properties, RoleAssign.kReplace)

    def filter(self, statement):
        ids = [id for id in self.ids if self.rng.integers(4) == 0]
        inspector = self.graph.model_inspector()
        ids = [id for id in ids if inspector.GetProximityProperties(id) is not None]
        declaration = getattr(Declaration(), statement)(GeometrySet(ids))
        self.graph.collision_filter_manager().Apply(declaration)

    def exclude(self):
        self.filter('ExcludeWithin')

    def allow(self):
        self.filter('AllowWithin')

    def move(self):
        self.pose([frame for frame in self.frames if self.rng.integers(3) == 0])

    def place(self):
        waiting = self.query.waiting_frames()
        self.pose([frame for frame in waiting if self.rng.integers(2) == 0])

    def unpose(self):
        self.context.UnposeFrames([f for f in self.frames if self.rng.integers(4) == 0])

    def built_at_once(self):
        """Return a query object of the same content, with the same poses, that has no past."""
        context = self.graph.CreateSharedContext(partial=True)
        waiting = set(self.query.waiting_frames())
        frames = [frame for frame in self.frames if frame not in waiting]
        poses = {frame: self.query.X_PF(frame) for frame in frames}
        context.UpdateFramePoses(FramePoseVector(poses))
        return self.graph.get_query_output_port().Eval(context)


class OnContext:
    """A scene graph whose changes are those of a context's copy of the model."""

    def __init__(self, graph, context):
        self.graph, self.context = graph, context

    def __getattr__(self, name):
        method = getattr(self.graph, name)
        return partial(method, context=self.context) if name in OF_CONTEXTS else method

    def model_inspector(self):
        return self.graph.get_query_output_port().Eval(self.context).inspector()

    def CreateSharedContext(self, partial):
        state = state_of(self.context)
        return SceneGraphContext(state.model, state.filters, state.accuracy, partial)


def copied(scene):
    """Return a copy of a scene, with a context whose tables are shared with that of the other."""
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    other = copy(scene)
    other.rng = np.random.default_rng(scene.rng.integers(1000))
    other.frames, other.ids = list(scene.frames), list(scene.ids)
    other.context = scene.context.Clone()
    graph = scene.graph.graph if isinstance(scene.graph, OnContext) else scene.graph
    other.graph = OnContext(graph, other.context)
    other.query = graph.get_query_output_port().Eval(other.context)
    return other


def columns_of(results):
    """Return all arrays of results, by name."""
    names = ('id_A', 'id_B', 'id_G', 'point_index', 'distance', 'depth', 'error_bound', 'method')
    names += ('nhat_BA_W', 'p_WCa', 'p_WCb', 'p_ACa', 'p_BCb', 'p_GN', 'grad_W')
    names += ('gradients', 'is_gradient_unique')
    return {name: getattr(results, name) for name in names if hasattr(results, name)}


def assert_same(query, fresh, accuracy):
    p_WQs = np.linspace(-0.5, 0.5, 12).reshape(4, 3)
    for name, arguments in (
        ('ComputeSignedDistancePairwiseClosestPoints', (0.1,)),
        ('ComputePointPairPenetration', ()),
        ('ComputeSignedDistanceToPoint', (p_WQs, 0.2)),
    ):
        keywords = {} if 'Point' in name[-5:] else {'accuracy': accuracy}
        one, other = (columns_of(getattr(q, name)(*arguments, **keywords)) for q in (query, fresh))
        for column, values in one.items():
            np.testing.assert_array_equal(values, other[column], err_msg=f'{name}.{column}')
    assert query.HasCollisions(accuracy=accuracy) == fresh.HasCollisions(accuracy=accuracy)
    assert query.FindCollisionCandidates() == fresh.FindCollisionCandidates()
    assert query.num_waiting_pairs() == fresh.num_waiting_pairs()


def test_a_shape_that_changes_before_its_frame_is_posed_at_the_origin():
    """As a sensed map does: its frame waits, its cells come, and its first pose is identity."""
    scene = Changing(1, 8, 2, CLOSED)
    scene.wait()
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    scene.graph.ChangeShape(scene.source, scene.ids[-1], Sphere(0.3))
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    scene.context.UpdateFramePoses(FramePoseVector({scene.frames[-1]: RigidTransform()}))
    assert_same(scene.query, scene.built_at_once(), 'exact')


@pytest.mark.parametrize('change', CHANGES)
def test_results_of_before_a_change_stay_what_they_were(change):
    scene = Changing(2, 20, 6, CLOSED)
    scene.wait()
    kept, again = (scene.query.ComputeSignedDistancePairwiseClosestPoints() for _ in range(2))
    expected = columns_of(again)
    del again
    for _ in range(5):
        getattr(scene, change)()
        assert_same(scene.query, scene.built_at_once(), 'exact')
    for column, values in columns_of(kept).items():
        np.testing.assert_array_equal(values, expected[column], err_msg=column)


steps = st.lists(st.tuples(st.sampled_from(CHANGES), st.booleans()), min_size=1, max_size=12)


@settings(max_examples=EXAMPLES, deadline=None)
@given(st.integers(0, 999), st.sampled_from((8, 40)), steps)
def test_any_changes_answer_as_a_scene_built_at_once(seed, anchored, steps):
    scene = Changing(seed, anchored, 6, CLOSED)
    assert_same(scene.query, scene.built_at_once(), 'exact')
    for change, is_asked in steps:
        getattr(scene, change)()
        if is_asked:
            assert_same(scene.query, scene.built_at_once(), 'exact')
    assert_same(scene.query, scene.built_at_once(), 'exact')


@settings(max_examples=EXAMPLES // 2, deadline=None)
@given(
    st.integers(0, 999),
    st.lists(st.tuples(st.integers(0, 3), st.sampled_from(CHANGES), st.booleans()), max_size=16),
)
def test_copies_that_live_at_once_never_see_the_changes_of_each_other(seed, steps):
    """Copies share the memory of tables, and each may append to it."""
    scenes = [Changing(seed, 8, 3, CLOSED)]
    scenes[0].anchor()
    for number, change, is_copied in steps:
        scene = scenes[number % len(scenes)]
        if is_copied:
            scenes.append(copied(scene))
        getattr(scene, change)()
        for each in scenes:
            assert_same(each.query, each.built_at_once(), 'exact')


def test_snapshots_answer_in_threads_as_before_while_the_scene_grows():
    scene = Changing(4, 30, 4, CLOSED)
    expected = columns_of(scene.query.ComputeSignedDistancePairwiseClosestPoints(0.3))
    snapshots = [scene.context.what_if() for _ in range(4)]
    has_ended = Event()

    def answers(snapshot):
        query = scene.graph.get_query_output_port().Eval(snapshot)
        count = 0
        while not has_ended.is_set() or not count:
            snapshot.UpdateFramePoses(
                FramePoseVector({frame: query.X_PF(frame) for frame in scene.frames})
            )
            columns = columns_of(query.ComputeSignedDistancePairwiseClosestPoints(0.3))
            for name, values in columns.items():
                np.testing.assert_array_equal(values, expected[name], err_msg=name)
            count += 1
        return count

    with ThreadPoolExecutor(4) as pool:
        futures = [pool.submit(answers, snapshot) for snapshot in snapshots]
        try:
            for turn in range(60):
                scene.anchor() if turn % 3 else scene.remove()
                scene.query.ComputeSignedDistancePairwiseClosestPoints(0.3)
        finally:
            has_ended.set()
        assert all(future.result() > 0 for future in futures)
    assert_same(scene.query, scene.built_at_once(), 'exact')


@pytest.mark.parametrize(
    ('shapes', 'accuracy'), [(CLOSED, 'exact'), (CLOSED + OTHERS, 'bound')], ids=('exact', 'bound')
)
def test_many_changes_of_a_scene_in_grids(shapes, accuracy):
    scene = Changing(3, 300, 20, shapes)
    for turn in range(200):
        # Mostly anchored ones: more come than a neighbour list keeps apart.
        change = 'anchor' if turn % 2 else CHANGES[scene.rng.integers(len(CHANGES))]
        getattr(scene, change)()
        scene.query.ComputeSignedDistancePairwiseClosestPoints(0.1, accuracy=accuracy)
        if turn % 8 == 0 or turn > 190:
            assert_same(scene.query, scene.built_at_once(), accuracy)
