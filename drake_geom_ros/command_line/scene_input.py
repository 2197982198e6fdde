"""Scene files of the commands: what is not understood in one is told on standard error."""

import sys

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import LoadedScene, SceneDescription, read_scene, register


def read_and_tell(path: str, srdf: str = '') -> SceneDescription:
    """Return what a scene file describes; raises SceneFileError for one that cannot be read."""
    description = read_scene(path, srdf=srdf)
    for told in description.warnings:
        print(f'warning: {told}', file=sys.stderr)
    return description


def load_and_tell(path: str, scene_graph: SceneGraph, srdf: str = '') -> LoadedScene:
    """Register what a scene file describes, and return the ids; errors are those of reading."""
    return register(scene_graph, read_and_tell(path, srdf))
