"""Calls that a script brings along from pydrake: keywords of each kind of id, clones, boxes."""

import numpy as np
import pytest
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    AddContactMaterial,
    Box,
    CalcObb,
    HalfSpace,
    Obb,
    ProximityProperties,
    Rgba,
    Sphere,
)


@pytest.fixture
def scene():
    shapes = Sphere(0.5), Box(1, 2, 3), HalfSpace()
    return ShapeScene(*shapes).posed([0, 0, 0], [5, 0, 0], [0, 0, -9])


def test_an_id_has_a_keyword_for_its_kind(scene):
    inspector = scene.query.inspector()
    geometry = inspector.GetAllGeometryIds()[0]
    frame = inspector.GetFrameId(geometry_id=geometry)
    source = inspector.GetOwningSourceId(frame_id=frame)
    for kind, id in {'geometry_id': geometry, 'frame_id': frame}.items():
        named = {kind: id}
        assert inspector.GetName(**named) == inspector.GetName(id=id) == inspector.GetName(id)
        assert inspector.BelongsToSource(**named, source_id=source)
        assert inspector.BelongsToSource(id, source)
        assert inspector.GetOwningSourceName(**named) == inspector.GetName(source_id=source)
        assert scene.query.GetPoseInWorld(**named) == scene.query.GetPoseInWorld(id)
    assert inspector.SourceIsRegistered(id=source)
    assert inspector.GetSourceName(id=source) == inspector.GetSourceName(source)
    assert inspector.all_frame_ids() == inspector.GetAllFrameIds()
    for call in (
        inspector.GetName,
        lambda: inspector.GetName(frame, geometry_id=geometry),
        lambda: inspector.BelongsToSource(frame),
    ):
        with pytest.raises(RuntimeError, match='give one id'):
            call()


def test_the_pair_by_its_older_keywords(scene):
    a, b = scene.query.inspector().GetAllGeometryIds()[:2]
    ask = scene.query.ComputeSignedDistancePairClosestPoints
    assert ask(id_A=a, id_B=b) == ask(geometry_id_A=a, geometry_id_B=b) == ask(a, b)


def test_a_point_may_be_a_column(scene):
    ask = scene.query.ComputeSignedDistanceToPoint
    assert ask(p_WQ=np.array([[1.0], [2.0], [3.0]])) == ask([1, 2, 3])


def test_candidates_take_an_accuracy(scene):
    ask = scene.query.FindCollisionCandidates
    assert ask(accuracy='bound') == ask()
    with pytest.raises(RuntimeError, match="accuracy='best'"):
        ask(accuracy='best')


def test_oriented_boxes(scene):
    inspector = scene.query.inspector()
    ball, box, floor = inspector.GetAllGeometryIds()
    assert inspector.GetObbInGeometryFrame(geometry_id=box).Equal(CalcObb(Box(1, 2, 3)))
    there = scene.query.ComputeObbInWorld(geometry_id=box)
    assert there.Equal(Obb(scene.query.GetPoseInWorld(box), [0.5, 1, 1.5]))
    assert inspector.GetObbInGeometryFrame(floor) is None
    assert scene.query.ComputeObbInWorld(floor) is None
    assert inspector.GetConvexHull(geometry_id=ball) is None
    with pytest.raises(RuntimeError, match='is not a geometry of this scene'):
        scene.query.ComputeObbInWorld(type(ball)(10**6))


def test_a_clone_of_a_context_stays_where_it_is(scene):
    ball = scene.query.inspector().GetAllGeometryIds()[0]
    clone = scene.context.Clone()
    scene.posed([1, 1, 1], [5, 0, 0], [0, 0, -9])
    query = type(scene.query)(clone)
    assert query.GetPoseInWorld(ball).translation().tolist() == [0, 0, 0]
    assert scene.query.GetPoseInWorld(ball).translation().tolist() == [1, 1, 1]


def test_colours():
    colour = Rgba(0.5, 0.5, 0.25, 0.5)
    colour.set(rgba=[0.1, 0.2, 0.3])
    assert colour == Rgba(0.1, 0.2, 0.3, 1.0)
    colour.rgba = [0.1, 0.2, 0.4, 0.5]
    assert colour.scale_rgb(2) == Rgba(0.2, 0.4, 0.8, 0.5)
    assert colour.scale_rgb(scale=5).b() == 1
    assert colour * Rgba(1, 0.5, 0, 0.5) == Rgba(0.1, 0.1, 0, 0.25)
    with pytest.raises(RuntimeError, match='scale = -1 must be >= 0'):
        colour.scale_rgb(-1)
    for bad, words in (([-1.0] * 4, 'range'), ([1.0] * 2, '3 or 4'), (None, '3 or 4')):
        with pytest.raises(RuntimeError, match=words):
            colour.set(rgba=bad)
    with pytest.raises(TypeError):
        colour * 2
    assert colour == Rgba(0.1, 0.2, 0.4, 0.5)


class Friction:
    """As pydrake's CoulombFriction."""

    def static_friction(self):
        return 0.25

    def dynamic_friction(self):
        return 0.125


def test_the_material_of_a_contact():
    properties = ProximityProperties()
    AddContactMaterial(properties=properties)
    assert properties == ProximityProperties()
    AddContactMaterial(
        dissipation=2.7, point_stiffness=3.9, friction=Friction(), properties=properties
    )
    assert properties.GetProperty('material', 'hunt_crossley_dissipation') == 2.7
    assert properties.GetProperty('material', 'point_contact_stiffness') == 3.9
    assert properties.GetProperty('material', 'coulomb_friction').dynamic_friction() == 0.125
    for given, words in (
        ({'dissipation': -1}, 'must be >= 0'),
        ({'point_stiffness': 0}, 'must be > 0'),
        ({'friction': 0.5}, 'has no coefficients'),
    ):
        with pytest.raises(RuntimeError, match=words):
            AddContactMaterial(ProximityProperties(), **given)
    kept = ProximityProperties(properties)
    with pytest.raises(RuntimeError, match='hunt_crossley_dissipation already'):
        AddContactMaterial(properties, dissipation=1)
    assert properties.GetPropertiesInGroup('material').keys() == (
        kept.GetPropertiesInGroup('material').keys()
    )
