"""The scene of the demo at a moment that was recorded."""

import numpy as np

from drake_geom_ros.geometry import FramePoseVector, QueryObject, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.demo.recording import Approach
from drake_geom_ros.scene_files import (
    WORLD,
    LoadedScene,
    SceneDescription,
    add_renderers,
    register,
)


def scene_at(description: SceneDescription, moment: Approach) -> tuple[QueryObject, LoadedScene]:
    """Return the scene with every frame where it was at the moment, and its ids by names."""
    scene = SceneGraph()
    loaded = register(scene, description)
    add_renderers(scene)
    context = scene.CreateSharedContext(partial=True)
    poses = FramePoseVector()
    for frame in description.frames:
        named = frame.source, frame.name
        parent = np.eye(4)
        if frame.parent != WORLD:
            parent = moment.X_WFs.get((frame.source, frame.parent), parent)
        if named in moment.X_WFs:
            X_PF = np.linalg.solve(parent, moment.X_WFs[named])
            poses.set_value(loaded.frames[named], RigidTransform(X_PF))
    context.UpdateFramePoses(poses)
    return scene.get_query_output_port().Eval(context), loaded
