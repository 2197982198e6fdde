"""A scene that messages name things of."""

import pytest

from drake_geom_ros.geometry import (
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.live.conversions.names import NameTable
from drake_geom_ros.math import RigidTransform


@pytest.fixture
def scene():
    """Return a scene of two sources with a frame `arm` each, and a ball on each frame."""
    scene_graph = SceneGraph()
    for source_name in ('left', 'right'):
        source = scene_graph.RegisterSource(source_name)
        frame = scene_graph.RegisterFrame(source, GeometryFrame('arm'))
        ball = GeometryInstance(RigidTransform(), Sphere(0.1), 'ball')
        ball = scene_graph.RegisterGeometry(source, frame, ball)
        scene_graph.AssignRole(source, ball, ProximityProperties())
    scene_graph.RegisterFrame(source, GeometryFrame('hand'))
    return scene_graph


@pytest.fixture
def names(scene):
    return NameTable(scene.model_inspector())
