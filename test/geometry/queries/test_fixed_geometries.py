"""Geometries of any role where they are, without those that have no place."""

import numpy as np

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    QueryObject,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.queries.fixed_geometries import FixedGeometries
from drake_geom_ros.math import RigidTransform, RotationMatrix


def test_they_are_where_the_query_says_and_only_those_that_are_anywhere():
    scene = SceneGraph()
    source = scene.RegisterSource('s')
    hand, lost = (scene.RegisterFrame(source, GeometryFrame(name)) for name in ('hand', 'lost'))
    X_FG = RigidTransform(RotationMatrix.MakeXRotation(0.3), [0.1, 0.2, 0.3])
    balls = [GeometryInstance(X_FG, Sphere(1.0), 'ball') for _ in range(3)]
    ids = [scene.RegisterGeometry(source, f, g) for f, g in zip((lost, hand), balls, strict=False)]
    ids.append(scene.RegisterAnchoredGeometry(source, balls[2]))
    context = scene.CreateSharedContext(partial=True)
    X_WF = RigidTransform(RotationMatrix.MakeZRotation(1.0), [1.0, 2.0, 3.0])
    context.UpdateFramePoses(FramePoseVector({hand: X_WF}))
    fixed = FixedGeometries(scene.model_inspector())
    R_WGs, p_WGs, placed = fixed.X_WGs(context)
    assert fixed.ids.tolist() == [id.get_value() for id in ids]
    assert placed.tolist() == [False, True, True]
    query = QueryObject(context)
    for R_WG, p_WG, id in zip(R_WGs, p_WGs, ids[1:], strict=True):
        X_WG = query.X_WG(id)
        np.testing.assert_allclose(R_WG, X_WG.rotation().matrix(), rtol=0, atol=1e-15)
        np.testing.assert_allclose(p_WG, X_WG.translation(), rtol=0, atol=1e-15)
