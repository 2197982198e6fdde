"""SceneGraphInspector: every method of the API page, in stable order, with errors that tell."""

import pytest
from oracles.small_scene import instance

from drake_geom_ros.geometry import (
    Box,
    FrameId,
    GeometryFrame,
    GeometryId,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    Role,
    SceneGraph,
    SceneGraphInspector,
    SourceId,
)
from drake_geom_ros.math import RigidTransform

WORLD = SceneGraph.world_frame_id()
NO_SOURCE, NO_FRAME, NO_GEOMETRY = SourceId(10**6), FrameId(10**6), GeometryId(10**9)


@pytest.fixture
def inspector(scene):
    return scene.scene_graph.model_inspector()


def test_sources(scene, inspector):
    internal, *registered = inspector.GetAllSourceIds()
    assert registered == [scene.arm, scene.room]
    assert inspector.num_sources() == 3
    assert inspector.GetName(internal) == 'SceneGraphInternal'
    assert inspector.GetSourceName(scene.arm) == inspector.GetName(scene.arm) == 'arm'
    assert inspector.SourceIsRegistered(scene.arm)
    assert not inspector.SourceIsRegistered(NO_SOURCE)
    assert inspector.NumFramesForSource(scene.arm) == 2
    assert inspector.NumFramesForSource(internal) == 1
    assert inspector.FramesForSource(scene.arm) == {scene.upper, scene.lower}
    assert inspector.FramesForSource(scene.room) == set()


def test_owners(scene, inspector):
    for id in (scene.upper, scene.ball):
        assert inspector.BelongsToSource(id, scene.arm)
        assert not inspector.BelongsToSource(id, scene.room)
        assert inspector.GetOwningSourceId(id) == scene.arm
        assert inspector.GetOwningSourceName(id) == 'arm'
    assert inspector.GetOwningSourceName(WORLD) == 'SceneGraphInternal'
    assert inspector.BelongsToSource(scene.floor, scene.room)


def test_frames(scene, inspector):
    assert inspector.world_frame_id() == WORLD
    assert inspector.num_frames() == 3
    assert inspector.GetAllFrameIds() == [WORLD, scene.upper, scene.lower]
    assert inspector.GetName(scene.upper) == inspector.GetNameByFrameId(scene.upper) == 'upper'
    assert inspector.GetName(WORLD) == 'world'
    assert inspector.GetParentFrame(scene.lower) == scene.upper
    assert inspector.GetParentFrame(scene.upper) == inspector.GetParentFrame(WORLD) == WORLD
    assert inspector.GetFrameGroup(scene.upper) == 2
    assert inspector.GetFrameGroup(scene.lower) == 0
    assert inspector.GetFrameGroup(WORLD) == -1


def test_geometries(scene, inspector):
    assert inspector.num_geometries() == 5
    assert inspector.NumAnchoredGeometries() == 1
    assert inspector.NumDynamicGeometries() == 4
    assert inspector.NumGeometriesForFrame(scene.lower) == 2
    assert inspector.NumGeometriesForFrameWithRole(scene.lower, Role.kProximity) == 1
    assert inspector.GetGeometries(scene.lower) == sorted([scene.box, scene.label])
    assert inspector.GetGeometries(scene.lower, Role.kIllustration) == [scene.label]
    assert inspector.GetFrameId(scene.floor) == WORLD
    assert inspector.GetName(scene.ball) == inspector.GetNameByGeometryId(scene.ball) == 'ball'
    assert inspector.GetShape(scene.floor) == HalfSpace()
    assert inspector.GetShape(scene.label) == Box(1, 1, 0.1)
    assert inspector.GetPoseInFrame(scene.knob) == RigidTransform([0, 0, 1.5])
    assert inspector.GetPoseInParent(scene.knob) == RigidTransform([0, 0, 0.5])
    assert inspector.GetPoseInParent(scene.ball) == inspector.GetPoseInFrame(scene.ball)


