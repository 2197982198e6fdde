"""Command ``compile``: compile kernels of queries ahead of time."""

import argparse
import time
from typing import Any

from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.scene_input import add_scene_options
from drake_geom_ros.geometry import compile_all_kernels, kernel_cache


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'compile',
        description='Compiles the kernels of all shapes, or those of one scene, into the cache '
        'on disk: programs and nodes of this user start without compiling from then on. '
        'NUMBA_CACHE_DIR names another folder for the cache.',
    )
    parser.add_argument(
        'scene', metavar='SCENE', nargs='?', default='', help='only what this scene file needs'
    )
    add_scene_options(parser)
    parser.add_argument(
        '--part',
        choices=('all', 'cycle', 'kernels'),
        default='all',
        help='of a scene, what runs around the kernels or these alone: for two processes at once',
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Compile, print the progress, and return the exit code."""
    start = time.monotonic()

    def show_progress(name: str, number: int, last: int) -> None:
        seconds = time.monotonic() - start
        print(f'{seconds:5.0f} s  compiling {name} ({number} of {last})', flush=True)

    if options.part != 'all' and not options.scene:
        raise OSError(f'compile --part {options.part} needs a scene: compile SCENE --part ...')
    if options.scene:
        scene = OpenedScene(options.scene, options.srdf, options.package_root, options.solid)
        kernels = scene.compile_kernels(show_progress, options.part)
    else:
        kernels = compile_all_kernels(show_progress)
    seconds, folder = time.monotonic() - start, kernel_cache()
    where = f'in {folder}' if folder else 'for this process only: no cache can be written'
    print(f'{seconds:5.0f} s  {len(kernels)} kernels are ready, {where}')
    return 0
