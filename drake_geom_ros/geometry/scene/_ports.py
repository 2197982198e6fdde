"""Ports of a scene graph, with the methods that pydrake scripts call."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentTypeError
from drake_geom_ros.geometry.ids import SourceId
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.model.links import links_of
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.queries.context import SceneGraphContext
from drake_geom_ros.geometry.queries.query_object import QueryObject
from drake_geom_ros.math import RigidTransform


class SourcePosePort:
    """Input port for the poses of one source's frames."""

    __slots__ = ('_source_id',)

    def __init__(self, source_id: SourceId) -> None:
        self._source_id = source_id

    def FixValue(self, context: SceneGraphContext, value: FramePoseVector) -> None:
        """Set the poses of all frames of the source in a context, see ``SetFramePoses``."""
        if type(context) is not SceneGraphContext or type(value) is not FramePoseVector:
            _checked_context(context, 'FixValue')
            checked_type(value, FramePoseVector, 'FixValue: value')
        context.SetFramePoses(self._source_id, value)


class QueryPort:
    """Output port for the query object of a context."""

    __slots__ = ()

    def Eval(self, context: SceneGraphContext) -> QueryObject:
        """Return a live query object, which sees later poses of the context."""
        return QueryObject(_checked_context(context, 'Eval'))


def _checked_context(context: SceneGraphContext, method: str) -> SceneGraphContext:
    """Return a context of floats; raises ArgumentTypeError for anything else."""
    checked_type(context, SceneGraphContext, f'{method}: context')
    if context.scalar != 'float':
        raise ArgumentTypeError(
            f'{method} of a SceneGraph_[float] was given a context of a '
            f'SceneGraph_[{context.scalar}]: take the port of that one.'
        )
    return context


class _NamedPose(NamedTuple):
    name: str
    group: int
    X_WF: RigidTransform


class PoseBundle:
    """Poses of frames in the world, by index: the value of ``get_pose_bundle_output_port``."""

    __slots__ = ('_poses',)

    def __init__(self, poses: list[_NamedPose]) -> None:
        self._poses = poses

    def get_num_poses(self) -> int:
        """Return the number of frames."""
        return len(self._poses)

    def get_name(self, pose_index: int) -> str:
        """Return the name of a frame, ``source::frame``."""
        return self._poses[pose_index].name

    def get_model_instance_id(self, pose_index: int) -> int:
        """Return the group number of a frame."""
        return self._poses[pose_index].group

    def get_transform(self, pose_index: int) -> RigidTransform:
        """Return X_WF of a frame."""
        return self._poses[pose_index].X_WF


class PoseBundlePort:
    """Output port for the poses of frames with geometry of the illustration role."""

    __slots__ = ()

    def Eval(self, context: SceneGraphContext) -> PoseBundle:
        """Return the current poses; raises PoseError for a frame without one."""
        query = QueryObject(_checked_context(context, 'Eval'))
        links = links_of(query.inspector(), Role.kIllustration)
        return PoseBundle([_NamedPose(name, group, query.X_WF(f)) for f, name, group in links])
