"""The two calls that a pydrake script makes of a scene graph's ports."""

from __future__ import annotations

from drake_geom_ros.geometry.context import SceneGraphContext
from drake_geom_ros.geometry.errors import ArgumentTypeError
from drake_geom_ros.geometry.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.ids import SourceId
from drake_geom_ros.geometry.instances import checked_type
from drake_geom_ros.geometry.query_object import QueryObject


class SourcePosePort:
    """Takes the poses of one source's frames."""

    __slots__ = ('_source_id',)

    def __init__(self, source_id: SourceId) -> None:
        self._source_id = source_id

    def FixValue(self, context: SceneGraphContext, value: FramePoseVector) -> None:
        """Pose all frames of the source in a context, or none: see ``SetFramePoses``."""
        _checked_context(context, 'FixValue')
        checked_type(value, FramePoseVector, 'FixValue: value')
        context.SetFramePoses(self._source_id, value)


class QueryPort:
    """Gives the query object of a context."""

    __slots__ = ()

    def Eval(self, context: SceneGraphContext) -> QueryObject:
        """Return a live query object: one that sees later poses of the context."""
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
