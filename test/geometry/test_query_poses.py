"""Poses of many geometries at once, against those of one."""

import numpy as np
import pytest

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import RoleError
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.judging.asking import BodyScene


def test_they_are_those_of_each_by_itself():
    turned = RotationMatrix.MakeXRotation(0.3).matrix()
    bodies = [Body('Sphere', [0.1], p=np.array([k, 0.0, 0.0]), R=turned) for k in (1.0, 2.0)]
    anchored = [Body('Box', [1.0, 1.0, 1.0], p=np.array([0.0, 3.0, 0.0]), R=turned)]
    scene = BodyScene(bodies, anchored)
    context = scene.new_context()
    query = scene.asked(context)
    for moved in (0.0, 1.0):
        scene.pose(context, [RigidTransform([moved, k, 0.0]) for k in (4.0, 5.0)])
        asked = [scene.ids[k] for k in (2, 0, 1, 0)]
        rotations, positions = query.X_WGs([id.get_value() for id in asked])
        for id, R, p in zip(asked, rotations, positions, strict=True):
            np.testing.assert_allclose(R, query.X_WG(id).rotation().matrix(), rtol=0, atol=1e-15)
            np.testing.assert_allclose(p, query.X_WG(id).translation(), rtol=0, atol=1e-15)
    assert rotations.shape == (4, 3, 3)


def test_what_takes_part_in_no_query_has_none():
    scene = BodyScene([Body('Sphere', [0.1])])
    other = max(id.get_value() for id in scene.ids) + 1
    with pytest.raises(RoleError, match=f'no geometry with the proximity role: .{other}'):
        scene.asked().X_WGs([other])
