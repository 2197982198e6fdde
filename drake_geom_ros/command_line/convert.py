"""``convert``: a URDF to a scene file, a pose file to the other format."""

import argparse
from pathlib import Path
from typing import Any

from drake_geom_ros.command_line.inputs import files_of
from drake_geom_ros.command_line.pose_file import SUFFIXES as POSE_SUFFIXES
from drake_geom_ros.command_line.pose_file import read_poses, write_poses
from drake_geom_ros.command_line.scene_input import add_scene_options, load_and_tell
from drake_geom_ros.common.whole_files import check_outputs, whole_file
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import SceneFileError, save_scene

_SCENE_SUFFIXES = ('.yaml', '.yml')


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'convert',
        help='convert a URDF to a scene file, or a pose file to the other format',
        description='A URDF, whatever it is called, or .yaml to .yaml; .csv to .json and back.',
    )
    parser.add_argument('input', metavar='IN')
    parser.add_argument('output', metavar='OUT')
    add_scene_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Convert and return the exit code; raises SceneFileError or OSError for bad input."""
    source, target = Path(options.input), Path(options.output)
    check_outputs({'OUT': target}, [source, options.srdf])
    if source.suffix not in POSE_SUFFIXES and target.suffix in _SCENE_SUFFIXES:
        scene_graph = SceneGraph()
        loaded = load_and_tell(str(source), scene_graph, options.srdf, options.package_root)
        check_outputs({'OUT': target}, files_of(scene_graph, loaded.robots.values()))
        text = save_scene(scene_graph, loaded.X_PFs, loaded.robots.values())
        with whole_file(target) as file:
            file.write(text)
    elif source.suffix in POSE_SUFFIXES and target.suffix in POSE_SUFFIXES:
        sets = read_poses(source)
        with whole_file(target) as file:
            write_poses(sets, file, target.suffix)
    else:
        raise SceneFileError(
            f'cannot be converted to {str(target)!r}: a URDF and .yaml become .yaml, '
            '.csv and .json become each other',
            str(source),
        )
    return 0
