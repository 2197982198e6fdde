"""Scene files of the commands, whose warnings are printed on standard error."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from drake_geom_ros.command_line.standard_input import STANDARD_INPUT, bytes_of, name_of
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import (
    LoadedScene,
    RobotOptions,
    SceneDescription,
    SceneFileError,
    gates_left_out,
    read_scene,
    register,
    sensors_left_out,
)
from drake_geom_ros.scene_files.mesh_scenes import is_mesh_file
from drake_geom_ros.scene_files.yaml_text import text_of


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that go with a scene file to the parser of a command."""
    parser.add_argument('--srdf', default='', metavar='FILE', help='SRDF of a URDF')
    parser.add_argument(
        '--package-root',
        action='append',
        default=[],
        metavar='FOLDER',
        help='where package:// looks first: a folder of packages, or of one; may be repeated. '
        'ROS_PACKAGE_PATH and AMENT_PREFIX_PATH are looked in as well',
    )
    parser.add_argument(
        '--solid',
        action='store_true',
        help='a mesh file counts as the solid inside its surface, not as its convex hull',
    )


def check_readable(*paths: str) -> None:
    """Raise OSError unless each of the files that are named can be opened."""
    for path in paths:
        if path and path != STANDARD_INPUT:
            Path(path).open('rb').close()


def read_and_warn(
    path: str, srdf: str = '', package_roots: Sequence[str] = (), solid: bool = False
) -> SceneDescription:
    """Return the description of a scene file and print its warnings; errors of ``read_scene``.

    ``-`` is the standard input; ``solid`` is the option ``--solid``.
    """
    if solid and not is_mesh_file(path):
        raise SceneFileError(
            '--solid is for a mesh file; in a scene file a robot has the key `solid_meshes`, a '
            'geometry the property `mesh: {solid: true}`',
            path,
        )
    chosen = RobotOptions(solid_meshes=('*',) if solid else ())
    text = path
    if path == STANDARD_INPUT:
        text = text_of(bytes_of(path), name_of(path)) + '\n'  # a line break: no path
    description = read_scene(
        text,
        srdf=srdf,
        package_roots=package_roots,
        options=chosen,
        text_name=name_of(STANDARD_INPUT),
    )
    sensors = sensors_left_out(description.obstacle_sources)
    gates = gates_left_out(description.gates)
    for warning in filter(None, (*description.warnings, sensors, gates)):
        print(f'warning: {warning}', file=sys.stderr)
    return description


def load_and_warn(
    path: str,
    scene_graph: SceneGraph,
    srdf: str = '',
    package_roots: Sequence[str] = (),
    solid: bool = False,
) -> LoadedScene:
    """Register a scene file, print its warnings, and return the ids; errors of ``load_scene``."""
    return register(scene_graph, read_and_warn(path, srdf, package_roots, solid))


def load_chosen(options: argparse.Namespace, scene_graph: SceneGraph) -> LoadedScene:
    """Register the scene that a command's options name; as ``load_and_warn``."""
    return load_and_warn(
        options.scene, scene_graph, options.srdf, options.package_root, options.solid
    )
