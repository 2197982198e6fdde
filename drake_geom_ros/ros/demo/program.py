"""The main job, shown: a node, a player and a client, three processes.

``drake_geom_ros demo`` plays two arms over a table for 15 s, prints a live table and
leaves results.csv, distances.png and closest.png in out/demo.
"""

import argparse
import signal
import sys
from pathlib import Path

from drake_geom_ros.common.whole_files import check_first_line
from drake_geom_ros.program_parser import ProgramParser
from drake_geom_ros.ros.demo import sensed
from drake_geom_ros.ros.demo.processes import ProcessFailedError, ProcessGroup, ros_environment
from drake_geom_ros.ros.demo.recording import COLUMNS
from drake_geom_ros.ros.demo.shipped_scenes import shipped_scene
from drake_geom_ros.scene_files import SceneFileError, read_scene
from drake_geom_ros.trajectories.motion_file import load_motion

_SCENE = shipped_scene('two_pandas.yaml')
# Distances up to this [m] are shown; beyond, arms and objects are simply far away.
_MAX_DISTANCE = 0.3
_FAILED, _BAD_INPUT = 1, 2  # exit codes


def _arguments() -> argparse.Namespace:
    parser = ProgramParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--seconds', type=float, default=15.0, help='length of the recording')
    parser.add_argument('--forever', action='store_true', help='until Ctrl-C')
    parser.add_argument('--scene', type=Path, help='scene file (default: the two arms)')
    parser.add_argument(
        '--motion', type=Path, help='motion file (default: <scene>_motion.yaml beside the scene)'
    )
    parser.add_argument('--rate', type=float, default=100.0, help='pose messages per second')
    parser.add_argument(
        '--cross-check',
        type=float,
        default=0.0,
        metavar='HZ',
        help='cycles per second that python-fcl checks; the outcome is in the log',
    )
    parser.add_argument('--view', action='store_true', help='show it in the browser too')
    parser.add_argument(
        '--sensed',
        action='store_true',
        help='instead: an arm keeps its distance from a ball that only a depth camera sees',
    )
    parser.add_argument('--out', type=Path, default=Path('out/demo'), help='folder of the files')
    options = parser.parse_args()
    if not options.seconds > 0.0:
        parser.error(f'--seconds is {options.seconds:g}; it must be positive')
    if not 0.1 <= options.rate <= 1000.0:
        parser.error(f'--rate is {options.rate:g}; it must be from 0.1 to 1000 [Hz]')
    return options


def _files(options: argparse.Namespace) -> tuple[Path, Path | None]:
    """Return the scene and the motion file, None where everything is to stand still."""
    scene = options.scene or _SCENE
    motion = options.motion or scene.with_name(f'{scene.stem}_motion.yaml')
    return scene, motion if options.motion or motion.is_file() else None


def _keeping_adjacent_links(scene: Path, folder: Path) -> Path:
    """Write a copy of our scene in which adjacent links, which overlap by design, are reported.

    The client leaves them out itself: that is how filters are shown to come and go.
    """
    text = scene.read_text().replace('    srdf: ', '    adjacent_links: kept\n    srdf: ')
    file = folder / 'scene.yaml'
    file.write_text(text)
    return file


def _parameters(**values: object) -> list[str]:
    pairs = [f'{name}:={value}' for name, value in values.items()]
    return ['--ros-args', *(word for pair in pairs for word in ('-p', pair))]


def _run(options: argparse.Namespace, scene: Path, motion: Path | None) -> None:
    # Errors in the files are reported here, before anything is started.
    load_motion(motion, read_scene(scene))
    check_first_line(options.out / 'results.csv', ','.join(COLUMNS))
    options.out.mkdir(parents=True, exist_ok=True)
    if scene == _SCENE:
        scene = _keeping_adjacent_links(scene, options.out)
    environment = ros_environment()
    print(f'scene {scene}, motion {motion}, ROS domain {environment["ROS_DOMAIN_ID"]}', flush=True)
    package = 'drake_geom_ros.ros'
    with ProcessGroup(environment) as processes:
        processes.start(
            'scene_graph_node',
            f'{package}.scene_graph_node',
            *_parameters(
                scene_file=scene, max_distance=_MAX_DISTANCE, cross_check=options.cross_check
            ),
            log=options.out / 'scene_graph_node.log',
        )
        processes.start(
            'pose_player',
            f'{package}.pose_player',
            *_parameters(scene_file=scene, trajectory_file=motion or '""', rate=options.rate),
            log=options.out / 'pose_player.log',
        )
        if options.view:
            # Its output names the page.
            processes.start(
                'scene_viewer',
                f'{package}.viewer.scene_viewer',
                *_parameters(max_distance=_MAX_DISTANCE),
            )
        seconds = 'inf' if options.forever else str(options.seconds)
        processes.start(
            'demo_client',
            'drake_geom_ros.ros.demo.client',
            *('--scene', str(scene), '--seconds', seconds, '--out', str(options.out)),
        )
        processes.wait_for('demo_client')


def main() -> int:
    """Run the demo; return 0 when it ran to its end, 1 if a part failed, 2 for bad input."""
    options = _arguments()
    # Ended by a signal it still ends its processes.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        if options.sensed:
            sensed.show(options.out)
        else:
            _run(options, *_files(options))
    except ProcessFailedError as error:
        print(f'drake_geom_ros: {error}', file=sys.stderr)
        return _FAILED
    except (SceneFileError, ValueError, OSError) as error:
        print(f'drake_geom_ros: {error}', file=sys.stderr)
        return _BAD_INPUT
    except KeyboardInterrupt:
        # A second one, while the client was writing its files.
        return 128 + signal.SIGINT
    return 0
