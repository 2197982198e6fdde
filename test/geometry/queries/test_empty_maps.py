"""A sensed map without cells is in no answer: a scene with one answers as the scene without it."""

import numpy as np
import pytest

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import (
    Box,
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    FramePoseVector,
    GeometryError,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    MakeRenderEngineExact,
    OccupiedCells,
    PerceptionProperties,
    PointCloud,
    ProximityProperties,
    RenderCameraCore,
    RenderEngineExactParams,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.queries.context import state_of
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.sensors import CameraInfo

ABOVE = RigidTransform(RotationMatrix(np.diag([1.0, -1.0, -1.0])), [0.2, 0.0, 3.0])  # looks down
NO_CELLS = np.zeros((0, 3))
EMPTY = [OccupiedCells(0.1, NO_CELLS), PointCloud(0.1, NO_CELLS)]
CAMERA = DepthRenderCamera(
    RenderCameraCore('eye', CameraInfo(40, 30, 1.0), ClippingRange(0.05, 20.0), RigidTransform()),
    DepthRange(0.1, 10.0),
)
FULL = OccupiedCells(0.1, [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]])


def _instance(shape, name):
    instance = GeometryInstance(RigidTransform(), shape, name)
    instance.set_proximity_properties(ProximityProperties())
    instance.set_perception_properties(PerceptionProperties())
    return instance


class _Scene:
    """Balls, a box and the ground, with or without a map on a frame of its own."""

    def __init__(self, shape=None, crowd=0):
        self.graph = SceneGraph()
        self.graph.AddRenderer('eye', MakeRenderEngineExact(RenderEngineExactParams()))
        self.source = self.graph.RegisterSource('scene')
        shapes = [Sphere(0.1), Box(0.2, 0.3, 0.1), Sphere(0.2)]
        self.frames = []
        for k, each in enumerate(shapes):
            frame = self.graph.RegisterFrame(self.source, GeometryFrame(f'{k}'))
            self.graph.RegisterGeometry(self.source, frame, _instance(each, f'{k}'))
            self.frames.append(frame)
        self.graph.RegisterAnchoredGeometry(self.source, _instance(HalfSpace(), 'ground'))
        for k in range(crowd):  # far away, so that grids find who is near
            ball = GeometryInstance(RigidTransform([5.0 + k, 0.0, 0.0]), Sphere(0.1), f'far {k}')
            ball.set_proximity_properties(ProximityProperties())
            self.graph.RegisterGeometry(self.source, self.frames[2], ball)
        self.seen = None
        if shape is not None:
            self.of_map = self.graph.RegisterFrame(self.source, GeometryFrame('map'))
            instance = _instance(shape, 'map')
            self.seen = self.graph.RegisterGeometry(self.source, self.of_map, instance)
        self.context = self.graph.CreateDefaultContext()
        self.pose([[0.0, 0.0, 0.3], [0.15, 0.0, 0.3], [0.5, 0.0, 0.0]])
        if shape is not None:
            at = RigidTransform([0.1, 0.0, 0.3])
            self.context.UpdateFramePoses(FramePoseVector({self.of_map: at}))

    def pose(self, places):
        poses = {f: RigidTransform(p) for f, p in zip(self.frames, places, strict=True)}
        self.context.UpdateFramePoses(FramePoseVector(poses))

    def show(self, shape):
        self.graph.ChangeShape(self.context, self.source, self.seen, shape)

    @property
    def query(self):
        return self.graph.get_query_output_port().Eval(self.context)

    def _named(self, id):
        return self.query.inspector().GetName(id)

    def answers(self):
        """Return the answers of all kinds of queries, by names."""
        query, points = self.query, np.array([[0.1, 0.0, 0.3], [0.0, 0.0, 9.0]])
        ends = FramePoseVector({self.frames[0]: RigidTransform([0.0, 1.0, 0.3])})
        motion = query.CheckMotion(ends)
        states = np.array([[[*p, 0, 0, 0, 1]] for p in ([0.0, 0, 0.3], [0.0, 0, 2.0])])
        ids = np.array([self.frames[0].get_value()])
        least = evaluate(self.context, ids, states, want='least')
        nearest = evaluate(self.context, ids, states, want='points', points=points)
        collide = evaluate(self.context, ids, states, want='collision').tolist()
        W = query.inspector().world_frame_id()
        image = query.RenderDepthImage(CAMERA, W, ABOVE)
        return {
            'pairs': [
                (self._named(r.id_A), self._named(r.id_B), r.distance)
                for r in query.ComputeSignedDistancePairwiseClosestPoints()
            ],
            'contacts': [
                (self._named(r.id_A), self._named(r.id_B), r.depth)
                for r in query.ComputePointPairPenetration()
            ],
            'collides': query.HasCollisions(),
            'points': [
                (self._named(r.id_G), r.distance)
                for point in points
                for r in query.ComputeSignedDistanceToPoint(point)
            ],
            'candidates': sorted(
                (self._named(a), self._named(b)) for a, b in query.FindCollisionCandidates()
            ),
            'motion': (motion.outcome, motion.times, motion.distance),
            'states': (collide, least.distance.tolist(), nearest.distance.tolist()),
            'image': np.asarray(image.data).tolist(),
            'waiting': (query.waiting_frames(), query.num_waiting_pairs()),
            'whole': query.num_waiting_geometries(),
        }


