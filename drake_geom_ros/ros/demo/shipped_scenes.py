"""The scene files of the demo: those of the source tree, or those that are installed."""

from pathlib import Path

from drake_geom_ros.scene_files import ResourceResolver


def shipped_scene(name: str) -> Path:
    """Return the path of a scene file of this package; raises ValueError where there is none."""
    in_tree = Path(__file__).parents[3] / 'scenes' / name
    if in_tree.is_file():
        return in_tree
    return ResourceResolver().resolve(f'package://drake_geom_ros/scenes/{name}', Path.cwd())
