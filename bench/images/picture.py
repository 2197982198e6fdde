"""Draws docs/images.png: the demo's arms from a tripod, and what the gripper's camera sees.

./run exec python -m bench.images.picture docs/images.png
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from drake_geom_ros.command_line.render import looking
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import (
    CameraDescription,
    add_renderers,
    camera_of,
    read_scene,
    register,
)
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.trajectories.motion_file import load_motion
from drake_geom_ros.viewing.label_names import draw_labels
from drake_geom_ros.viewing.timeline import Timeline

ROOT = Path(__file__).resolve().parents[2]
SCENE, MOTION = ROOT / 'scenes/two_pandas.yaml', ROOT / 'scenes/two_pandas_motion.yaml'
TIME = 10.2  # [s] of the motion: both arms are before the camera in the left gripper
FROM, AT = [2.1, -1.9, 1.7], [0.0, 0.0, 0.65]
SIZE = 640, 480


def draw(target: Path) -> None:
    """Draw the four pictures, two beside two."""
    description = read_scene(SCENE)
    scene = SceneGraph()
    loaded = register(scene, description)
    add_renderers(scene)
    context = scene.CreateSharedContext(partial=True)
    motion = Timeline.of_motion(load_motion(MOTION, description), loaded.frames)
    context.UpdateFramePoses(motion.poses(TIME))
    query = scene.get_query_output_port().Eval(context)
    frame, hand = loaded.cameras[0]
    X_WC = looking(FROM, AT)
    tripod = CameraDescription(
        'tripod', '', 'world', X_WC, CameraInfo(*SIZE, 0.62), shows=hand.shows
    )
    far = query.render_images(camera_of(tripod), scene.world_frame_id(), X_WC, 'color').color
    near = query.render_images(camera_of(hand), frame, hand.X_FC)
    figure = Figure(figsize=(9.6, 7.4), layout='constrained')
    (tripod_axes, color), (depth, label) = figure.subplots(2, 2)
    for axes, title in (
        *((tripod_axes, 'from a tripod'), (color, 'the camera in the gripper: colour')),
        *((depth, 'depth [m]'), (label, 'labels')),
    ):
        axes.set_axis_off()
        axes.set_title(title, fontsize=12)
    tripod_axes.imshow(far.data)
    color.imshow(near.color.data)
    depths = near.depth.data[..., 0]
    told = np.ma.masked_array(depths, ~(np.isfinite(depths) & (depths > 0.0)))
    shown = depth.imshow(told, cmap='viridis_r', norm=LogNorm())
    ticks = (0.1, 0.15, 0.2, 0.3, 0.5, 1.0)
    bar = figure.colorbar(shown, ax=depth, fraction=0.04, ticks=ticks, format='%g')
    bar.minorticks_off()
    legend = query.render_legend(camera_of(hand).core().renderer_name())
    draw_labels(label, near.label.data[..., 0], legend, scene.model_inspector())
    figure.savefig(target, dpi=110)


if __name__ == '__main__':
    draw(Path(sys.argv[1]))