@pytest.mark.parametrize('empty', EMPTY)
def test_a_scene_with_an_empty_map_answers_as_the_scene_without_it(empty):
    scene, without = _Scene(empty), _Scene()
    assert scene.answers() == without.answers()
    scene.pose(np.tile([0.1, 0.0, 0.3], (3, 1)))
    without.pose(np.tile([0.1, 0.0, 0.3], (3, 1)))
    assert scene.answers() == without.answers()


@pytest.mark.parametrize('crowd', [0, 200])
@pytest.mark.parametrize('empty', EMPTY)
def test_a_map_may_lose_all_cells_and_get_some_again(empty, crowd):
    scene = _Scene(FULL, crowd)
    full, without = _Scene(FULL, crowd).answers(), _Scene(None, crowd).answers()
    assert full['pairs'] != without['pairs']
    assert full['image'] != without['image']
    for _ in range(2):
        assert scene.answers() == full
        scene.show(empty)
        assert scene.answers() == without
        scene.show(FULL)


def test_an_empty_map_on_a_frame_without_a_pose_waits():
    scene = _Scene()
    frame = scene.graph.RegisterFrame(scene.context, scene.source, GeometryFrame('late'))
    scene.graph.RegisterGeometry(scene.context, scene.source, frame, _instance(EMPTY[0], 'map'))
    with pytest.raises(GeometryError, match=r"never had a pose: 'late'"):
        scene.query.ComputePointPairPenetration()
    assert (scene.query.num_waiting_pairs(), scene.query.num_waiting_geometries()) == (4, 1)


@pytest.mark.parametrize('empty', EMPTY)
def test_the_distance_of_an_empty_map_is_refused(empty):
    scene = _Scene(empty)
    body = scene.query.inspector().GetAllGeometryIds()[0]
    with pytest.raises(GeometryError, match=r"'map' is a map without cells, .* at no distance"):
        scene.query.ComputeSignedDistancePairClosestPoints(body, scene.seen)


def test_motions_prepared_for_an_empty_map_are_not_taken_for_one_with_cells():
    """Their pairs lack the map: what only changed its shape would look free."""
    empty, full = (_Scene(shape).context for shape in (EMPTY[0], FULL))
    worlds = [state_of(context).up_to_date_world() for context in (empty, full)]
    assert not worlds[0].has_other_shapes_only(worlds[1])
    assert not worlds[1].has_other_shapes_only(worlds[0])
    other = state_of(_Scene(OccupiedCells(0.1, [[0.0, 0.0, 9.0]])).context).up_to_date_world()
    assert worlds[1].has_other_shapes_only(other)
