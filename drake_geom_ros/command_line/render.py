"""Command ``render``: colour, depth and label images of a scene file, as pictures."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from drake_geom_ros.command_line import pictures
from drake_geom_ros.command_line.configurations import (
    add_joints_to,
    add_states_to,
    pose_joints,
    poses_of_states,
)
from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.option_values import count, distance, finite, positive
from drake_geom_ros.command_line.pose_file import PoseSet, read_poses
from drake_geom_ros.command_line.scene_input import add_scene_options
from drake_geom_ros.common.progress_bar import progress_bar
from drake_geom_ros.common.whole_files import check_outputs
from drake_geom_ros.geometry import FrameId, FramePoseVector, GeometryId, Role
from drake_geom_ros.scene_files import (
    CameraDescription,
    SceneFileError,
    add_renderers,
    camera_of,
    check_camera,
)
from drake_geom_ros.scene_files.cameras import RENDERERS
from drake_geom_ros.sensors import CameraInfo
from drake_geom_ros.viewing.notebook import NotebookPicture
from drake_geom_ros.viewing.shown_contacts import contacts_of
from drake_geom_ros.viewing.shown_pairs import ReportedPairs
from drake_geom_ros.viewing.snapshot import Camera, looking, picture

Moments = Sequence[PoseSet | FramePoseVector]
Cameras = list[tuple[FrameId, CameraDescription]]


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'render',
        description='Takes images of a scene by its cameras, or by one that is placed here, and '
        'writes colour, depth (16 bits, millimetres) and labels as PNG, with depth and labels '
        'also as pictures with a scale and a legend.',
    )
    parser.add_argument('scene', metavar='SCENE', help='scene file, model or mesh')
    add_scene_options(parser)
    _add_camera(parser)
    moving = parser.add_mutually_exclusive_group()
    moving.add_argument('--poses', metavar='FILE', help='an image for each moment: CSV or JSON')
    add_states_to(moving)
    add_joints_to(parser)
    parser.add_argument(
        '--time', type=finite, metavar='T', help='only the moment T of --poses [s]'
    )
    parser.add_argument(
        '--nearest',
        type=distance,
        metavar='D',
        help='a picture CAMERA_view.png, too, with lines between the nearest points of pairs up '
        'to D [m], orange where they overlap',
    )
    parser.add_argument(
        '--see-through',
        type=positive,
        nargs='?',
        const=0.4,
        metavar='C',
        help='a picture CAMERA_view.png, too, whose bodies cover only this share of what is '
        'behind them (default: 0.4)',
    )
    parser.add_argument(
        '--contacts',
        action='store_true',
        help='a picture CAMERA_view.png, too, with the contact surfaces of geometries that have '
        'hydroelastic properties, coloured by pressure',
    )
    parser.add_argument(
        '--out', '--output', dest='out', required=True, metavar='DIR', help='folder to write to'
    )
    parser.set_defaults(run=run)


def _add_camera(parser: argparse.ArgumentParser) -> None:
    """Add the options that select a camera of the scene, or place one."""
    parser.add_argument('--camera', metavar='NAME', help='only this camera of the scene file')
    for name, where in (('--from', 'where it is'), ('--at', 'what it looks at')):
        parser.add_argument(
            *(name,),
            dest=f'{name[2:]}_W',
            nargs=3,
            type=finite,
            metavar=('X', 'Y', 'Z'),
            help=f'a camera of its own: {where} in the world [m]',
        )
    parser.add_argument(
        '--size', nargs=2, type=count, default=(640, 480), metavar=('WIDTH', 'HEIGHT')
    )
    parser.add_argument(
        '--fov-y', type=positive, default=0.8, metavar='A', help='of --from [rad] (default: 0.8)'
    )
    parser.add_argument(
        '--shows',
        choices=('perception', 'proximity'),
        help='the role of what --from sees (default: perception where any geometry has it)',
    )


def run(options: argparse.Namespace) -> int:
    """Write the images and return the exit code; raises GeometryError or OSError for bad input."""
    if (options.from_W is None) != (options.at_W is None):
        raise SceneFileError('--from and --at go together', options.scene)
    if options.time is not None and not options.poses:
        raise SceneFileError('--time goes with --poses', options.scene)
    pictures.check_libraries()
    scene = OpenedScene(options.scene, options.srdf, options.package_root, options.solid)
    pose_joints(scene, options.joints)
    moments: Moments = [PoseSet()]
    if options.poses:
        moments = read_poses(options.poses)
    elif options.states:
        moments = poses_of_states(scene, options.states).poses
    cameras = _cameras(scene, options)
    add_renderers(scene.scene_graph)
    folder = Path(options.out)
    folder.mkdir(parents=True, exist_ok=True)
    paths = (options.scene, options.srdf, options.poses, options.states)
    inputs = [Path(each) for each in paths if each]
    inputs += scene.files()
    total = len(cameras) * (1 if options.time is not None else len(moments))
    done = 0
    has_view = options.nearest is not None or options.see_through is not None or options.contacts
    with progress_bar('images', total) if total > 1 else nullcontext() as show:
        for number in _posed(scene, moments, options.time):
            suffix = '' if number is None else f'_{number:04d}'
            for frame, camera in cameras:
                path = folder / f'{camera.name}{suffix}'
                _write(scene, frame, camera, path, inputs)
                if has_view:
                    _write_view(scene, frame, camera, path, inputs, options)
                done += 1
                if show is not None:
                    show(done)
    print(f'{done} x {len(cameras[0][1].images)} images in {folder}')
    return 0


def _posed(scene: OpenedScene, moments: Moments, time: float | None) -> Iterator[int | None]:
    """Pose the scene for each moment, or only for the one at ``time``, and yield its number."""
    if time is not None:
        timed = [m for m in moments if isinstance(m, PoseSet) and m.time is not None]
        past = [m for m in timed if m.time is not None and m.time <= time]
        if not past:
            raise SceneFileError(
                f'--time {time}: the pose file begins later, or tells no times', ''
            )
        for one in past:
            scene.pose(one.poses)
        scene.check_whole()
        yield None
        return
    for number, moment in enumerate(moments):
        if isinstance(moment, PoseSet):
            scene.pose(moment.poses)
        else:
            scene.context.UpdateFramePoses(moment)
        scene.check_whole()
        yield number if len(moments) > 1 else None


def _write(
    scene: OpenedScene,
    frame: FrameId,
    description: CameraDescription,
    path: Path,
    inputs: Sequence[Path],
) -> None:
    camera = camera_of(description)
    query = scene.query
    images = query.render_images(camera, frame, description.X_FC, description.images)
    legend: pictures.Legend = {}
    for geometry, label in query.render_legend(camera.core().renderer_name()).items():
        legend.setdefault(label, []).append(scene.names[geometry])
    pictures.write_all(images, legend, path, inputs)


def _write_view(
    scene: OpenedScene,
    frame: FrameId,
    description: CameraDescription,
    path: Path,
    inputs: Sequence[Path],
    options: argparse.Namespace,
) -> None:
    """Write a picture for people, with nearest points, contacts or transparent bodies."""
    query = scene.query
    pairs = None
    if options.nearest is not None:
        pairs = ReportedPairs.of(query.ComputeSignedDistancePairwiseClosestPoints(options.nearest))
    patches = None
    if options.contacts:
        patches, remarks, missing = contacts_of(query, lambda id: scene.names[GeometryId(id)])
        for remark in (*remarks, *missing):
            print(f'{path.name}: {remark}')
    camera = Camera(query.X_WF(frame) @ description.X_FC, description.intrinsics)
    cover = 1.0 if options.see_through is None else options.see_through
    _, role = RENDERERS[description.shows]
    shown = NotebookPicture(picture(query, camera, role, cover, pairs, patches))
    file = path.with_name(f'{path.name}_view.png')
    check_outputs({'the image': file}, inputs)
    shown.save(file)


def _cameras(scene: OpenedScene, options: argparse.Namespace) -> Cameras:
    """Return the cameras that the options select, and their frames."""
    if options.from_W is not None:
        return [(scene.inspector.world_frame_id(), _placed(scene, options))]
    if options.camera is None:
        if not scene.cameras:
            raise SceneFileError(
                'the scene has no cameras: place one by --from X Y Z --at X Y Z', options.scene
            )
        return list(scene.cameras.values())
    if options.camera not in scene.cameras:
        names = ', '.join(scene.cameras) or 'none'
        raise SceneFileError(f'no camera {options.camera!r}; it has {names}', options.scene)
    return [scene.cameras[options.camera]]


def _placed(scene: OpenedScene, options: argparse.Namespace) -> CameraDescription:
    """Return the camera that the options place in the world."""
    shows = options.shows
    if shows is None:
        has_perception = scene.inspector.NumGeometriesWithRole(Role.kPerception) > 0
        shows = 'perception' if has_perception else 'proximity'
        if not has_perception:
            print('no geometry has the perception role: shown is what has the proximity role')
            sys.stdout.flush()
    try:
        camera = CameraDescription(
            *('camera', '', 'world', looking(options.from_W, options.at_W)),
            CameraInfo(*options.size, options.fov_y),
            shows=shows,
        )
        check_camera(camera)
    except RuntimeError as error:
        raise SceneFileError(str(error), options.scene) from error
    return camera
