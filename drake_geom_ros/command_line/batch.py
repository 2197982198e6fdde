"""Command ``batch``: one query of many states of a scene, with results in a file."""

import argparse
import math
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch import WANTS, Joints, Question, cluster_executor
from drake_geom_ros.batch.contacts import rows_of_pairs
from drake_geom_ros.batch.evaluation import computed
from drake_geom_ros.batch.parts import FinishedParts
from drake_geom_ros.batch.questions import Columns, Job
from drake_geom_ros.batch.result_files import About, check_place, check_suffix, write
from drake_geom_ros.batch.running import REMOTE_BLOCK, blocks_of, size_for_all
from drake_geom_ros.batch.state_files import StateRows, read_states
from drake_geom_ros.batch.summary import Summary
from drake_geom_ros.batch.worker import version
from drake_geom_ros.command_line.answers import AS_IN_BATCHES
from drake_geom_ros.command_line.exit_codes import INTERRUPTED
from drake_geom_ros.command_line.option_values import ACCURACY_HELP, accuracy, count, distance
from drake_geom_ros.command_line.query import points_of_file
from drake_geom_ros.command_line.scene_input import add_scene_options, load_chosen
from drake_geom_ros.common.frame_names import AmbiguousNameError, FrameNames
from drake_geom_ros.common.whole_files import check_outputs
from drake_geom_ros.geometry import GeometryId, PoseError, SceneGraph
from drake_geom_ros.scene_files import LoadedScene, SceneFileError, files_of