def test_roles(scene, inspector):
    bare = scene.scene_graph.RegisterGeometry(
        scene.arm, scene.upper, instance('ball', proximity=False)
    )
    assert inspector.GetAllGeometryIds(Role.kUnassigned) == [bare]
    assert inspector.NumGeometriesWithRole(Role.kProximity) == 4
    assert inspector.NumGeometriesWithRole(Role.kIllustration) == 1
    assert inspector.NumGeometriesWithRole(Role.kPerception) == 0
    assert inspector.NumGeometriesWithRole(Role.kUnassigned) == 1
    assert inspector.GetProximityProperties(scene.ball) == ProximityProperties()
    assert inspector.GetProperties(scene.ball, Role.kProximity) == ProximityProperties()
    assert inspector.GetProperties(scene.ball, Role.kUnassigned) is None
    assert inspector.GetIllustrationProperties(scene.ball) is None
    assert inspector.GetIllustrationProperties(scene.label) is not None
    assert inspector.GetPerceptionProperties(scene.ball) is None


def test_ids_are_in_ascending_order_whatever_the_registration(scene, inspector):
    late, early = instance('late'), instance('early')
    first, second = GeometryFrame('first'), GeometryFrame('second')
    scene_graph = scene.scene_graph
    for frame in (second, first):
        scene_graph.RegisterFrame(scene.arm, frame)
    for geometry in (early, late):  # made, and so numbered, the other way round
        scene_graph.RegisterGeometry(scene.arm, scene.upper, geometry)
    assert inspector.GetAllFrameIds()[-2:] == [first.id(), second.id()]
    assert {first.id(), second.id()} <= inspector.FramesForSource(scene.arm)
    assert inspector.GetAllGeometryIds()[-2:] == [late.id(), early.id()]
    assert inspector.GetGeometries(scene.upper)[-2:] == [late.id(), early.id()]


def test_finding_by_name(scene, inspector):
    def find(*arguments):
        return inspector.GetGeometryIdByName(*arguments)

    scene_graph, frame_id = scene.scene_graph, scene.upper
    drawn = scene_graph.RegisterGeometry(scene.arm, scene.upper, instance('a', proximity=False))
    assert find(scene.upper, Role.kProximity, '\tball ') == scene.ball
    assert find(scene.upper, Role.kUnassigned, 'a') == drawn
    scene_graph.RegisterGeometry(scene.arm, scene.upper, instance('a', proximity=False))
    for arguments, words in (
        ((frame_id, Role.kUnassigned, 'a'), 'has 2 geometries'),
        (
            (frame_id, Role.kProximity, 'box'),
            r"'upper' .* has 0 geometries of the name 'box' and the role kProximity; "
            r"the names with this role are \['ball', 'knob'\]",
        ),
        ((frame_id, Role.kIllustration, 'ball'), r'are \[\]'),
        ((frame_id, Role.kProximity, ' '), 'empty'),
        ((frame_id, 1, 'ball'), 'role = 1 must be of type Role'),
        ((NO_FRAME, Role.kProximity, 'ball'), 'is not a frame'),
    ):
        with pytest.raises(RuntimeError, match=words):
            find(*arguments)


def test_geometry_sets_are_resolved(scene, inspector):
    both = GeometrySet([scene.floor, scene.lower])
    assert inspector.GetGeometryIds(both) == {scene.box, scene.label, scene.floor}
    assert inspector.GetGeometryIds(both, Role.kProximity) == {scene.box, scene.floor}
    assert inspector.GetGeometryIds(GeometrySet()) == set()
    for unknown in (NO_FRAME, NO_GEOMETRY):
        with pytest.raises(RuntimeError, match=r'value=10+> is no'):
            inspector.GetGeometryIds(GeometrySet([scene.ball, unknown]))


def test_sets_of_ids_are_sets(scene, inspector):
    for ids in (
        inspector.FramesForSource(scene.arm),
        inspector.GetGeometryIds(GeometrySet(scene.upper)),
        inspector.GetCollisionCandidates(),
    ):
        assert isinstance(ids, set)
        assert ids


def test_clone(scene, inspector):
    clone = inspector.CloneGeometryInstance(scene.knob)
    assert clone.id() != scene.knob
    assert (clone.name(), clone.shape()) == ('knob', inspector.GetShape(scene.knob))
    assert clone.pose() == inspector.GetPoseInFrame(scene.knob)
    clone.mutable_proximity_properties().AddProperty('g', 'n', 1)
    assert clone.illustration_properties() is None
    registered = scene.scene_graph.RegisterGeometry(scene.arm, scene.lower, clone)
    assert registered == clone.id()
    label = inspector.CloneGeometryInstance(scene.label)
    assert label.proximity_properties() is None
    assert label.illustration_properties() is not None


def test_poses_are_copies(scene, inspector):
    inspector.GetPoseInFrame(scene.ball).set_translation([9, 9, 9])
    inspector.GetPoseInParent(scene.ball).set_translation([9, 9, 9])
    assert inspector.GetPoseInFrame(scene.ball) == RigidTransform([0, 0, 1])


