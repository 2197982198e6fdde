"""camera.png: what the scene's first camera sees at the closest moment."""

from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from drake_geom_ros.geometry import FramePoseVector, RenderedImages, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.demo.recording import Approach
from drake_geom_ros.scene_files import (
    WORLD,
    SceneDescription,
    add_renderers,
    camera_of,
    register,
)


def draw_camera(description: SceneDescription, moment: Approach, path: Path) -> str:
    """Draw colour, depth and labels side by side; return whose they are, '' without a camera."""
    if not description.cameras:
        return ''
    camera = description.cameras[0]
    images = _images(description, moment)
    assert images.color is not None
    assert images.depth is not None
    assert images.label is not None
    figure = Figure(figsize=(15.0, 4.2), layout='constrained')
    colour, depth, label = figure.subplots(1, 3)
    for axes, title in ((colour, 'colour'), (depth, 'depth'), (label, 'labels')):
        axes.set_axis_off()
        axes.set_title(f'{camera.name}: {title}')
    colour.imshow(images.color.data)
    depths = images.depth.data[..., 0]
    measured = np.ma.masked_array(depths, ~(np.isfinite(depths) & (depths > 0.0)))
    shown = depth.imshow(measured, cmap='viridis_r', norm=LogNorm() if measured.count() else None)
    figure.colorbar(shown, ax=depth, label='[m]', fraction=0.035)
    # Places instead of labels: neighbours get colours that differ.
    _, places = np.unique(images.label.data[..., 0], return_inverse=True)
    label.imshow(places.reshape(depths.shape) % 20, cmap='tab20', interpolation='nearest')
    figure.savefig(path, dpi=100)
    return camera.name


def _images(description: SceneDescription, moment: Approach) -> RenderedImages:
    """Return all images of the first camera, every frame where it was at the moment."""
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
            pose = RigidTransform(X_PF)
            poses.set_value(loaded.frames[named], pose)
    context.UpdateFramePoses(poses)
    query = scene.get_query_output_port().Eval(context)
    on, camera = loaded.cameras[0]
    return query.render_images(camera_of(camera), on, camera.X_FC)
