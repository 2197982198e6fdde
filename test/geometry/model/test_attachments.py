"""Sources that go with all that is theirs, and frames that follow frames of other sources."""

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw


class Cell:
    """An arm of two links, and a part with a pin on it, which another source brings first."""

    def __init__(self):
        self.graph = graph = SceneGraph()
        self.parts, self.arm = graph.RegisterSource('parts'), graph.RegisterSource('arm')
        self.part = graph.RegisterFrame(self.parts, GeometryFrame('part'))
        self.pin = graph.RegisterFrame(self.parts, self.part, GeometryFrame('pin'))
        self.base = graph.RegisterFrame(self.arm, GeometryFrame('base'))
        self.hand = graph.RegisterFrame(self.arm, self.base, GeometryFrame('hand'))
        sources = [self.parts, self.parts, self.arm, self.arm]
        frames = [self.part, self.pin, self.base, self.hand]
        self.balls = [self.ball(s, f) for s, f in zip(sources, frames, strict=True)]
        self.floor = self.ball(self.arm, graph.world_frame_id())
        poses = {
            f: RigidTransform(RollPitchYaw(0.1 * k, 0, 0.2), [k, 0, 1])
            for k, f in enumerate(frames)
        }
        graph.SetFirstPoses(FramePoseVector(poses))

    def ball(self, source, frame):
        ball = GeometryInstance(RigidTransform(), Sphere(0.1), 'ball')
        ball.set_proximity_properties(ProximityProperties())
        return self.graph.RegisterGeometry(source, frame, ball)

    def query(self, context=None):
        context = context or self.graph.CreateDefaultContext()
        return self.graph.get_query_output_port().Eval(context)


@pytest.fixture
def cell():
    return Cell()


@pytest.mark.parametrize('on_context', [False, True])
def test_a_frame_follows_one_of_another_source_that_came_later(cell, on_context):
    graph = cell.graph
    context = graph.CreateDefaultContext()
    X_HP = RigidTransform(RollPitchYaw(0.3, 0.2, 0.1), [0, 0, 0.2])
    given = {'context': context} if on_context else {}
    graph.AttachFrame(cell.parts, cell.part, cell.hand, X_HP, **given)
    context = context if on_context else graph.CreateDefaultContext()
    X_BH = RigidTransform([0, 1, 0])
    for _ in range(2):
        query = cell.query(context)
        X_WP = query.X_WF(cell.hand) @ X_HP
        assert query.X_WF(cell.part).IsNearlyEqualTo(X_WP, 1e-14)
        X_WN = X_WP @ RigidTransform(RollPitchYaw(0.1, 0, 0.2), [1, 0, 1])
        assert query.X_WF(cell.pin).IsNearlyEqualTo(X_WN, 1e-14)
        np.testing.assert_allclose(query.X_WG(cell.balls[1]).translation(), X_WN.translation())
        context.UpdateFramePoses(FramePoseVector({cell.hand: X_BH}))
    inspector = query.inspector()
    order = inspector.FramesParentsFirst()
    for frame in order:
        assert order.index(inspector.GetParentFrame(frame)) <= order.index(frame)
    assert inspector.IsAttached(cell.part)
    assert inspector.GetHomeFrame(cell.part) == inspector.world_frame_id()
    assert inspector.GetOwningSourceName(cell.part) == 'parts'


def test_a_detached_frame_is_on_its_home_again(cell):
    graph, X = cell.graph, RigidTransform([7, 0, 0])
    graph.AttachFrame(cell.parts, cell.pin, cell.hand, X)
    graph.AttachFrame(cell.parts, cell.pin, cell.base, X)  # from hand to hand
    graph.DetachFrame(cell.parts, cell.pin, X)
    assert graph.model_inspector().GetParentFrame(cell.pin) == cell.part
    query = cell.query()
    assert query.X_WF(cell.pin).IsNearlyEqualTo(query.X_WF(cell.part) @ X, 1e-14)
    with pytest.raises(RuntimeError, match='is not attached'):
        graph.DetachFrame(cell.parts, cell.pin, X)


def test_what_cannot_follow_is_refused_and_nothing_changes(cell):
    graph, X = cell.graph, RigidTransform()
    version = graph.model_version()
    for frame, parent, word in (
        (cell.part, cell.pin, 'hangs on'),
        (cell.part, cell.part, 'hangs on'),
        (cell.part, graph.world_frame_id(), 'the world frame'),
        (cell.hand, cell.part, "belongs to source 'arm'"),
    ):
        with pytest.raises(RuntimeError, match=word):
            graph.AttachFrame(cell.parts, frame, parent, X)
    assert graph.model_version() == version


