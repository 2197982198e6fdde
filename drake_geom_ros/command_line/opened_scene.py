"""Scene loaded from a file and posed for queries, with names of its geometries."""

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from drake_geom_ros.command_line.pose_file import FramePose
from drake_geom_ros.command_line.scene_input import read_and_warn
from drake_geom_ros.geometry import FrameId, FramePoseVector, GeometryId, QueryObject, SceneGraph
from drake_geom_ros.scene_files import (
    SceneDescription,
    SceneFileError,
    add_renderers,
    camera_of,
    files_of,
    register,
)
from drake_geom_ros.scene_files.names import FileNames
from drake_geom_ros.trajectories.motion_file import load_motion


class OpenedScene:
    """A scene with the poses of its frames.

    Frames have the poses of the scene file. Links of robots have those of forward kinematics, in
    the configuration of the file; other joints are at 0, or at their limit nearest to 0. All other
    frames have no pose, among them links below a planar or floating joint without values, and
    links of a robot whose joints form no tree.
    """

    def __init__(
        self,
        path: str,
        srdf: str = '',
        package_roots: Sequence[str] = (),
        solid: bool = False,
    ) -> None:
        """Load a file and print its warnings; raises SceneFileError for an invalid one."""
        self._path = path
        self.description: SceneDescription = read_and_warn(path, srdf, package_roots, solid)
        self.scene_graph = SceneGraph()
        self.loaded = loaded = register(self.scene_graph, self.description)
        self._frames = loaded.frames
        self.cameras = {camera.name: (frame, camera) for frame, camera in loaded.cameras}
        self.context = self.scene_graph.CreateSharedContext(partial=True)
        self.context.UpdateFramePoses(self._at_rest())
        self.context.UpdateFramePoses(FramePoseVector(loaded.X_PFs))
        self._table = FileNames(self.description.frames, self.description.geometries)
        self.inspector = self.scene_graph.model_inspector()
        self.names = {id: self._name(id) for id in self.inspector.GetAllGeometryIds()}

    @property
    def query(self) -> QueryObject:
        """The query object of the scene at its current poses."""
        return self.scene_graph.get_query_output_port().Eval(self.context)

    def compile_kernels(self, progress: Callable[[str, int, int], None], part: str) -> list[str]:
        """Compile the kernels of the scene's queries; see ``SceneGraphContext.compile_kernels``.

        The kernels of its cameras are compiled too, as a part of 'cycle'.
        """
        kernels = self.context.compile_kernels(progress, part)
        if self.cameras and part != 'kernels':
            add_renderers(self.scene_graph)
            for frame, camera in list(self.cameras.values())[:1]:
                self.query.render_images(camera_of(camera), frame, camera.X_FC, camera.images)
        return kernels

    def files(self) -> Iterator[Path]:
        """Yield the input files of the scene, besides its own."""
        return files_of(self.scene_graph, self.description.robots)

    def check_whole(self) -> None:
        """Raise SceneFileError, naming the frames, if some have no pose."""
        if waiting := self.query.waiting_frames():
            raise SceneFileError(
                f'these frames have no pose: {", ".join(map(self.frame_name, waiting))}; give '
                'them the key `pose` in the scene file, or name them in a file for --poses',
                self._path,
            )

    def pose(self, poses: Iterable[FramePose]) -> None:
        """Pose frames; raises SceneFileError, with the pose's place, for an unknown frame."""
        self.context.UpdateFramePoses(self.vector(poses))

    def vector(self, poses: Iterable[FramePose]) -> FramePoseVector:
        """Return poses by frame ids; raises SceneFileError like ``pose``."""
        X_PFs = FramePoseVector()
        for pose in poses:
            member = self._table.find(pose.frame, pose.where)
            key = (member.source, member.frame)
            if member.geometry is not None or key not in self._frames:
                raise pose.where.error(f'{pose.frame!r} is not a frame that can be posed')
            if X_PFs.has_id(self._frames[key]):
                raise pose.where.error(f'{pose.frame!r} is posed twice at the same time')
            X_PFs.set_value(self._frames[key], pose.X_PF)
        return X_PFs

    def frame_name(self, frame: FrameId) -> str:
        """Return ``source::frame``; ``world`` for the world frame."""
        name = self.inspector.GetName(frame)
        if frame == self.inspector.world_frame_id():
            return name
        return f'{self.inspector.GetOwningSourceName(frame)}::{name}'

    def _name(self, geometry: GeometryId) -> str:
        """Return ``source::frame/geometry``."""
        inspector = self.inspector
        frame = inspector.GetName(inspector.GetFrameId(geometry))
        source = inspector.GetOwningSourceName(geometry)
        return f'{source}::{frame}/{inspector.GetName(geometry)}'

    def _at_rest(self) -> FramePoseVector:
        """Return the poses of the robots' links with all joints at rest."""
        if not self.description.robots:
            return FramePoseVector()
        motion = load_motion(None, self.description)
        for robot, reason in motion.left_out.items():
            warning = f'warning: {reason}. No joint values pose the links of {robot!r}: give poses'
            print(warning, file=sys.stderr)
        robots = {robot.name for robot in self.description.robots} & motion.frame_names.keys()
        poses = motion.poses(0.0)
        rows = [row for robot in robots for row in poses[robot]]
        frames = [self._frames[robot, f] for robot in robots for f in motion.frame_names[robot]]
        return FramePoseVector.FromArrays(frames, rows)