# The same questions by the words of ``query``.
AS_IN_QUERIES = {words: word for word, words in AS_IN_BATCHES.items()}
# Titles of histograms, by what is asked for.
_TITLES = {
    'least': 'minimum distance of each state',
    'nearest': 'distances of the nearest pairs of each state',
    'within': 'distances of near pairs of each state',
    'points': 'distances of points in each state',
}


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'batch',
        description='Answers one question about each of many states of a scene: joint values of '
        'its robots, or poses of frames. What is done is kept beside the output until all is.',
    )
    parser.add_argument('scene', metavar='SCENE', help='scene file, model or mesh')
    parser.add_argument('states', metavar='STATES', help='.npy, .npz or .csv: see docs/batches.md')
    add_scene_options(parser)
    parser.add_argument(
        '--names', nargs='+', metavar='NAME', help='joints or frames that the columns are of'
    )
    parser.add_argument(
        '--what',
        type=lambda word: AS_IN_QUERIES.get(word, word),
        choices=WANTS,
        default='least',
        help='(default: least)',
    )
    parser.add_argument('--points', metavar='FILE', help='points for --what points, as for query')
    parser.add_argument(
        '--count', type=count, default=1, metavar='K', help='pairs for --what nearest (default: 1)'
    )
    parser.add_argument(
        '--max-distance',
        type=distance,
        default=math.inf,
        metavar='D',
        help='leave out what is farther apart [m] (default: inf); with --what collision it is a '
        'margin: a state collides unless every pair is certified to be farther apart',
    )
    parser.add_argument(
        '--accuracy',
        type=accuracy,
        default='exact',
        help=f'{ACCURACY_HELP}; distances to points are exact at each',
    )
    parser.add_argument(
        '--joint-gradients',
        action='store_true',
        help='derivatives of the distances by the joint values, too',
    )
    parser.add_argument(
        '--without-states',
        action='store_true',
        help='leave the states out of the results, which have them beside their answers',
    )
    parser.add_argument(
        '--out', '--output', dest='out', required=True, metavar='FILE', help='.npz or .parquet'
    )
    parser.add_argument('--picture', metavar='FILE', help='a histogram of the distances')
    parser.add_argument(
        '--cluster',
        '--scheduler',
        dest='cluster',
        metavar='ADDRESS',
        help='compute on a Dask cluster, as tcp://host:8786',
    )
    parser.add_argument('--resume', action='store_true', help='go on with a run that was cut off')
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Compute, write and return the exit code; GeometryError or OSError for bad input."""
    output = Path(options.out)
    check_suffix(output)
    inputs = [options.scene, options.srdf, options.states, options.points]
    outputs = {'--out': output, '--picture': options.picture}
    check_outputs(outputs, inputs)
    check_place(output)
    scene_graph = SceneGraph()
    loaded = load_chosen(options, scene_graph)
    check_outputs(outputs, files_of(scene_graph, loaded.robots.values()))
    if options.picture and options.what in ('collision', 'contacts'):
        raise SceneFileError(
            f'--picture shows distances, of which --what {options.what} has none', '--what'
        )
    states = read_states(options.states, options.names)
    points = points_of_file(options.points) if options.points else None
    question = Question(
        *(options.what, options.max_distance, options.accuracy, options.count, points),
        by_joints=options.joint_gradients,
    )
    job, lists = _job(scene_graph, loaded, states, question)
    start = time.perf_counter()
    size = size_for_all(len(states.rows), 0, REMOTE_BLOCK)
    task = {
        'job': job.digest,
        'scene': job.scene.digest,
        'states': states.digest,
        'version': version(),
        'question': question.words,
    }
    parts = FinishedParts(output, task, blocks_of(len(states.rows), size) or [(0, 0)])
    scheduler = options.cluster
    with cluster_executor(scheduler) if scheduler else nullcontext() as executor:
        missing = parts.begin(options.resume, lambda text: print(text, file=sys.stderr))
        done = len(parts.blocks) - len(missing)
        _say(f'{done} of {len(parts.blocks)} blocks are there', options)
        try:
            for block, columns in computed(job, states.rows, missing, executor, progress=True):
                parts.put(block, columns)
        except (PoseError, SceneFileError):
            parts.remove()  # every run would refuse this input, so the parts are useless
            raise
        except KeyboardInterrupt:
            print(f'interrupted; --resume goes on with {parts.folder}', file=sys.stderr)
            return INTERRUPTED
    about = About.of(
        (job.scene.digest, question.words, {'drake_geom_ros': version()}),
        lists.pop('geometries'),
        lists,
    )
    check_place(output)  # again, since hours may have passed
    summary = Summary()
    write(output, summary.of(_columns(parts, states, options.without_states)), about)
    if options.picture:
        title = f'{Path(options.scene).stem}: {_TITLES.get(question.want, question.want)}'
        summary.draw(Path(options.picture), title)
    if not parts.remove():
        print(f'{parts.folder} stays: it holds what is not of this run', file=sys.stderr)
    print(*summary.lines(), f'seconds {time.perf_counter() - start:.2f}', sep='\n')
    return 0


def _frames(loaded: LoadedScene, texts: Iterable[str]) -> NDArray[np.int64]:
    """Return the id values of frames by their names ``source::frame``."""
    names, ids = FrameNames(loaded.frames), []
    for text in texts:
        try:
            frame = names.find(text)
        except AmbiguousNameError as error:
            raise SceneFileError(str(error), '<states>') from None
        if frame is None:
            raise SceneFileError(
                f'the scene has no frame {text!r}; there are {", ".join(names)}', '<states>'
            )
        ids.append(loaded.frames[frame].get_value())
    return np.array(ids, dtype=np.int64)


def _say(text: str, options: argparse.Namespace) -> None:
    if options.resume:
        print(text, file=sys.stderr)


def _columns(parts: FinishedParts, states: StateRows, without_states: bool) -> Iterator[Columns]:
    """Yield the results of each block, with its states unless ``without_states``."""
    name = 'poses' if states.are_poses else 'states'
    for block in parts.blocks:
        columns = parts.get(block)
        if 'point_counts' in columns:
            columns = rows_of_pairs(columns)
        yield columns if without_states else {**columns, name: states.rows[slice(*block)]}


def _job(
    scene_graph: SceneGraph, loaded: LoadedScene, states: StateRows, question: Question
) -> tuple[Job, dict[str, list[str]]]:
    """Return the job, and the names of its geometries, and of the joints or frames of states."""
    arms: tuple[Any, ...] = ()
    named_by: dict[str, list[str]] = {'frames': list(states.names or ())}
    if states.are_poses:
        ids = _frames(loaded, states.names or ())
    else:
        joints = Joints.of(loaded, states.names)
        if joints.count != states.rows.shape[1]:
            raise SceneFileError(
                f'{states.rows.shape[1]} columns for {joints.count} joints: '
                f'{", ".join(joints.names)}; --names says which of them there are',
                '<states>',
            )
        ids, arms = joints.id_values, joints.arms
        named_by = {'joints': list(joints.names)}
    job, geometry_ids = Job.of(scene_graph.CreateDefaultContext(), question, ids, arms)
    inspector = scene_graph.model_inspector()
    on = [inspector.GetFrameId(GeometryId(value)) for value in geometry_ids.tolist()]
    return job, {
        'geometries': inspector.full_names(geometry_ids),
        'geometry_frames': [inspector.full_name(frame) for frame in on],
        **named_by,
    }
