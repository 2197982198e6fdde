"""Scenes of texts, as a page shows them."""

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import read_scene, register
from drake_geom_ros.viewing.local_scene import LocalScene


def registered(text):
    """Return the scene graph of a text or a file."""
    scene_graph = SceneGraph()
    register(scene_graph, read_scene(text))
    return scene_graph


def local_scene(text):
    """Return the shown scene of a text or a file."""
    scene_graph = registered(text)
    return LocalScene(scene_graph, scene_graph.CreateSharedContext(partial=True))
