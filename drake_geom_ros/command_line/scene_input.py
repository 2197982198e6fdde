"""Scene files of the commands: what is not understood in one is told on standard error."""

import argparse
import sys
from collections.abc import Sequence

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import LoadedScene, SceneDescription, read_scene, register


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Add what goes with a scene file to the parser of a command."""
    parser.add_argument('--srdf', default='', metavar='FILE', help='SRDF of a URDF')
    parser.add_argument(
        '--package-root',
        action='append',
        default=[],
        metavar='FOLDER',
        help='where package:// looks first: a folder of packages, or of one; may be repeated. '
        'ROS_PACKAGE_PATH and AMENT_PREFIX_PATH are looked in as well',
    )


def read_and_tell(
    path: str, srdf: str = '', package_roots: Sequence[str] = ()
) -> SceneDescription:
    """Return what a scene file describes; raises SceneFileError for one that cannot be read."""
    description = read_scene(path, srdf=srdf, package_roots=package_roots)
    for told in description.warnings:
        print(f'warning: {told}', file=sys.stderr)
    return description


def load_and_tell(
    path: str, scene_graph: SceneGraph, srdf: str = '', package_roots: Sequence[str] = ()
) -> LoadedScene:
    """Register what a scene file describes, and return the ids; errors are those of reading."""
    return register(scene_graph, read_and_tell(path, srdf, package_roots))
