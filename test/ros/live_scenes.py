"""Live scenes for tests without ROS."""

import time

from drake_geom_ros.ros.scene.live_scene import LiveScene
from drake_geom_ros.scene_files import read_scene


def live_scene(text, now=time.monotonic, world_frame='world'):
    """Return a live scene of a file or a text."""
    live = LiveScene('exact', now, world_frame)
    with live.editing() as scene:
        scene.add(read_scene(text))
    return live
