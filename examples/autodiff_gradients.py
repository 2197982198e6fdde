"""Derivatives of distances by a joint's angle and a slide, with AutoDiffXd as in pydrake.

Replace ``drake_geom_ros`` by ``pydrake`` in the imports below, and it runs under pydrake and
prints the same. A ball on a turning arm comes near a box; the derivative of its distance, of a
point's distance from the box, and of a pose are printed.
"""

import numpy as np

from drake_geom_ros.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)
from drake_geom_ros.geometry import (
    Box,
    FramePoseVector_,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    SceneGraph_,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RigidTransform_, RotationMatrix_


def main():
    """Print distances and their derivatives by the angle [rad] and the slide [m]."""
    scene_graph = SceneGraph_[AutoDiffXd]()
    source_id = scene_graph.RegisterSource('arm')
    frames = {}
    for name, shape in (('ball', Sphere(0.1)), ('box', Box(0.2, 0.3, 0.4))):
        frames[name] = scene_graph.RegisterFrame(source_id, GeometryFrame(name))
        instance = GeometryInstance(RigidTransform(), shape, name)
        instance.set_proximity_properties(ProximityProperties())
        scene_graph.RegisterGeometry(source_id, frames[name], instance)
    context = scene_graph.CreateDefaultContext()

    angle, slide = InitializeAutoDiff([0.5, 0.3])[:, 0]
    R_WA = RotationMatrix_[AutoDiffXd].MakeZRotation(angle)
    p_WBall = R_WA.multiply(np.array([AutoDiffXd(0.6), AutoDiffXd(0.0), AutoDiffXd(0.05)]))
    poses = FramePoseVector_[AutoDiffXd]()
    poses.set_value(frames['ball'], RigidTransform_[AutoDiffXd](R_WA, p_WBall))
    p_WBox = np.array([0.5 + slide, AutoDiffXd(0.8), AutoDiffXd(0.0)])
    poses.set_value(frames['box'], RigidTransform_[AutoDiffXd](p_WBox))
    scene_graph.get_source_pose_port(source_id).FixValue(context, poses)

    query_object = scene_graph.get_query_output_port().Eval(context)
    (pair,) = query_object.ComputeSignedDistancePairwiseClosestPoints()
    points = query_object.ComputeSignedDistanceToPoint(p_WQ=p_WBall, threshold=1.0)
    of_box = max(points, key=lambda point: point.distance.value())
    X_WBall = query_object.GetPoseInWorld(frames['ball'])
    for name, numbers in (
        ('distance', np.array([pair.distance])),
        ('normal', pair.nhat_BA_W),
        ('point to box', np.array([of_box.distance])),
        ('position', X_WBall.translation()),
    ):
        value, gradient = ExtractValue(numbers), ExtractGradient(numbers)
        print(f'{name:12} {value.ravel().round(6) + 0.0} {gradient.round(6).tolist()}')


if __name__ == '__main__':
    main()
