"""``SceneGraph_[AutoDiffXd]``: a scene graph whose poses have derivatives, and its ports."""

from __future__ import annotations

from drake_geom_ros.geometry.autodiff.context import (
    SceneGraphContextAutoDiffXd,
    SceneGraphInspectorAutoDiffXd,
)
from drake_geom_ros.geometry.autodiff.poses import FramePoseVectorAutoDiffXd
from drake_geom_ros.geometry.autodiff.query_object import QueryObjectAutoDiffXd
from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.ids import SourceId
from drake_geom_ros.geometry.scene.scene_graph import SceneGraph


class SourcePosePortAutoDiffXd:
    """Input port for the poses of one source's frames, with derivatives."""

    def __init__(self, source_id: SourceId) -> None:
        self._source_id = source_id

    def FixValue(
        self, context: SceneGraphContextAutoDiffXd, value: FramePoseVectorAutoDiffXd
    ) -> None:
        """Set the poses of all frames of the source in a context."""
        checked_type(context, SceneGraphContextAutoDiffXd, 'FixValue: context')
        checked_type(value, FramePoseVectorAutoDiffXd, 'FixValue: value')
        context.SetFramePoses(self._source_id, value)


class QueryPortAutoDiffXd:
    """Output port for the query object of a context."""

    def Eval(self, context: SceneGraphContextAutoDiffXd) -> QueryObjectAutoDiffXd:
        """Return a live query object, which sees later poses of the context."""
        return QueryObjectAutoDiffXd(
            checked_type(context, SceneGraphContextAutoDiffXd, 'Eval: context')
        )


class SceneGraphAutoDiffXd(SceneGraph):
    """A ``SceneGraph`` whose frames have poses of AutoDiffXd; see ``docs/derivatives.md``.

    Registration is as in any scene. The same engine computes values, and all pairs of shapes have
    derivatives.
    """

    _context_type = SceneGraphContextAutoDiffXd

    def model_inspector(self) -> SceneGraphInspectorAutoDiffXd:
        """Return the inspector of this scene's model."""
        return SceneGraphInspectorAutoDiffXd(self._state.model, self._state.filters)

    def get_source_pose_port(  # type: ignore[override]
        self, source_id: SourceId
    ) -> SourcePosePortAutoDiffXd:
        """Return the input port for the poses of a source's frames, with derivatives."""
        self._state.model.source_name(source_id)
        return SourcePosePortAutoDiffXd(source_id)

    def get_query_output_port(self) -> QueryPortAutoDiffXd:  # type: ignore[override]
        """Return the output port for the query object of a context."""
        return QueryPortAutoDiffXd()
