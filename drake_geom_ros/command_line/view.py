"""Command ``view``: a page in the browser with a scene, its distances and its filters."""

import argparse
import sys
import threading
from pathlib import Path
from typing import Any

from drake_geom_ros.command_line.configurations import (
    add_joints_to,
    add_states_to,
    pose_joints,
    poses_of_states,
)
from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.option_values import (
    ACCURACY_HELP,
    accuracy,
    count,
    distance,
    positive,
)
from drake_geom_ros.command_line.pairs_between import add_between_to, exclude_other_pairs
from drake_geom_ros.command_line.pose_file import PoseSet, read_poses
from drake_geom_ros.command_line.recording_input import add_topics_to, topics_of
from drake_geom_ros.command_line.scene_input import add_scene_options
from drake_geom_ros.geometry import (
    ArgumentError,
    FramePoseVector,
)
from drake_geom_ros.recordings.recorded_poses import recorded_poses
from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.trajectories.motion_file import load_motion
from drake_geom_ros.viewing.joint_sliders import JointSliders
from drake_geom_ros.viewing.local_scene import LocalScene
from drake_geom_ros.viewing.page.motion_control import PlottedPairs
from drake_geom_ros.viewing.page.page import Page
from drake_geom_ros.viewing.page.serving import LOCALHOST, PORT, open_server, warning
from drake_geom_ros.viewing.timeline import Timeline


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'view',
        description='Serves a page on this machine until it is interrupted: the scene, its '
        'nearest pairs, its filters; joints, frames and motions that can be moved.',
    )
    parser.add_argument(
        'scene', metavar='SCENE', help='scene file, model or mesh; with --scene a recording of ROS'
    )
    parser.add_argument(
        '--scene',
        dest='of_recording',
        metavar='FILE',
        help='the scene file of a recording (MCAP, sqlite3, or a folder), which is played',
    )
    parser.add_argument(
        '--rate',
        type=positive,
        default=20.0,
        metavar='HZ',
        help='moments a second of a recording (default: 20)',
    )
    add_topics_to(parser)
    add_scene_options(parser)
    moving = parser.add_mutually_exclusive_group()
    moving.add_argument('--poses', metavar='FILE', help='poses of frames over time, CSV or JSON')
    moving.add_argument('--motion', metavar='FILE', help='motion of robots and frames, YAML')
    add_states_to(moving)
    add_joints_to(parser)
    add_between_to(parser, 'the plot of the motion is')
    parser.add_argument(
        '--max-distance',
        type=distance,
        default=0.1,
        metavar='D',
        help='pairs farther apart are left out [m], until the slider is moved (default: 0.1)',
    )
    parser.add_argument('--accuracy', type=accuracy, default='exact', help=ACCURACY_HELP)
    parser.add_argument(
        '--contacts',
        action='store_true',
        help='compute and show contact surfaces from the beginning, coloured by pressure',
    )
    parser.add_argument('--host', default=LOCALHOST, help=f'default: {LOCALHOST}, this machine')
    parser.add_argument('--port', type=count, default=PORT, help=f'default: {PORT}')
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Serve a page until it is interrupted; raises GeometryError or OSError for bad input."""
    page = open_page(options)
    print(page.url, flush=True)
    if remark := warning(options.host):
        print(f'warning: {remark}', file=sys.stderr)
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        page.close()
    return 0


def open_page(options: argparse.Namespace) -> Page:
    """Return the page of a scene file, or of a recording of one."""
    file = options.of_recording or options.scene
    posed = OpenedScene(file, options.srdf, options.package_root, options.solid)
    values = pose_joints(posed, options.joints)
    scene = LocalScene(posed.scene_graph, posed.context)
    motion = load_motion(options.motion, posed.description)
    joints = None if options.of_recording else JointSliders(motion.robots, scene.frames)
    if joints is not None:
        joints.take(values)
    timeline = _timeline_of_recording(options, posed, scene) if options.of_recording else None
    if options.motion:
        timeline = Timeline.of_motion(motion, scene.frames)
    elif options.poses:
        timeline = _timeline(posed, read_poses(options.poses), options.poses)
    elif options.states and joints is not None:
        states = poses_of_states(posed, options.states)
        timeline = Timeline.of_moments(range(len(states.poses)), states.poses)
        joints.follow_states(states.values)
    if timeline is not None:
        # Frames that a recording does not pose must not be shown at rest: they are unknown.
        show = scene.pose_only if timeline.names_all else scene.pose
        show(timeline.poses(timeline.start))
    return Page(
        open_server(options.host, options.port),
        scene,
        joints=joints,
        timeline=timeline,
        plotted=plotted_pairs(posed, options.between) if options.between else None,
        max_distance=options.max_distance,
        accuracy=options.accuracy,
        contacts=options.contacts,
        title=Path(file).stem,
        log=lambda text: print(text, file=sys.stderr, flush=True),
    )


def plotted_pairs(posed: OpenedScene, between: list[str]) -> PlottedPairs:
    """Return the pairs of sets such as ``left:right``; raises ArgumentError if there are none."""
    context = posed.context.copy()
    return PlottedPairs(exclude_other_pairs(posed.scene_graph, context, between), context)


def _timeline_of_recording(
    options: argparse.Namespace, posed: OpenedScene, scene: LocalScene
) -> Timeline:
    """Return the timeline of a recording."""
    if options.motion or options.poses or options.states or options.joints:
        raise ArgumentError(
            'a recording is played by itself: no --motion, --poses, --states or --joints'
        )
    recorded = recorded_poses(
        *(options.scene, posed.description, options.rate),
        topics=topics_of(options),
        world_frame=options.world_frame,
        package_roots=options.package_root,
        warn=lambda words: print(f'not known, or wrong: {words}', file=sys.stderr),
    )
    vectors = [
        FramePoseVector.FromArrays([scene.frames[frame] for frame in each.frames], each.rows)
        for each in recorded
    ]
    return Timeline.of_moments([each.time for each in recorded], vectors, names_all=True)


def _timeline(posed: OpenedScene, moments: list[PoseSet], file: str) -> Timeline:
    """Return the timeline of a pose file; moments without a time last one second each."""
    times = [k if each.time is None else each.time for k, each in enumerate(moments)]
    latest: dict[Any, Any] = {}
    vectors = []
    for moment in moments:
        # Frames that a moment does not name keep the pose of the moment before.
        X_PFs = posed.vector(moment.poses)
        latest |= {frame: X_PFs.value(frame) for frame in X_PFs.ids()}
        vectors.append(FramePoseVector(latest))
    try:
        return Timeline.of_moments(times, vectors)
    except ValueError as error:
        raise SceneFileError(str(error), file) from None
