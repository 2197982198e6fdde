"""Command ``convert``: convert models to scene files, and pose files and maps between formats."""

import argparse
from pathlib import Path
from typing import Any

from drake_geom_ros.command_line.built_scene import build_call, load_built
from drake_geom_ros.command_line.option_values import finite
from drake_geom_ros.command_line.pose_file import SUFFIXES as POSE_SUFFIXES
from drake_geom_ros.command_line.pose_file import read_poses, write_poses
from drake_geom_ros.command_line.scene_input import add_scene_options, load_and_warn, read_and_warn
from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.common.whole_files import check_outputs, whole_file
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import LoadedScene, SceneFileError, files_of, save_scene
from drake_geom_ros.scene_files.mesh_scenes import is_mesh_file
from drake_geom_ros.scene_files.moveit_scene import SUFFIX as MOVEIT_SUFFIX
from drake_geom_ros.scene_files.moveit_scene_writer import to_moveit_scene
from drake_geom_ros.scene_files.urdf_writer import to_urdf
from drake_geom_ros.sensed_maps import MAP_SUFFIXES, map_bytes, read_map

_SCENE_SUFFIXES = ('.yaml', '.yml')


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'convert',
        description=(
            'A model (URDF, SDF, MJCF, directives, a mesh), .yaml or .scene of MoveIt to .yaml, '
            'to .scene, or, of one robot, to .urdf; FILE.py:FUNCTION, which returns a Diagram or '
            'a SceneGraph of pydrake or an mujoco.MjModel, to .yaml; .csv to .json and back; '
            'cells (.bt, .ot) and points (.pcd, .ply, .xyz, .npy) to each other.'
        ),
    )
    parser.add_argument('input', metavar='IN')
    parser.add_argument('output', metavar='OUT', nargs='?')
    parser.add_argument('--to', metavar='OUT', help='the same as the second argument')
    parser.add_argument(
        '--resolution',
        type=finite,
        metavar='R',
        help='edge length [m] of the cells that a map becomes; of points, they are thinned by it',
    )
    add_scene_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Convert and return the exit code; raises SceneFileError or OSError for bad input."""
    outputs = [each for each in (options.output, options.to) if each is not None]
    if len(outputs) != 1:
        raise SceneFileError('give one file to be written, OUT or --to OUT', options.input)
    source, target = Path(options.input), Path(outputs[0])
    call = build_call(options.input)
    check_outputs({'OUT': target}, [call.file if call else source, options.srdf])
    becomes_scene = target.suffix in _SCENE_SUFFIXES
    kind = source.suffix.lower()
    if call is not None and becomes_scene:
        scene_graph = SceneGraph()
        _save(scene_graph, load_built(call, scene_graph), target)
    elif kind in MAP_SUFFIXES and not (becomes_scene and is_mesh_file(source)):
        _convert_map(source, target, options.resolution)
    elif options.resolution is not None:
        raise SceneFileError('is no map, and --resolution is for these alone', str(source))
    elif source.suffix not in POSE_SUFFIXES and becomes_scene:
        scene_graph = SceneGraph()
        loaded = load_and_warn(
            str(source), scene_graph, options.srdf, options.package_root, options.solid
        )
        _save(scene_graph, loaded, target)
    elif source.suffix not in POSE_SUFFIXES and target.suffix == MOVEIT_SUFFIX:
        _convert_to_moveit(source, target, options)
    elif source.suffix not in POSE_SUFFIXES and target.suffix == '.urdf':
        scene = read_and_warn(str(source), options.srdf, options.package_root, options.solid)
        text = to_urdf(scene)
        with whole_file(target) as file:
            file.write(text)
    elif source.suffix in POSE_SUFFIXES and target.suffix in POSE_SUFFIXES:
        sets = read_poses(source)
        with whole_file(target) as file:
            write_poses(sets, file, target.suffix)
    else:
        raise SceneFileError(
            f'cannot be converted to {str(target)!r}: models, .yaml and .scene become .yaml, '
            '.scene or .urdf, FILE.py:FUNCTION becomes .yaml, '
            f'.csv and .json become each other, and so do maps ({", ".join(MAP_SUFFIXES)})',
            str(source),
        )
    return 0


def _save(scene_graph: SceneGraph, loaded: LoadedScene, target: Path) -> None:
    check_outputs({'OUT': target}, files_of(scene_graph, loaded.robots.values()))
    text = save_scene(scene_graph, loaded.X_PFs, loaded.robots.values())
    with whole_file(target) as file:
        file.write(text)


def _convert_to_moveit(source: Path, target: Path, options: argparse.Namespace) -> None:
    scene_graph = SceneGraph()
    loaded = load_and_warn(
        str(source), scene_graph, options.srdf, options.package_root, options.solid
    )
    check_outputs({'OUT': target}, files_of(scene_graph, loaded.robots.values()))
    written = to_moveit_scene(scene_graph, loaded, source.stem)
    with whole_file(target) as file:
        file.write(written.text)
    for each in written.left_out:
        print(f'left out {each}')


def _convert_map(source: Path, target: Path, resolution: float | None) -> None:
    read = read_map(source)
    if not len(read.points):
        what = f'{counted(read.left_out, "point")}, none of which is finite'
        if read.cells is not None:
            what = 'no occupied cell'
        raise SceneFileError(f'holds {what}: there is no map to be written', str(source))
    data = map_bytes(read, target.suffix.lower(), resolution)
    with whole_file(target, 'wb') as file:
        file.write(data)
    if n := read.left_out:
        print(f'left out {counted(n, "point")} that {are(n)} not finite')
