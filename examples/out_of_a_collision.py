"""Move a body out of a collision by gradient descent on the depths of its contacts.

A drill, a capsule and a box on one frame, sits in a corner between a floor, a wall and a cylinder.
Each step moves it against the gradients of all its contacts at once: the spatial velocity that
solves ``J V = depth`` in the least squares, for J the derivatives of the distances, and is the
least one that does.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix

MARGIN = 1e-3  # [m] to be left when it is out
STEPS = 50
LEVERS = np.repeat([1 / 0.3, 1.0], 3)  # a turn by 1 rad counts as much as 0.3 m of the way


def build():
    """Return the scene graph, the source and the frame of the drill."""
    graph = SceneGraph()
    source = graph.RegisterSource('cell')
    drill = graph.RegisterFrame(source, GeometryFrame('drill'))

    def add(frame, shape, X_FG, name):
        instance = GeometryInstance(X_FG, shape, name)
        instance.set_proximity_properties(ProximityProperties())
        graph.RegisterGeometry(source, frame, instance)

    world = graph.world_frame_id()
    add(drill, Capsule(0.03, 0.2), RigidTransform([0, 0, 0.1]), 'bit')
    add(drill, Box(0.2, 0.08, 0.1), RigidTransform([0.04, 0, 0.25]), 'motor')
    add(world, HalfSpace(), RigidTransform(), 'floor')
    wall = RollPitchYaw(0, 0, 0.2)
    add(world, Box(0.1, 1.0, 1.0), RigidTransform(wall, [-0.12, 0, 0.4]), 'wall')
    add(world, Cylinder(0.1, 0.3), RigidTransform([0.15, 0.1, 0.15]), 'can')
    return graph, source, drill


def moved(X_WF, V_WF):
    """Return a pose after a small motion V = [w, v], angular before linear."""
    R = Rotation.from_rotvec(V_WF[:3]).as_matrix() @ X_WF.rotation().matrix()
    return RigidTransform(RotationMatrix(R), X_WF.translation() + V_WF[3:])


def main():
    """Descend until nothing overlaps, and say how."""
    graph, source, drill = build()
    context = graph.CreateDefaultContext()
    query = graph.get_query_output_port().Eval(context)
    X_WF = RigidTransform(RollPitchYaw(0.9, -0.4, 0.1), [0.02, 0.07, -0.03])
    for step in range(STEPS):
        poses = FramePoseVector({drill: X_WF})
        graph.get_source_pose_port(source).FixValue(context, poses)
        near = query.ComputeSignedDistancePairwiseClosestPoints(max_distance=MARGIN)
        deep = near.distance < MARGIN
        print(f'step {step}: {int(deep.sum())} contacts, {near.distance.min(initial=0.0):.4f} m')
        if not query.HasCollisions():
            break
        J = near.jacobian_by_frames({drill: np.eye(6)})[deep]
        short = 2 * MARGIN - near.distance[deep]
        X_WF = moved(X_WF, LEVERS * np.linalg.lstsq(J * LEVERS, short, rcond=None)[0])
    print('out of collision:', not query.HasCollisions())


if __name__ == '__main__':
    main()