def test_collision_filters(scene, inspector):
    ball, knob, box, floor = scene.ball, scene.knob, scene.box, scene.floor
    assert inspector.CollisionFiltered(ball, ball)
    assert inspector.CollisionFiltered(ball, knob)  # on one frame
    assert not inspector.CollisionFiltered(box, ball)
    pairs = [
        tuple(sorted(p))
        for p in ((ball, box), (knob, box), (ball, floor), (knob, floor), (box, floor))
    ]
    assert inspector.GetCollisionCandidates() == set(pairs)
    scene.scene_graph.ExcludeCollisionsBetween(GeometrySet(box), GeometrySet(ball))
    assert inspector.CollisionFiltered(box, ball)
    assert tuple(sorted((ball, box))) not in inspector.GetCollisionCandidates()
    for pair, words in (
        ((ball, scene.label), "the geometry 'label' .* has no proximity role"),
        ((ball, NO_GEOMETRY), 'is not a geometry'),
    ):
        with pytest.raises(RuntimeError, match=words):
            inspector.CollisionFiltered(*pair)


UNKNOWN = {
    'GetName': (NO_SOURCE, NO_FRAME, NO_GEOMETRY),
    'GetSourceName': (NO_SOURCE,),
    'NumFramesForSource': (NO_SOURCE,),
    'FramesForSource': (NO_SOURCE,),
    'GetOwningSourceId': (NO_FRAME, NO_GEOMETRY),
    'GetOwningSourceName': (NO_FRAME, NO_GEOMETRY),
    'GetParentFrame': (NO_FRAME,),
    'GetFrameGroup': (NO_FRAME,),
    'GetNameByFrameId': (NO_FRAME,),
    'NumGeometriesForFrame': (NO_FRAME,),
    'GetGeometries': (NO_FRAME,),
    'GetNameByGeometryId': (NO_GEOMETRY,),
    'GetFrameId': (NO_GEOMETRY,),
    'GetShape': (NO_GEOMETRY,),
    'GetPoseInFrame': (NO_GEOMETRY,),
    'GetPoseInParent': (NO_GEOMETRY,),
    'GetProximityProperties': (NO_GEOMETRY,),
    'GetIllustrationProperties': (NO_GEOMETRY,),
    'GetPerceptionProperties': (NO_GEOMETRY,),
    'CloneGeometryInstance': (NO_GEOMETRY,),
}


@pytest.mark.parametrize('method', UNKNOWN)
def test_unknown_ids_are_named_with_what_exists(inspector, method):
    told = r'Id value=10+> is not a .*(there are|which has \d)'
    for id in UNKNOWN[method]:
        with pytest.raises(RuntimeError, match=told):
            getattr(inspector, method)(id)
        with pytest.raises(RuntimeError, match='must be of type'):
            getattr(inspector, method)('upper')


def test_unknown_ids_in_pairs(scene, inspector):
    with pytest.raises(RuntimeError, match='is not a source'):
        inspector.BelongsToSource(scene.ball, NO_SOURCE)
    with pytest.raises(RuntimeError, match='is not a geometry'):
        inspector.BelongsToSource(NO_GEOMETRY, scene.arm)
    with pytest.raises(RuntimeError, match='is not a geometry'):
        inspector.GetProperties(NO_GEOMETRY, Role.kProximity)


def test_it_is_a_view_of_the_scene_as_it_is_now(scene, inspector):
    scene.scene_graph.RemoveGeometry(scene.room, scene.floor)
    assert inspector.num_geometries() == 4


def test_the_methods_of_the_api_page_are_there():
    page = """
        CloneGeometryInstance GetAllGeometryIds GetFrameId GetGeometryIdByName
        GetIllustrationProperties GetName GetNameByFrameId GetNameByGeometryId
        GetPerceptionProperties GetPoseInFrame GetPoseInParent GetProximityProperties GetShape
        GetSourceName num_frames num_geometries num_sources NumAnchoredGeometries
        NumDynamicGeometries NumGeometriesWithRole SourceIsRegistered
    """
    ours = 'CollisionFiltered GetCollisionCandidates GetAllFrameIds FramesForSource GetGeometries'
    for name in [*page.split(), *ours.split(), 'BelongsToSource']:
        assert callable(getattr(SceneGraphInspector, name))
