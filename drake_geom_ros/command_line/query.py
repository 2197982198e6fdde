"""Command ``query``: distances, penetrations, candidates or point distances of a scene file."""

import argparse
import csv
import json
import math
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.command_line.answers import (
    AS_IN_BATCHES,
    FORMATS,
    KINDS,
    LIMITED,
    OF_PAIRS,
    QueryOptions,
    Table,
    half_spaces_beside,
)
from drake_geom_ros.command_line.configurations import add_joints_to, pose_joints
from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.option_values import ACCURACY_HELP, accuracy, count, distance
from drake_geom_ros.command_line.pairs_between import add_between_to, exclude_other_pairs
from drake_geom_ros.command_line.pose_file import PoseSet, read_poses
from drake_geom_ros.command_line.scene_input import add_scene_options
from drake_geom_ros.command_line.standard_input import bytes_of, is_json, name_of
from drake_geom_ros.common.whole_files import check_outputs, whole_file
from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.scene_files.yaml_text import text_of


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'query',
        description='Answers one question about a scene, for each moment of the pose file.',
    )
    parser.add_argument('scene', metavar='SCENE', help='scene file, model or mesh')
    add_scene_options(parser)
    parser.add_argument(
        '--what',
        type=lambda word: AS_IN_BATCHES.get(word, word),
        choices=KINDS,
        default='distance',
        help='the question (default: distance); batch calls distances within, and collisions '
        'collision',
    )
    parser.add_argument(
        '--poses',
        metavar='FILE',
        help='CSV or JSON; frames that it does not name stay where the scene file puts them',
    )
    add_joints_to(parser)
    parser.add_argument(
        '--points', metavar='FILE', help='points for --what points: CSV x,y,z or JSON [[x, y, z]]'
    )
    parser.add_argument(
        '--count', type=count, default=1, metavar='K', help='pairs for --what nearest (default: 1)'
    )
    add_between_to(parser, 'the question is')
    parser.add_argument(
        '--max-distance',
        type=distance,
        default=math.inf,
        metavar='D',
        help='leave out what is farther apart [m] (default: inf)',
    )
    parser.add_argument('--accuracy', type=accuracy, default='exact', help=ACCURACY_HELP)
    parser.add_argument('--format', choices=tuple(FORMATS), default='csv')
    parser.add_argument(
        '--out', '--output', dest='out', metavar='FILE', help='default: standard output'
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Query, write and return the exit code; GeometryError or OSError for bad input."""
    if (options.what == 'points') != bool(options.points):
        raise SceneFileError('--what points and --points FILE go together', options.scene)
    if options.what not in LIMITED and options.max_distance < math.inf:
        raise SceneFileError(
            f'--max-distance goes with --what {", ".join(LIMITED)}; {options.what} is of what '
            'overlaps. For a margin ask for distances, or: batch --what collision --max-distance',
            options.scene,
        )
    if options.count != 1 and options.what != 'nearest':
        raise SceneFileError(
            f'--count {options.count} goes with --what nearest, not {options.what}', options.scene
        )
    if options.points and options.between:
        raise SceneFileError(
            f'--between {options.between[0]} is about pairs; --what points has none', options.scene
        )
    points = points_of_file(options.points) if options.points else None
    query_options = QueryOptions(options.max_distance, options.accuracy, points, options.count)
    moments = read_poses(options.poses) if options.poses else [PoseSet()]
    scene = OpenedScene(options.scene, options.srdf, options.package_root, options.solid)
    pose_joints(scene, options.joints)
    if options.between:
        exclude_other_pairs(scene.scene_graph, scene.context, options.between)
    inputs = [options.scene, options.srdf, options.poses, options.points, *scene.files()]
    check_outputs({'--out': options.out}, inputs)

    beside: dict[str, None] = {}

    def answers() -> Iterator[tuple[float | None, Table]]:
        ask = KINDS[options.what]
        for moment in moments:
            scene.pose(moment.poses)
            scene.check_whole()
            if options.what in OF_PAIRS:
                beside.update(dict.fromkeys(half_spaces_beside(scene)))
            yield moment.time, ask(scene, query_options)

    # Everything is computed before the file is opened, so that bad input keeps an old file.
    done = list(answers())
    timed = any(time is not None for time, _ in done)
    with _target(options.out) as file:
        FORMATS[options.format](done, timed, file)
    for remark in beside:
        print(remark, file=sys.stderr)
    return 0


def _target(path: str | None) -> AbstractContextManager[TextIO]:
    """Return the file to write to, or standard output without a path."""
    return whole_file(path) if path else nullcontext(sys.stdout)


def points_of_file(path: str) -> NDArray[np.float64]:
    """Return the points (m, 3) [m] of a file; raises SceneFileError for another format."""
    file = name_of(path)
    text = text_of(bytes_of(path), file)
    try:
        if is_json(path, text):
            points = np.array(json.loads(text), dtype=np.float64).reshape(-1, 3)
        else:
            rows = list(csv.DictReader(text.splitlines()))
            # A row that ends before a column has nothing there.
            points = np.array([[float(row[axis] or '') for axis in 'xyz'] for row in rows])
    except (KeyError, TypeError, ValueError) as error:
        reason = f'there is no column {error}' if isinstance(error, KeyError) else str(error)
        raise SceneFileError(
            f'must hold points, CSV with the columns x,y,z or JSON [[x, y, z], ...]: {reason}',
            file,
        ) from None
    if not len(points):
        raise SceneFileError('there is no point in it', file)
    return points.reshape(-1, 3)