def test_an_attached_frame_is_welded_no_more(cell):
    manager = cell.graph.collision_filter_manager()
    manager.WeldToWorld([cell.part])
    assert manager.explain(cell.balls[0], cell.floor) == ['anchored']
    cell.graph.AttachFrame(cell.parts, cell.part, cell.hand, RigidTransform())
    assert manager.welded_frames() == []
    assert manager.explain(cell.balls[0], cell.floor) == []


def test_a_source_goes_with_all_that_is_its(cell):
    graph = cell.graph
    inspector, manager = graph.model_inspector(), graph.collision_filter_manager()
    manager.Apply(
        CollisionFilterDeclaration().ExcludeBetween(
            GeometrySet(cell.balls[0]), GeometrySet(cell.balls[3])
        )
    )
    context = graph.CreateSharedContext()
    assert len(cell.query(context).ComputeSignedDistancePairwiseClosestPoints()) == 9
    assert graph.RemoveSource(cell.arm) == [cell.base, cell.hand]
    assert inspector.GetAllGeometryIds() == cell.balls[:2]
    assert cell.arm not in inspector.GetAllSourceIds()
    assert manager.num_filtered_pairs() == 0
    (pair,) = cell.query(context).ComputeSignedDistancePairwiseClosestPoints()
    assert (pair.id_A, pair.id_B) == tuple(cell.balls[:2])
    assert len(cell.query().ComputeSignedDistancePairwiseClosestPoints()) == 1
    # The names are free again, all of them.
    graph.RegisterFrame(graph.RegisterSource('arm'), GeometryFrame('hand'))


def test_a_source_that_holds_others_frames_stays(cell):
    graph = cell.graph
    graph.AttachFrame(cell.parts, cell.part, cell.hand, RigidTransform())
    version = graph.model_version()
    with pytest.raises(RuntimeError, match=r"frame 'part' .*is attached.*detach it first"):
        graph.RemoveSource(cell.arm)
    with pytest.raises(RuntimeError, match='owns the world frame'):
        graph.RemoveSource(graph.model_inspector().GetOwningSourceId(graph.world_frame_id()))
    assert graph.model_version() == version
    graph.RemoveSource(cell.parts)
    graph.RemoveSource(cell.arm)
    assert graph.model_inspector().num_frames() == 1


@pytest.mark.parametrize('on_context', [False, True])
def test_a_frame_goes_with_what_is_on_it_and_all_others_stay(cell, on_context):
    graph = cell.graph
    manager = graph.collision_filter_manager()
    manager.Apply(
        CollisionFilterDeclaration().ExcludeBetween(
            GeometrySet([cell.balls[1], cell.balls[2]]), GeometrySet([cell.balls[0]])
        )
    )
    context = graph.CreateDefaultContext()
    before = pairs(cell.query(context))
    given = {'context': context} if on_context else {}
    graph.RemoveFrame(cell.parts, cell.pin, **given)
    query = cell.query(context) if on_context else cell.query()
    left = {pair for pair in before if cell.balls[1].get_value() not in pair}
    assert pairs(query) == left != before
    assert query.inspector().FramesForSource(cell.parts) == {cell.part}
    with pytest.raises(RuntimeError, match='not'):
        query.X_WF(cell.pin)
    # Its name is free.
    again = graph.RegisterFrame(cell.parts, cell.part, GeometryFrame('pin'), **given)
    assert again != cell.pin


def pairs(query):
    found = query.ComputeSignedDistancePairwiseClosestPoints()
    return set(zip(found.id_A.tolist(), found.id_B.tolist(), strict=True))


def test_a_frame_that_others_hang_on_stays(cell):
    graph = cell.graph
    before = graph.model_version()
    with pytest.raises(RuntimeError, match=r'RemoveFrame: .*pin.* hangs on .*part'):
        graph.RemoveFrame(cell.parts, cell.part)
    with pytest.raises(RuntimeError, match='arm'):
        graph.RemoveFrame(cell.parts, cell.hand)
    graph.AttachFrame(cell.parts, cell.part, cell.hand, RigidTransform())
    with pytest.raises(RuntimeError, match='hangs on'):
        graph.RemoveFrame(cell.arm, cell.hand)
    assert graph.model_version() == before + 1
    with pytest.raises(RuntimeError):
        graph.RemoveFrame(graph.RegisterSource('other'), graph.world_frame_id())
