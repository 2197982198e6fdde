"""camera.png: what the scene's first camera sees at the closest moment."""

from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from drake_geom_ros.ros.demo.moment_scene import scene_at
from drake_geom_ros.ros.demo.recording import Approach
from drake_geom_ros.scene_files import SceneDescription, camera_of
from drake_geom_ros.viewing.label_names import draw_labels


def draw_camera(description: SceneDescription, moment: Approach, path: Path) -> str:
    """Draw colour, depth and labels side by side; return whose they are, '' without a camera."""
    if not description.cameras:
        return ''
    query, loaded = scene_at(description, moment)
    on, camera = loaded.cameras[0]
    core = camera_of(camera)
    images = query.render_images(core, on, camera.X_FC)
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
    legend = query.render_legend(core.core().renderer_name())
    draw_labels(label, images.label.data[..., 0], legend, query.inspector())
    figure.savefig(path, dpi=100)
    return camera.name
