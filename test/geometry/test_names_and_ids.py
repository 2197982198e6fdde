"""Look-ups by ids and by their values, names of results, and what is said of what is not here."""

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    ArgumentTypeError,
    CollisionFilterDeclaration,
    FilterError,
    FrameId,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    QueryObject,
    SceneGraph,
    Sphere,
    UnknownIdError,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene

SCENE = """
sources: [things]
frames: [{name: tray, source: things, pose: {position: [0, 0, 1]}}]
geometries:
- {name: floor, source: things, shape: {type: half_space}}
- {name: post, source: things, shape: {type: box, size: [0.1, 0.1, 1]}}
- {name: cup, source: things, frame: tray, shape: {type: sphere, radius: 0.1}}
- {name: lid, source: things, frame: tray, shape: {type: sphere, radius: 0.1}}
"""


@pytest.fixture
def scene():
    scene_graph = SceneGraph()
    loaded = load_scene(SCENE, scene_graph)
    query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
    return scene_graph, loaded, query


def test_results_are_named_by_the_values_in_their_arrays(scene):
    _, loaded, query = scene
    found = query.ComputeSignedDistancePairwiseClosestPoints()
    names = query.inspector().full_names(found.id_A)
    assert loaded.names_of(found.id_A) == names
    assert loaded.names_of([pair.id_A for pair in found]) == names
    assert set(names) == {'things::world/floor', 'things::world/post'}
    assert query.inspector().full_names([0]) == [''] == [loaded.name_of(0)]
    tray = loaded.frames['things', 'tray']
    assert query.inspector().full_name(tray) == 'things::tray' == loaded.name_of(tray)
    assert query.inspector().full_name(loaded.sources['things']) == 'things'
    assert query.inspector().full_name(query.inspector().world_frame_id()) == 'world'


def test_what_takes_a_geometry_takes_its_value_too(scene):
    _, loaded, query = scene
    inspector, found = query.inspector(), query.ComputeSignedDistancePairwiseClosestPoints()
    id = loaded.geometries['things', 'tray', 'cup']
    for number in (np.int64(id.get_value()), id.get_value()):
        assert inspector.GetShape(number) == inspector.GetShape(id)
        assert inspector.GetFrameId(number) == loaded.frames['things', 'tray']
    a, b = found.id_A[0], found.id_B[0]
    pair = query.ComputeSignedDistancePairClosestPoints(a, b)
    assert pair.distance == found.distance[0]
    assert pair.id_A.get_value() == a


@pytest.mark.parametrize('bad', ['cup', True, 1.0, None, FrameId(1)])
def test_what_is_no_id_is_none(scene, bad):
    _, _, query = scene
    with pytest.raises(ArgumentTypeError, match='GeometryId'):
        query.inspector().GetShape(bad)


def test_a_number_that_may_be_of_a_frame_is_refused(scene):
    with pytest.raises(ArgumentTypeError, match='GeometryId'):
        scene[2].inspector().GetName(1)


def test_a_geometry_that_was_removed_is_told_from_one_that_never_was(scene):
    scene_graph, loaded, _ = scene
    id = loaded.geometries['things', 'tray', 'cup']
    scene_graph.RemoveGeometry(loaded.sources['things'], id)
    inspector = scene_graph.model_inspector()
    with pytest.raises(UnknownIdError, match="called 'cup', and has been removed") as told:
        inspector.GetShape(id)
    assert 'has not been registered' not in str(told.value)
    query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
    with pytest.raises(UnknownIdError, match='has been removed'):
        query.X_WG(id)
    with pytest.raises(UnknownIdError, match='has not been registered'):
        inspector.GetShape(999_999)


def test_many_removals_are_not_all_kept():
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    frame = scene_graph.RegisterFrame(source, GeometryFrame('f'))
    ids = []
    for k in range(1100):
        ball = GeometryInstance(RigidTransform(), Sphere(0.1), f'ball {k}')
        ball.set_proximity_properties(ProximityProperties())
        ids.append(scene_graph.RegisterGeometry(source, frame, ball))
        scene_graph.RemoveGeometry(source, ids[-1])
    with pytest.raises(UnknownIdError, match="called 'ball 1099'"):
        scene_graph.model_inspector().GetShape(ids[-1])
    with pytest.raises(UnknownIdError, match='has not been registered'):
        scene_graph.model_inspector().GetShape(ids[0])


@pytest.mark.parametrize(
    ('a', 'b', 'words'),
    [
        (('world', 'floor'), ('world', 'post'), 'No filter can allow it: both stand on the world'),
        (('tray', 'cup'), ('tray', 'lid'), 'No filter can allow it: both are on one frame'),
        (('tray', 'cup'), ('tray', 'cup'), 'No filter can allow it: a geometry has no distance'),
    ],
)
def test_of_a_pair_that_never_counts_nobody_is_told_how_to_allow_it(scene, a, b, words):
    _, loaded, query = scene
    ids = [loaded.geometries[('things', *name)] for name in (a, b)]
    with pytest.raises(FilterError, match=words) as told:
        query.ComputeSignedDistancePairClosestPoints(*ids)
    assert 'how to allow' not in str(told.value)


def test_a_pair_that_a_filter_leaves_out_may_be_allowed(scene):
    scene_graph, loaded, _ = scene
    ids = [
        loaded.geometries['things', 'tray', 'cup'],
        loaded.geometries['things', 'world', 'post'],
    ]
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeWithin(GeometrySet(ids))
    )
    query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
    with pytest.raises(FilterError, match='See CollisionFilterManager for how to allow it'):
        query.ComputeSignedDistancePairClosestPoints(*ids)


@pytest.mark.parametrize('name', ['ComputeNothingAtAll', 'AddThing'])
def test_a_method_that_is_missing_points_to_the_page(scene, name):
    scene_graph, _, query = scene
    for thing in (query, scene_graph, query.inspector(), QueryObject()):
        with pytest.raises(AttributeError, match=f'{name}.*docs/differences_from_pydrake.md'):
            getattr(thing, name)
        assert not hasattr(thing, name)
        with pytest.raises(AttributeError) as told:
            _ = thing.some_attribute
        assert 'differences_from_pydrake' not in str(told.value)
